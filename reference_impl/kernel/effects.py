"""Constants of the effects as the kernel reads them; each struct is that of ``c/effects/<name>.h``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from reference_impl.kernel.packing import DOUBLE, Matrix, Number, Struct, Vector

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.effects.drag import DragEffect
    from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
    from reference_impl.effects.joint_torque import JointTorqueEffect
    from reference_impl.effects.oblateness import OblatenessEffect
    from reference_impl.effects.solar_pressure import SolarPressureEffect
    from reference_impl.effects.third_body import ThirdBodyEffect
    from reference_impl.effects.thrust import ThrustEffect
    from reference_impl.model.effect import ChainEffect


@dataclass(frozen=True)
class EffectConstants(Struct):
    """Constants and mode of one effect; each effect's are below."""

    def shapes(self, bars: int) -> dict[str, tuple[int, ...]]:
        """Shapes of its arrays for a chain of `bars` bars."""
        del bars
        return {}


@dataclass(frozen=True)
class CompiledEffect(Struct):
    """One effect in compiled code."""

    kind: int
    """Index in `KINDS`"""
    own: Struct
    """Its :class:`EffectConstants`"""

    @property
    def mode(self) -> Vector:
        """Mode of the effect, set by the caller; (0,) for an effect without modes."""
        found: Vector = getattr(self.own, "mode", np.zeros(0))
        return found


Effects = tuple[CompiledEffect, ...]


@dataclass(frozen=True)
class CompiledDrag(EffectConstants):
    """Drag in compiled code."""

    density_kg_m3: float
    radius_m: float
    scale_height_m: float
    rotation_rad_s: float
    normal_coefficient: float
    tangential_coefficient: float
    width_m: Vector
    """(N,)"""
    mode: Vector
    """(N,) face in the wind: 1 or -1"""

    def shapes(self, bars: int) -> dict[str, tuple[int, ...]]:
        """One width and one face for each bar."""
        return {"width_m": (bars,), "mode": (bars,)}


@dataclass(frozen=True)
class CompiledSprings(EffectConstants):
    """Springs and dampers in compiled code."""

    table: Matrix
    """(3, N-1) rows of stiffness, N m/rad, damping, N m s/rad, and rest angle, rad"""

    def shapes(self, bars: int) -> dict[str, tuple[int, ...]]:
        """One column for each joint."""
        return {"table": (3, bars - 1)}


@dataclass(frozen=True)
class CompiledJointTorque(EffectConstants):
    """Torque of a joint's motor in compiled code."""

    joint: int
    table: Matrix
    """(2, k) rows of instants, s, and torques, N m"""
    mode: Vector
    """(1,) segment of the table; -1: none"""

    def shapes(self, bars: int) -> dict[str, tuple[int, ...]]:
        """Two or more columns of the table."""
        if not 0 <= self.joint < bars - 1:
            raise ValueError(f"torque in joint {self.joint}, allowed: 0 to {bars - 2}")
        return {"table": (2, max(2, self.table.shape[1])), "mode": (1,)}


@dataclass(frozen=True)
class CompiledOblateness(EffectConstants):
    """J2 in compiled code."""

    strength_m5_s2: float
    """B"""
    turns: int
    """1 with torque on second moments"""
    second_moment: int
    """1 with force on second moments"""


@dataclass(frozen=True)
class CompiledFieldOfBars(EffectConstants):
    """Effect of gravity on extended bars, without constants of its own."""


@dataclass(frozen=True)
class CompiledSunlight(EffectConstants):
    """Solar pressure in compiled code."""

    pressure_Pa: float
    longitude_rad: float
    rate_rad_s: float
    reflectivity: float
    shadow_radius_m: float
    width_m: Vector
    """(N,)"""
    side_m: Vector
    """(1,) previous distance from the shadow's axis"""
    mode: Vector
    """(1+N,) light 1 or shadow 0, and face of each bar"""

    def shapes(self, bars: int) -> dict[str, tuple[int, ...]]:
        """One width and one face for each bar."""
        return {"width_m": (bars,), "side_m": (1,), "mode": (1 + bars,)}


@dataclass(frozen=True)
class CompiledThirdBody(EffectConstants):
    """Third body in compiled code."""

    mu_m3_s2: float
    distance_m: float
    longitude_rad: float
    rate_rad_s: float
    turns: int
    """1 with torque on second moments"""
    second_moment: int
    """1 with force on second moments"""


