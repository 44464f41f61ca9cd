"""Wrong gravity: another parameter of the body, another model, or another torque of the gradient."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from barchain.judge.diagnosis.altered_scenes.changes import constant, part
from barchain.judge.diagnosis.mistake import SceneMistake
from reference_impl.model.effect import ChainEffect, EffectAccelerations
from reference_impl.model.gravity import gradient_angular_accelerations
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import EffectState
    from scenarios import Scene

SECTION = "gravity"
MU_M3_S2 = (
    ("egm", "EGM2008, 3.986004415e14", 3.986004415e14),
    ("wgs84", "WGS 84, 3.986004418e14", 3.986004418e14),
    ("wgs84-first", "the first WGS 84, 3.986005e14", 3.986005e14),
    ("wgs72", "WGS 72, 3.986008e14", 3.986008e14),
    ("km3", "398600 km^3/s^2", 3.986e14),
    ("g-times-mass", "G times the Earth's mass, 6.674e-11 times 5.972e24", 6.674e-11 * 5.972e24),
)
RADIUS_M = (
    ("mean", "the mean radius, 6371 km", 6.371e6),
    ("equatorial", "the equatorial radius, 6378.137 km", 6378137.0),
    ("equatorial-rounded", "the equatorial radius, 6378 km", 6.378e6),
    ("paper", "6371.2 km", 6371200.0),
)


@final
@dataclass(frozen=True)
class AddedGradientTorque(ChainEffect):
    """The gravity gradient's torque once more, times `share`."""

    share: float | Array
    """One number, or one for each bar, (N,)"""
    name = "added gradient torque"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Torque over moment of inertia; no force."""
        del mode
        spin = gradient_angular_accelerations(at.model, at.position_from_body, at.unit)  # type: ignore[arg-type]
        return EffectAccelerations(0j, at.zero_acceleration, self.share * spin)


@final
@dataclass(frozen=True)
class TideAtEnd(ChainEffect):
    """Torque of the tide, if its force acts at an end of each bar instead of its centre."""

    side: float
    """-1: left ends, +1: right ends"""
    name = "tide at the ends"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Torque over moment of inertia; no force."""
        del mode
        place, com, mu = at.position_from_body, at.com, at.model.mu_m3_s2
        tide = -mu * (place / abs(place) ** 3 - com / abs(com) ** 3)
        spin = self.side * at.model.half_m * (at.unit.conj() * tide).imag / at.model.gyration2
        return EffectAccelerations(0j, at.zero_acceleration, spin)


@final
@dataclass(frozen=True)
class CancelledTide(ChainEffect):
    """Cancels the tide, which is the difference of each bar's gravity from that at the centre of mass."""

    name = "cancelled tide"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Differences alone; no torque."""
        del mode
        place, com, mu = at.position_from_body, at.com, at.model.mu_m3_s2
        tide = mu * (place / abs(place) ** 3 - com / abs(com) ** 3)
        return EffectAccelerations(0j, tide, at.zero_angular)


def with_effect(effect: ChainEffect, *, gradient: bool = False) -> Callable[[ChainModel], ChainModel]:
    """Model with one more effect; `gradient`: only of a model with the gravity gradient's torque."""

    def change(model: ChainModel) -> ChainModel:
        if model.gravity == "none" or (gradient and model.gravity != "gradient"):
            return model
        return dataclasses.replace(model, effects=(*model.effects, effect))

    return change


def without_torque(scene: Scene) -> Scene:
    """Point gravity in place of the paper's gradient."""
    if scene.effects.gravity is not Gravity.GRADIENT:
        return scene
    return with_gravity(Gravity.POINT)(scene)


def with_gravity(gravity: Gravity) -> Callable[[Scene], Scene]:
    """Another model of gravity."""
    return part("effects", gravity=constant(gravity))


def slender(scene: Scene) -> bool:
    """Whether all moments of inertia are those of slender bars, which exact gravity on slender bars requires."""
    chain = scene.chain
    each = zip(chain.mass_kg, chain.length_m, chain.inertia_kg_m2, strict=True)
    return all(math.isclose(inertia, m * size**2 / 12.0, rel_tol=1e-9) for m, size, inertia in each)


def other_gravity(gravity: Gravity) -> Callable[[Scene], Scene]:
    """Another model of gravity, but for the one that :func:`without_torque` makes."""

    def change(scene: Scene) -> Scene:
        same = scene.effects.gravity is Gravity.GRADIENT and gravity is Gravity.POINT
        if same or (gravity is Gravity.SLENDER and not slender(scene)):
            return scene
        return with_gravity(gravity)(scene)

    return change


def times_mu(factor: float) -> Callable[[Scene], float]:
    """The scene's gravitational parameter times a factor, m³/s²."""
    return lambda scene: factor * scene.central_body.mu_m3_s2


GRAVITY_WORDS = {
    Gravity.NONE: "the gravity is missing",
    Gravity.POINT: "the bars are point masses to gravity",
    Gravity.GRADIENT: "the gravity is that of the paper, a point mass' force with the gradient's torque",
    Gravity.QUADRUPOLE: "the gravity is expanded to the bars' second moments",
    Gravity.SLENDER: "the gravity is that on slender bars",
}
TORQUES = (
    ("reversed", "the torque of the gravity gradient has the opposite sign", -1.0),
    ("half", "the torque of the gravity gradient is half the right value", 0.5),
    ("twice", "the torque of the gravity gradient is twice the right value", 2.0),
    ("third", "the torque of the gravity gradient lacks its factor 3", 1.0 / 3.0),
    ("two-thirds", "the torque of the gravity gradient has the factor 2 instead of 3", 2.0 / 3.0),
)
MISTAKES = (
    SceneMistake("gradient-missing", "the torque of the gravity gradient is missing", SECTION, without_torque),
    *(
        SceneMistake(
            f"gradient-{name}", words, SECTION, model=with_effect(AddedGradientTorque(factor - 1.0), gradient=True)
        )
        for name, words, factor in TORQUES
    ),
    *(
        SceneMistake(
            f"tide-at-{name}-ends", f"the tidal forces act at the bars' {name} joints instead of their centres",
            SECTION, model=with_effect(TideAtEnd(side)),
        )
        for name, side in (("left", -1.0), ("right", 1.0))
    ),
    SceneMistake(
        "tide-missing",
        "the gravity on all bars is that at the centre of mass",
        SECTION,
        model=with_effect(CancelledTide()),
    ),
    *(SceneMistake(f"gravity-{g}", words, SECTION, other_gravity(g)) for g, words in GRAVITY_WORDS.items()),
    *(
        SceneMistake(
            f"mu-{name}", f"the gravitational parameter is that of {words}", SECTION,
            part("central_body", mu_m3_s2=constant(value)),
        )
        for name, words, value in MU_M3_S2
    ),
    *(
        SceneMistake(
            f"mu-{word}", f"the gravitational parameter is 0.1 % too {word}", SECTION,
            part("central_body", mu_m3_s2=times_mu(factor)),
        )
        for word, factor in (("large", 1.001), ("small", 0.999))
    ),
    *(
        SceneMistake(
            f"radius-{name}", f"the altitude counts from {words}", "orbit",
            part("central_body", radius_m=constant(value)),
        )
        for name, words, value in RADIUS_M
    ),
)  # fmt: skip
