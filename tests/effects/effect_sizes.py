"""Magnitudes that effects put into the accelerations of a state: what their rounding is counted in.

Each is the sum of the absolute values of an effect's terms, with every cosine and sine taken as one, so that it bounds
what is rounded on the way too, also where terms cancel.

Roundings on the way to a push: a bar's place 1, a unit vector 2, u·Z and n·Z 3 each, |Z|² 3, its powers up to the
seventh 4 x 3 + 3, Encke's change 14 (q 6, log1p and expm1 2 each, products and sum 4), a mean over three bars 4:
`C` = 32 of `joint_roundoff` is above any of these paths.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from reference_impl.model.arrays import Array
from reference_impl.model.chain import ChainModel
from reference_impl.model.state import State
from tests.support.joint_roundoff import C, Case


@dataclass(frozen=True)
class EffectSizes:
    """Of all effects of a model together."""

    acceleration: Array
    """(N,) m/s², less the common part"""
    spin: Array
    """(N,) rad/s²"""
    common: float
    """m/s²"""


def sizes(c: Case, t_s: float) -> EffectSizes:
    """Magnitudes of the effects of a chain in a state."""
    found = [SIZES[effect.name](effect, c.model, c.state, t_s) for effect in c.model.effects]
    nothing = np.zeros(c.model.bars)
    return EffectSizes(
        sum((f[0] for f in found), nothing), sum((f[1] for f in found), nothing), float(sum(f[2] for f in found))
    )


def distances(state: State) -> tuple[Array, Array, float]:
    """|Z_j|, |d_j| and |Z0|."""
    far = np.linalg.norm(state.com_m + state.position_m, axis=1)
    return far, np.linalg.norm(state.position_m, axis=1), float(np.linalg.norm(state.com_m))


def moment(mu: float, r: Array, model: ChainModel) -> Array:
    """(3 mu J/2m r⁴)(2 + 1 + 5)."""
    size: Array = 12.0 * mu * model.gyration2 / r**4
    return size


def quadrupole(_: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    r = distances(state)[0]
    return moment(model.mu_m3_s2, r, model), np.zeros(model.bars), 0.0


def slender(_: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    """Its small factors are made of terms up to 4 e."""
    r = distances(state)[0]
    return 4.0 * model.mu_m3_s2 * model.half_m**2 / r**4, 3.0 * model.mu_m3_s2 / r**3, 0.0


def oblateness(e: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    """(1+q)^(-5/2) - 1 is some 5 d/r, beside d itself."""
    r, d, r0 = distances(state)
    b, turns, second = e.strength_m5_s2, float(e.turns), float(e.second_moment)
    push = 3.0 * b / r0**5 * 6.0 * d + turns * second * 7.5 * b * model.gyration2 / r**6 * 10.0
    return push, turns * 15.0 * b / r**5, 3.0 * b / r0**4


def third_body(e: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    """(1+q)^(-3/2) - 1 is some 3 d/|Y|, beside d itself; the same of the tide at the centre of mass."""
    x = e.body_position(t_s)
    y = np.linalg.norm(state.com_m + state.position_m - np.array([x.real, x.imag]), axis=1)
    _, d, r0 = distances(state)
    push = e.mu_m3_s2 / y**3 * 5.0 * d + float(e.second_moment) * moment(e.mu_m3_s2, y, model)
    return push, float(e.turns) * 3.0 * e.mu_m3_s2 / y**3, e.mu_m3_s2 / e.distance_m**3 * 5.0 * r0


def drag(e: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    """The exponent of the density is a difference of distances over the scale height: four roundings count r/H."""
    r, _, r0 = distances(state)
    speed = np.linalg.norm(state.com_velocity_m_s + state.velocity_m_s, axis=1) + e.rotation_rad_s * r
    turning = np.abs(state.rate_rad_s) + e.rotation_rad_s
    high = 1.0 / e.scale_height_m
    thick = e.density_kg_m3 * np.exp((e.radius_m - r) * high) * (1.0 + 4.0 / C * r0 * high)
    length = model.length_m
    second, fourth = length**3 / 12.0, length**5 / 80.0
    pressed = 0.5 * e.width_m * thick * max(e.normal_coefficient, e.tangential_coefficient)
    force = pressed * (length * speed**2 + second * turning * (turning + 2.0 * high * speed))
    torque = pressed * (2.0 * second * speed * turning + high * (second * speed**2 + fourth * turning**2))
    return 2.0 * force / model.mass_kg, torque / model.inertia_kg_m2, 0.0


def solar_pressure(e: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    push = e.pressure_Pa * e.width_m * model.length_m / model.mass_kg * (1.0 + e.reflectivity)
    return push, np.zeros(model.bars), 0.0


def joint_spring_damper(e: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    angle, rate = np.abs(state.angle_rad), np.abs(state.rate_rad_s)
    torque = e.stiffness_N_m_rad * (angle[1:] + angle[:-1] + np.abs(e.rest_rad))
    torque = torque + e.damping_N_m_s_rad * (rate[1:] + rate[:-1])
    on_bars = np.zeros(model.bars)
    on_bars[1:] += torque
    on_bars[:-1] += torque
    return np.zeros(model.bars), on_bars / model.inertia_kg_m2, 0.0


def thrust(e: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    """The size between two knots is a mean of both."""
    force = np.zeros(model.bars)
    force[e.bar] = np.abs(e.sizes).max()
    return force / model.mass_kg, force * model.lever, 0.0


def joint_torque(e: Any, model: ChainModel, state: State, t_s: float) -> tuple[Array, Array, float]:
    """The size between two knots is a mean of both."""
    torque = np.zeros(model.bars)
    torque[e.joint : e.joint + 2] = np.abs(e.sizes).max()
    return np.zeros(model.bars), torque / model.inertia_kg_m2, 0.0


SIZES = {
    f.__name__: f
    for f in (
        quadrupole, slender, oblateness, third_body, drag, solar_pressure, joint_spring_damper, joint_torque, thrust,
    )
}  # fmt: skip
