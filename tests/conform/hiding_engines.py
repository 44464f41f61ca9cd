"""The reference with mistakes that hide: beside other effects, in rare numbers and samples, behind declared noise.

``tests.conform.hiding_engines:Right`` has no mistake; any other name of the tables is the engine with that mistake, in
the scene that it integrates, in an effect, at the start, or in what is read.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, AccuracySweep
from adapters.reference.compiled_engine import KernelEngine
from adapters.reference.numpy_engines import ReferenceNumPy
from reference_impl.effects import second_moment
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from tests.support.changed import under

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Setting
    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.effect import ChainEffect, EffectAccelerations, EffectState
    from scenarios import Effects, Scene

EARTH_MU = 3.986004418e14
FAR = 1e4
"""Factor of a third body's distance at which its tide is one of first order"""
BUFFER = 128
"""Samples that an engine of a fixed buffer keeps"""
NOISE_RAD = {
    "NoiseEndsJudgement": 1e-4,
    "NoiseHidesThrust": 9e-6,
    "NoiseHidesConstant": 9e-6,
    "HonestNoise": 3e-6,
    "FaintNoise": 3e-8,
}
"""Declared noise of the angles"""


def weaker(by: float) -> Callable[[Effects], dict[str, Any]]:
    """Change of effects: thrusts are smaller by a share."""
    share = 1.0 - by
    return lambda e: {
        "thrust": tuple(dataclasses.replace(t, force_N=tuple(share * f for f in t.force_N)) for t in e.thrust)
    }


def without_loads(e: Effects) -> dict[str, Any]:
    """Change of effects: none acts without gravity."""
    if e.gravity != "none":
        return {}
    several = dict.fromkeys(("third_body", "thrust", "joint_torque"), ())
    return several | dict.fromkeys(("oblateness", "drag", "solar_pressure", "joint_spring_damper"))


def softened(e: Effects, lost: slice) -> dict[str, Any]:
    """Change of effects: some joints have neither springs nor dampers."""
    spring = e.joint_spring_damper
    if spring is None:
        return {}
    stiffness, damping = list(spring.stiffness_N_m_rad), list(spring.damping_N_m_s_rad)
    stiffness[lost] = damping[lost] = [0.0] * len(stiffness[lost])
    soft = dataclasses.replace(spring, stiffness_N_m_rad=tuple(stiffness), damping_N_m_s_rad=tuple(damping))
    return {"joint_spring_damper": soft}


def far_bodies(e: Effects) -> dict[str, Any]:
    """Change of effects: tides to first order."""
    far = (dataclasses.replace(b, mu_m3_s2=FAR**3 * b.mu_m3_s2, distance_m=FAR * b.distance_m) for b in e.third_body)
    return {"third_body": tuple(far)}


IN_EFFECTS: dict[str, Callable[[Effects], dict[str, Any]]] = {
    "ThirdBodyOverwritesOblateness": lambda e: {"oblateness": None} if e.third_body else {},
    "ImpulseAtEndOfThrust": lambda e: {
        "impulse": tuple(i for i in e.impulse if i.at_s not in {t.times_s[-1] for t in e.thrust})
    },
    "OneImpulseAtATime": lambda e: {"impulse": tuple({i.at_s: i for i in reversed(e.impulse)}.values())},
    "LoadsNeedGravity": without_loads,
    "DragElseSunlight": lambda e: {"solar_pressure": None} if e.drag else {},
    "TwoSprings": lambda e: softened(e, slice(2, None)),
    "TwoThrusts": lambda e: {"thrust": e.thrust[:2]},
    "TwoThirdBodies": lambda e: {"third_body": e.third_body[:2]},
    "ThrustsArePositive": lambda e: {
        "thrust": tuple(dataclasses.replace(t, force_N=tuple(map(abs, t.force_N))) for t in e.thrust)
    },
    "DampersNeedSprings": lambda e: (
        softened(e, slice(None)) if not any(e.joint_spring_damper.stiffness_N_m_rad) else {}  # type: ignore[union-attr]
    ),
    "TideToFirstOrder": far_bodies,
    "NoiseHidesThrust": weaker(5e-7),
    "NoiseEndsJudgement": weaker(5e-6),
}
"""Changes of a scene's effects"""


