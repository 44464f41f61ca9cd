"""Forces too strong, too weak, of the wrong sign or missing; mostly by way of the scene."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

from barchain.studies.selftest.faults import reasons
from barchain.studies.selftest.faults.equations import PART, PERCENT
from barchain.studies.selftest.faults.fault import Fault, FaultGroup, Size
from reference_impl.effects import impulse
from reference_impl.effects.slender import SlenderBarEffect
from reference_impl.model import relative
from reference_impl.model.gravity import gradient_angular_accelerations
from reference_impl.model.relative import ReactionSolution
from scenarios import Actuator, Axes, End, Frame, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager
    from enum import Enum

    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import SceneChange
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.effect import EffectAccelerations, EffectState
    from scenarios import Scene

SIMPLER = {
    Gravity.SLENDER: Gravity.QUADRUPOLE,
    Gravity.QUADRUPOLE: Gravity.GRADIENT,
    Gravity.GRADIENT: Gravity.POINT,
}
"""Another model of gravity, the next simpler one"""


def effect(name: str, change: Callable[[Any, float], Any]) -> SceneChange:
    """Change of one effect: of each, where there are several."""

    def changed(scene: Scene, size: float) -> Scene:
        was = getattr(scene.effects, name)
        now: Any = tuple(change(one, size) for one in was) if isinstance(was, tuple) else change(was, size)
        called: dict[str, Any] = {name: now}
        return replace(scene, effects=replace(scene.effects, **called))

    return changed


def stronger(name: str, *fields: str) -> SceneChange:
    """Effect with some of its numbers a part larger."""

    def change(one: Any, size: float) -> Any:
        return replace(one, **{f: times(getattr(one, f), 1.0 + size) for f in fields})

    return effect(name, change)


def times(value: Any, factor: float) -> Any:
    """Number, or each of several, times a factor."""
    return tuple(v * factor for v in value) if isinstance(value, tuple) else value * factor


def exchanged(name: str, field: str, words: type[Enum]) -> SceneChange:
    """Effect with the other one of two words in a field."""
    return effect(name, lambda one, _: replace(one, **{field: next(w for w in words if w is not getattr(one, field))}))


def set_to(name: str, **values: Any) -> SceneChange:
    """Effect with some of its fields as given."""
    return effect(name, lambda one, _: replace(one, **values))


@contextlib.contextmanager
def torque_times(factor: float) -> Iterator[None]:
    """Gravity's torques on all bars scaled, by either model."""
    slender = SlenderBarEffect.accelerations

    def push(self: SlenderBarEffect, at: EffectState, mode: Array | None) -> EffectAccelerations:
        right = slender(self, at, mode)
        return right._replace(angular=factor * right.angular)

    with (
        patch.object(
            relative, "gradient_angular_accelerations", lambda *given: factor * gradient_angular_accelerations(*given)
        ),
        patch.object(SlenderBarEffect, "accelerations", push),
    ):
        yield


def point_pull(size: float) -> AbstractContextManager[object]:
    """Exact bars pulled as point masses, their torque kept."""
    slender = SlenderBarEffect.accelerations

    def push(self: SlenderBarEffect, at: EffectState, mode: Array | None) -> EffectAccelerations:
        right = slender(self, at, mode)
        return right._replace(difference=(1.0 - size) * right.difference)

    return patch.object(SlenderBarEffect, "accelerations", push)


def impulse_lever(size: float) -> AbstractContextManager[object]:
    """Impulsive reactions that turn the bars the wrong way."""
    del size

    class WrongImpulse(ReactionSolution):
        def rotation_from_reactions(self, reaction: ComplexArray) -> Array:
            return -super().rotation_from_reactions(reaction)

    return patch.object(impulse, "ReactionSolution", WrongImpulse)


def stronger_pull(scene: Scene, size: float) -> Scene:
    """Scene whose central body is too heavy, started as it should be."""
    body, orbit = scene.central_body, scene.orbit
    return replace(
        scene,
        central_body=replace(body, mu_m3_s2=body.mu_m3_s2 * (1.0 + size)),
        orbit=replace(orbit, speed_factor=orbit.speed_factor * (1.0 + size) ** -0.5),
    )


def simplest(solution: ReferenceSolution) -> str:
    """Scenes whose gravity has a simpler model."""
    return "" if solution.scene.effects.gravity in SIMPLER else "gravity has no simpler model that is not none at all"


