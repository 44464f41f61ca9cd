"""How much round-off one effect's push may show: roundings x u x the sizes of what is added.

Roundings on the way to a push: a bar's place 1, a unit vector 2, u·Z and n·Z 3 each, |Z|² 3, its powers up to the
seventh 4 x 3 + 3, Encke's change 14 (q 6, log1p and expm1 2 each, products and sum 4), a mean over three bars 4:
`C` = 32 is above any of these paths. A third body's own place adds the rounding of its angle, up to 2 pi: 16 u.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.joint_torque import JointTorqueEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.effects.thrust import ThrustEffect
from tests.support.effect_cases import distance_m, reach_m

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import ChainEffect
    from reference_impl.model.state import State

U = 2.0**-53
C = 32.0


@dataclass(frozen=True)
class Bounds:
    """What is added, at most over the bars."""

    whole: float
    """m/s², of one bar's acceleration"""
    apart: float
    """m/s², of the differences between bars"""
    spin: float
    """rad/s²"""
    roundings: float = C


def bounds(effect: ChainEffect, model: ChainModel, state: State) -> Bounds:
    """Sizes of an effect's terms at a state."""
    if isinstance(effect, JointTorqueEffect):
        return Bounds(0.0, 0.0, float(np.abs(effect.sizes).max() / model.inertia_kg_m2[effect.joint :][:2].min()))
    if isinstance(effect, (DragEffect, SolarPressureEffect, JointSpringDamperEffect, ThrustEffect)):
        return pushes(effect, model, state)
    r, reach, gyration = distance_m(state) - reach_m(state), reach_m(state), float(model.gyration2.max())
    if isinstance(effect, OblatenessEffect):
        b = abs(effect.strength_m5_s2)
        shape = 10.0 * 7.5 * b * gyration / r**6 * effect.second_moment  # Z + 2 (u·Z) u - 7 c² Z
        return Bounds(3.0 * b / r**4 + shape, (1.0 + 5.0) * 3.0 * b / r**5 * reach + shape, 15.0 * b / r**5)
    if isinstance(effect, ThirdBodyEffect):
        near = effect.distance_m - distance_m(state) - reach
        strength = effect.mu_m3_s2 / near**3
        shape = 8.0 * 1.5 * strength * gyration / near
        tide = (1.0 + 3.0) * strength
        return Bounds(tide * distance_m(state) + shape, tide * reach + shape, 3.0 * strength, C + 16.0)
    shape = 8.0 * 1.5 * model.mu_m3_s2 * gyration / r**4  # 2 (u·Z) u + Z - 5 c² Z
    return Bounds(shape, shape, 3.0 * model.mu_m3_s2 / r**3)


def pushes(
    effect: DragEffect | SolarPressureEffect | JointSpringDamperEffect | ThrustEffect, model: ChainModel, state: State
) -> Bounds:
    """Of what is no field: nothing of it is common to all bars."""
    if isinstance(effect, DragEffect):
        return air(effect, model, state)
    if isinstance(effect, SolarPressureEffect):
        light = float((effect.pressure_Pa * effect.width_m * model.length_m / model.mass_kg).max())
        return Bounds(2.0 * light, 2.0 * light, 0.0)
    if isinstance(effect, JointSpringDamperEffect):
        return Bounds(0.0, 0.0, wound(effect, model, state))
    force = float(np.abs(effect.sizes).max())
    push = force / float(model.mass_kg[effect.bar])
    return Bounds(push, push, force * float(model.lever[effect.bar]))


def air(effect: DragEffect, model: ChainModel, state: State) -> Bounds:
    """Drag; the density turns four roundings of a radius into as many times r/H."""
    r, lowest = distance_m(state) + reach_m(state), distance_m(state) - reach_m(state)
    turning = np.abs(state.rate_rad_s).max() + effect.rotation_rad_s
    speed = np.linalg.norm(state.com_velocity_m_s) + effect.rotation_rad_s * r + model.length_m.sum() * turning
    density = effect.density_kg_m3 * np.exp((effect.radius_m - lowest) / effect.scale_height_m)
    most = max(effect.normal_coefficient, effect.tangential_coefficient)
    uneven = 1.0 + model.half_m / effect.scale_height_m
    force = effect.width_m * density * most * model.length_m * speed**2 * uneven
    push, spin = float((force / model.mass_kg).max()), float((force * model.lever).max())
    return Bounds(push, push, spin, C + 4.0 * r / effect.scale_height_m)


def wound(effect: JointSpringDamperEffect, model: ChainModel, state: State) -> float:
    """Angular acceleration by all torques at their largest."""
    angle, rate = np.abs(state.angle_rad), np.abs(state.rate_rad_s)
    bent = angle[1:] + angle[:-1] + np.abs(effect.rest_rad)
    torque: Array = effect.stiffness_N_m_rad * bent + effect.damping_N_m_s_rad * (rate[1:] + rate[:-1])
    return float(2.0 * torque.max() / model.inertia_kg_m2.min())