def acting(
    effect: ChainEffect, change: Callable[[EffectAccelerations, EffectState], EffectAccelerations]
) -> ChainEffect:
    """Effect whose accelerations are changed."""
    kind: Any = type(effect)

    class Wrong(kind):  # type: ignore[misc]
        def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
            return change(effect.accelerations(at, mode), at)

    found: ChainEffect = Wrong(**vars(effect))
    return found


def on_uniform_bars(effect: ChainEffect) -> ChainEffect:
    """Effect on second moments of uniform bars."""
    points: Any = dataclasses.replace(effect, second_moment=False)  # type: ignore[type-var]

    def wrong(found: EffectAccelerations, at: EffectState) -> EffectAccelerations:
        plain = points.accelerations(at, None)
        ratio = at.model.mass_kg * at.model.length_m**2 / 12.0 / at.model.inertia_kg_m2
        difference = plain.difference + ratio * (found.difference - plain.difference)
        return found._replace(difference=difference, angular=ratio * found.angular)

    return acting(effect, wrong)


def off_in_thrust(effect: ChainEffect, scene: Scene) -> ChainEffect:
    """Springs that do nothing while a thrust acts."""

    def wrong(found: EffectAccelerations, at: EffectState) -> EffectAccelerations:
        thrusting = any(t.times_s[0] < at.t_s < t.times_s[-1] for t in scene.effects.thrust)
        return found._replace(angular=0.0 * found.angular) if thrusting else found

    return acting(effect, wrong)


def back_from_the_sixth_bar(found: EffectAccelerations, at: EffectState) -> EffectAccelerations:
    """Accelerations that take the gradient's torque from the sixth bar on."""
    torque = second_moment.angular_accelerations(at.model.mu_m3_s2, at.position_from_body, at.unit)
    return found._replace(
        difference=0.0 * found.difference, angular=np.where(np.arange(at.model.bars) < 5, 0.0, -torque)
    )


IN_AN_EFFECT: dict[str, tuple[type[ChainEffect], Callable[[Any, Scene], ChainEffect]]] = {
    "SpringsOffInThrust": (JointSpringDamperEffect, off_in_thrust),
    "OblatenessWithoutMoment": (OblatenessEffect, lambda e, _: dataclasses.replace(e, second_moment=False)),
    "OblatenessOnUniformBars": (OblatenessEffect, lambda e, _: on_uniform_bars(e)),
    "OblatenessOfEarth": (
        OblatenessEffect,
        lambda e, scene: dataclasses.replace(
            e, strength_m5_s2=e.strength_m5_s2 * EARTH_MU / scene.central_body.mu_m3_s2
        ),
    ),
    "ThirdBodyWithoutMoment": (ThirdBodyEffect, lambda e, _: dataclasses.replace(e, second_moment=False)),
    "ThirdBodyOnUniformBars": (ThirdBodyEffect, lambda e, _: on_uniform_bars(e)),
}
"""Kind of an effect, and what takes its place"""


def in_a_buffer(found: Any, _scene: Scene, _setting: Setting) -> Trajectory:
    """Reactions of which the later ones are the last that a buffer holds."""
    reaction = found.reaction_N.copy()
    reaction[BUFFER:] = reaction[BUFFER - 1 : BUFFER]
    return found.replace(reaction_N=reaction)


def track_of_a_frame(found: Any, scene: Scene, _setting: Setting) -> Trajectory:
    """Kepler's orbit in the place of the track."""
    if scene.effects.gravity == "none":
        return found
    start = found.com_m[0], found.com_velocity_m_s[0]
    com, velocity = propagate(scene.central_body.mu_m3_s2, *start, scene.times_s)
    return found.replace(com_m=com, com_velocity_m_s=velocity)


def noisy(amplitude: float) -> Callable[[Any, Scene, Setting], Trajectory]:
    """Angles with other digits at each setting."""

    def read(found: Any, scene: Scene, setting: Setting) -> Trajectory:
        digits = np.random.default_rng(int(1e12 * setting.value) + scene.bars)
        return found.replace(angle_rad=found.angle_rad + amplitude * digits.uniform(-1.0, 1.0, found.angle_rad.shape))

    return read