OBLATE = reasons.needs("oblateness", "oblateness")
BODIES = reasons.needs("third_body", "third body")
DRAG = reasons.needs("drag", "drag")
LIGHT = reasons.needs("solar_pressure", "sunlight")
SPRINGS = reasons.needs("joint_spring_damper", "springs or dampers")
MOTORS = reasons.needs("joint_torque", "torque of a joint's motor")
THRUST = reasons.needs("thrust", "thrust")
FORCES = FaultGroup.FORCES
FAULTS = (
    Fault("gravity-torque-off", "no gravity torque (or a part of it less)", "a load not switched on", FORCES,
          code=lambda s: torque_times(1.0 - s), size=PART, nothing=reasons.turning),
    Fault("gravity-torque-sign", "gravity torque of the wrong sign", "phi from the vertical", FORCES,
          code=lambda _: torque_times(-1.0), nothing=reasons.turning),
    Fault("slender-force", "exact bars pulled as point masses, with their torque", "a torque without its force",
          FORCES, code=point_pull, size=PART, nothing=reasons.exact_bars),
    Fault("mu", "mu too large in the pull, the start right", "another body, or a rounded constant", FORCES,
          scene=stronger_pull, size=Size(1e-6, most=1.0), nothing=reasons.gravity),
    Fault("gravity-model", "the next simpler model of gravity", "a load not switched on", FORCES,
          scene=lambda s, _: replace(s, effects=replace(s.effects, gravity=SIMPLER[s.effects.gravity])),
          nothing=simplest),
    Fault("j2", "J2 too large", "another field model", FORCES, scene=stronger("oblateness", "j2"), size=PERCENT,
          nothing=OBLATE),
    Fault("third-body", "Moon and Sun too heavy", "a wrong ephemeris constant", FORCES,
          scene=stronger("third_body", "mu_m3_s2"), size=PERCENT, nothing=BODIES),
    Fault("drag", "drag coefficients too large", "a wrong coefficient or area", FORCES,
          scene=stronger("drag", "normal_coefficient", "tangential_coefficient"), size=PERCENT, nothing=DRAG),
    Fault("still-air", "air that does not turn with the body", "inertial for relative velocity", FORCES,
          scene=set_to("drag", rotation_rad_s=0.0), nothing=DRAG),
    Fault("light", "sunlight too strong", "a wrong solar constant", FORCES,
          scene=stronger("solar_pressure", "pressure_Pa"), size=PERCENT, nothing=LIGHT),
    Fault("black", "no light reflected", "a coefficient left at its default", FORCES,
          scene=set_to("solar_pressure", reflectivity=0.0), nothing=LIGHT),
    Fault("shadow-missing", "sunlight in the body's shadow", "an event not looked for", FORCES,
          scene=set_to("solar_pressure", shadow=False), nothing=reasons.shadow),
    Fault("springs", "joint springs too stiff", "degrees for radians, to a part", FORCES,
          scene=stronger("joint_spring_damper", "stiffness_N_m_rad"), size=PERCENT, nothing=SPRINGS),
    Fault("dampers", "joint dampers too strong", "a wrong coefficient", FORCES,
          scene=stronger("joint_spring_damper", "damping_N_m_s_rad"), size=PERCENT, nothing=SPRINGS),
    Fault("joint-torque", "torques of joints' motors too strong", "a wrong gear ratio", FORCES,
          scene=stronger("joint_torque", "torque_N_m"), size=PERCENT, nothing=MOTORS),
    Fault("thrust", "thrust too strong", "a wrong calibration", FORCES, scene=stronger("thrust", "force_N"),
          size=PERCENT, nothing=THRUST),
    Fault("thrust-axes", "thrust's direction in the other axes", "body axes for inertial ones", FORCES,
          scene=exchanged("thrust", "axes", Axes), nothing=THRUST),
    Fault("thrust-end", "thrust on the bar's other end", "left for right", FORCES,
          scene=exchanged("thrust", "end", End), nothing=THRUST),
    Fault("impulse-size", "impulses too strong", "a wrong size", FORCES,
          scene=stronger("impulse", "impulse_N_s"), size=PERCENT, nothing=reasons.impulses),
    Fault("impulse-reaction-sign", "impulsive reactions turn the bars the wrong way", "a sign in the jump", FORCES,
          code=impulse_lever, nothing=reasons.impulses),
    Fault("impulse-end", "impulses on the bar's other end", "left for right", FORCES,
          scene=exchanged("impulse", "end", End), nothing=reasons.impulses),
    Fault("slew", "slews by too large an angle", "a wrong amplitude of eq. (28)", FORCES,
          scene=stronger("prescribed_rotation", "amplitude_rad"), size=PERCENT, nothing=reasons.SLEW),
    Fault("slew-frame", "slews against the other direction: inertial axes or the local horizontal",
          "the paper leaves it open", FORCES, scene=exchanged("prescribed_rotation", "frame", Frame),
          nothing=reasons.SLEW),
    Fault("slew-counter-torque", "the torque of a slew from outside for a motor in the joint, and the other way round",
          "a counter-torque forgotten", FORCES, scene=exchanged("prescribed_rotation", "actuator", Actuator),
          nothing=reasons.first_of(reasons.SLEW, reasons.joints)),
)  # fmt: skip