@dataclass(frozen=True)
class CompiledThrust(EffectConstants):
    """Thrust in compiled code."""

    bar: int
    side: float
    """-1 at the first end, 1 at the other"""
    inertial: int
    """1 for a direction in the inertial frame, 0 in the bar's"""
    direction: Vector
    """(2,) forwards and leftwards"""
    table: Matrix
    """(2, k) rows of instants, s, and forces, N"""
    mode: Vector
    """(1,) segment of the table; -1: none"""

    def shapes(self, bars: int) -> dict[str, tuple[int, ...]]:
        """Two or more columns of the table."""
        if not 0 <= self.bar < bars:
            raise ValueError(f"thrust on bar {self.bar}, allowed: 0 to {bars - 1}")
        return {"direction": (2,), "table": (2, max(2, self.table.shape[1])), "mode": (1,)}


def drag(effect: DragEffect, number: Number) -> CompiledDrag:
    """Constants of the atmosphere, and the bars' widths."""
    return CompiledDrag(
        effect.density_kg_m3,
        effect.radius_m,
        effect.scale_height_m,
        effect.rotation_rad_s,
        effect.normal_coefficient,
        effect.tangential_coefficient,
        np.array(effect.width_m, dtype=number),
        np.ones(len(effect.width_m), number),
    )


def springs(effect: JointSpringDamperEffect, number: Number) -> CompiledSprings:
    """Table of the joints."""
    rows = effect.stiffness_N_m_rad, effect.damping_N_m_s_rad, effect.rest_rad
    return CompiledSprings(np.array(rows, dtype=number))


def joint_torque(effect: JointTorqueEffect, number: Number) -> CompiledJointTorque:
    """Joint, and the table of instants, s, and torques, N m."""
    table = np.array([effect.times_s, effect.sizes], dtype=number)
    return CompiledJointTorque(effect.joint, table, np.full(1, -1.0, number))


def oblateness(effect: OblatenessEffect, _: Number) -> CompiledOblateness:
    """Strength and switches."""
    return CompiledOblateness(effect.strength_m5_s2, int(effect.turns), int(effect.turns and effect.second_moment))


def field_of_bars(_: ChainEffect, __: Number) -> CompiledFieldOfBars:
    """Struct without constants."""
    return CompiledFieldOfBars()


def sunlight(effect: SolarPressureEffect, number: Number) -> CompiledSunlight:
    """Constants of light and shadow, and the bars' widths."""
    return CompiledSunlight(
        effect.pressure_Pa,
        effect.longitude_rad,
        effect.rate_rad_s,
        effect.reflectivity,
        effect.shadow_radius_m,
        np.array(effect.width_m, dtype=number),
        np.zeros(1, number),
        np.ones(1 + len(effect.width_m), number),
    )


def third_body(effect: ThirdBodyEffect, _: Number) -> CompiledThirdBody:
    """Mass, orbit and switches."""
    return CompiledThirdBody(
        effect.mu_m3_s2,
        effect.distance_m,
        effect.longitude_rad,
        effect.rate_rad_s,
        int(effect.turns),
        int(effect.second_moment),
    )


def thrust(effect: ThrustEffect, number: Number) -> CompiledThrust:
    """Point and direction of application, and the table of instants, s, and forces, N."""
    direction = number(effect.direction_rad)
    turned = np.array([np.cos(direction), np.sin(direction)], dtype=number)
    return CompiledThrust(
        effect.bar,
        effect.side,
        int(effect.inertial),
        turned,
        np.array([effect.times_s, effect.sizes], dtype=number),
        np.full(1, -1.0, number),
    )


KINDS: dict[str, Callable[[Any, Number], EffectConstants]] = {
    "drag": drag,
    "joint_spring_damper": springs,
    "joint_torque": joint_torque,
    "oblateness": oblateness,
    "quadrupole": field_of_bars,
    "slender": field_of_bars,
    "solar_pressure": sunlight,
    "third_body": third_body,
    "thrust": thrust,
}
"""Constants of each effect by its name, in the order of ``EFFECTS`` in ``c/effects/all.h``"""


def compiled_effect(effect: ChainEffect, number: Number = DOUBLE) -> CompiledEffect:
    """Kind and constants of one effect."""
    return CompiledEffect(list(KINDS).index(effect.name), KINDS[effect.name](effect, number))