def right_at_the_finest(found: Any, _scene: Scene, setting: Setting) -> Trajectory:
    """Angles of seven digits, but at the finest settings."""
    if setting.value <= 5e-12:
        return found
    digits = np.random.default_rng(int(1e6 * abs(math.sin(1e9 * setting.value + found.com_m[-1].sum() * 1e6))))
    return found.replace(angle_rad=found.angle_rad * (1.0 + 1e-7 * digits.standard_normal(found.angle_rad.shape)))


WHEN_READ: dict[str, Callable[[Any, Scene, Setting], Trajectory]] = {
    "ReactionsInABuffer": in_a_buffer,
    "UnwrapsAtSamples": lambda t, *_: t.replace(angle_rad=np.unwrap(t.angle_rad, axis=0)),
    "TrackOfAFrame": track_of_a_frame,
    "NoiseHidesConstant": lambda t, *_: t.replace(
        angle_rad=t.angle_rad + 1.5e-6 * np.minimum(1.0, t.t_s / 100.0)[:, None]
    ),
    "HonestNoise": noisy(1e-6),
    "FaintNoise": noisy(1e-8),
    "RightAtTheFinest": right_at_the_finest,
}
"""Changes of a trajectory"""
OTHERS = ("SixthBarWithoutTorque", "SlowStartsClipped", "ClosedOrbitsOnly")
"""Mistakes of the start and of the central body's gravity"""
MISTAKES = frozenset({"Right", *IN_EFFECTS, *IN_AN_EFFECT, *WHEN_READ, *OTHERS})


class Mistaken:
    """Mistake of a name, before an engine of the reference."""

    mistake: ClassVar[str]
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-5, 1e-7, 1e-9, 1e-11), 1e-9)

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Noise of the angles with mistakes that it hides."""
        del scene, setting, t_s
        return {"attitude": NOISE_RAD[cls.mistake]} if cls.mistake in NOISE_RAD else {}

    def build(self, scene: Scene, setting: Setting) -> None:
        change = IN_EFFECTS.get(self.mistake, lambda _: {})
        self.scene, self.setting = scene, setting
        super().build(under(scene, **change(scene.effects)), setting)  # type: ignore[misc]

    def prepare(self, model: Any, start: Any, rtol: float) -> Any:
        speed = self.scene.orbit.speed_factor
        if self.mistake == "SlowStartsClipped":
            start = dataclasses.replace(start, com_velocity_m_s=start.com_velocity_m_s * max(1.0, speed) / speed)
        if self.mistake == "ClosedOrbitsOnly" and speed**2 >= 2.0:
            model = dataclasses.replace(model, gravity="point")
        effects = list(model.effects)
        if self.mistake in IN_AN_EFFECT:
            kind, other = IN_AN_EFFECT[self.mistake]
            effects = [other(e, self.scene) if isinstance(e, kind) else e for e in effects]
        if self.mistake == "SixthBarWithoutTorque" and model.gravity == "gradient":
            effects.append(acting(QuadrupoleEffect(), back_from_the_sixth_bar))
        return super().prepare(dataclasses.replace(model, effects=tuple(effects)), start, rtol)  # type: ignore[misc]

    def read(self) -> Trajectory:
        found: Trajectory = super().read()  # type: ignore[misc]
        change = WHEN_READ.get(self.mistake)
        return change(found, self.scene, self.setting) if change else found


def __getattr__(name: str) -> type:
    """Engine with the mistake of a name: compiled, but where an effect is changed."""
    if name not in MISTAKES:
        raise AttributeError(name)
    in_numpy = name in IN_AN_EFFECT or name == "SixthBarWithoutTorque"
    base, own = (ReferenceNumPy, {"coordinate_set": "minimal"}) if in_numpy else (KernelEngine, {"wide": False})
    declared = {"title": "the reference, mistaken", "coordinates": KernelEngine.coordinates, "mistake": name}
    return type(name, (Mistaken, base), declared | own)
