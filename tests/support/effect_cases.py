"""Random chains with random effects: any bar length, any attitude, any orbit above the air."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.joint_torque import JointTorqueEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.slender import SlenderBarEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.model.chain import ChainModel
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.effect import ChainEffect, EffectState
from reference_impl.model.kinematics import consistent_state

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.model.arrays import Array
    from reference_impl.model.state import State

MU, RADIUS, J2 = 3.986004418e14, 6378e3, 1.08262668e-3
T_S = 600.0
"""Instant at which forces are looked at"""


def chain(random: np.random.Generator, bars: int, length_m: float, gravity: str = "point") -> ChainModel:
    """Uniform bars of lengths and masses within a factor of three."""
    mass, length = 100.0 * random.uniform(0.4, 1.2, bars), length_m * random.uniform(0.4, 1.2, bars)
    return ChainModel(MU, mass, length, mass * length**2 / 12.0, gravity)


def motion(random: np.random.Generator, model: ChainModel, height_m: tuple[float, float] = (2e5, 2e7)) -> State:
    """Any attitude, rates of a few turns per orbit, any bound orbit between two heights."""
    r = RADIUS + np.exp(random.uniform(*np.log(height_m)))
    radial = np.exp(1j * random.uniform(-np.pi, np.pi))
    velocity = np.sqrt(MU / r) * (random.uniform(-0.3, 0.3) + 1j * random.uniform(0.7, 1.2)) * radial
    angle = random.uniform(-np.pi, np.pi, model.bars)
    rate = np.sqrt(MU / r**3) * random.uniform(-3.0, 3.0, model.bars)
    place = r * radial
    return consistent_state(
        model, np.array([place.real, place.imag]), np.array([velocity.real, velocity.imag]), angle, rate
    )


def oblateness(random: np.random.Generator, *, turns: bool, second_moment: bool) -> OblatenessEffect:
    return OblatenessEffect(0.5 * MU * J2 * random.uniform(-1.0, 1.0) * RADIUS**2, turns, second_moment)


def third_body(random: np.random.Generator, *, turns: bool, second_moment: bool) -> ThirdBodyEffect:
    """From the Moon's distance to the Sun's, with tides like theirs."""
    distance = 10.0 ** random.uniform(8.5, 11.2)
    mu = 9e-14 * distance**3 * random.uniform(0.3, 3.0)
    rate = float(np.sqrt((MU + mu) / distance**3))
    return ThirdBodyEffect(mu, float(distance), float(random.uniform(-np.pi, np.pi)), rate, turns, second_moment)


def drag(random: np.random.Generator, model: ChainModel) -> DragEffect:
    width = model.length_m * random.uniform(0.001, 0.1, model.bars)
    return DragEffect(5e-11, RADIUS + 250e3, 45e3, 7.292115e-5, width, *random.uniform(0.5, 2.5, 2).tolist())


def sunlight(random: np.random.Generator, model: ChainModel, *, shadow: bool = True) -> SolarPressureEffect:
    width = model.length_m * random.uniform(0.001, 0.1, model.bars)
    longitude, share = random.uniform(-np.pi, np.pi), random.uniform(0.0, 1.0)
    return SolarPressureEffect(4.56e-6, float(longitude), 1.99e-7, width, float(share), RADIUS if shadow else 0.0)


def springs(random: np.random.Generator, model: ChainModel, *, damped: bool = True) -> JointSpringDamperEffect:
    joints, inertia = model.bars - 1, model.inertia_kg_m2[0]
    stiffness, damping = inertia * random.uniform(0.0, 1e-4, joints), inertia * random.uniform(0.0, 1e-2, joints)
    return JointSpringDamperEffect(stiffness, damping * damped, random.uniform(-0.5, 0.5, joints))


def motor(random: np.random.Generator, model: ChainModel) -> JointTorqueEffect:
    times, joint = np.sort(random.uniform(0.0, 2.0 * T_S, 4)), int(random.integers(max(model.bars - 1, 1)))
    return JointTorqueEffect(times, random.uniform(-0.1, 0.1, 4), joint)


def thrust(random: np.random.Generator, model: ChainModel) -> ThrustEffect:
    bar, side = int(random.integers(model.bars)), float(random.choice([-1.0, 1.0]))
    times = np.sort(random.uniform(0.0, 2.0 * T_S, 4))
    inertial, direction = bool(random.integers(2)), float(random.uniform(-np.pi, np.pi))
    return ThrustEffect(times, random.uniform(-0.02, 0.02, 4), bar, side, inertial, direction)


KINDS: dict[str, Callable[[np.random.Generator, ChainModel], ChainEffect]] = {
    "slender": lambda random, model: SlenderBarEffect(),
    "quadrupole": lambda random, model: QuadrupoleEffect(),
    "oblateness": lambda random, _: oblateness(random, turns=False, second_moment=False),
    "oblateness, turning": lambda random, _: oblateness(random, turns=True, second_moment=False),
    "oblateness, second moment": lambda random, _: oblateness(random, turns=True, second_moment=True),
    "third body": lambda random, _: third_body(random, turns=False, second_moment=False),
    "third body, turning": lambda random, _: third_body(random, turns=True, second_moment=False),
    "third body, second moment": lambda random, _: third_body(random, turns=True, second_moment=True),
    "drag": drag,
    "solar pressure": sunlight,
    "springs": springs,
    "motor": motor,
    "thrust": thrust,
}
"""Every effect, in every form it takes with the kinds of gravity"""


def seen(model: ChainModel, state: State, t_s: float = T_S) -> EffectState:
    """A state as effects see it in the relative formulation."""
    return EffectState(model, t_s, state, unit_along(state.angle_rad))


def seen_whole(model: ChainModel, state: State, t_s: float = T_S) -> EffectState:
    """The same in absolute coordinates."""
    origin = np.zeros(2)
    place, velocity = state.com_m + state.position_m, state.com_velocity_m_s + state.velocity_m_s
    whole = replace(state, com_m=origin, com_velocity_m_s=origin, position_m=place, velocity_m_s=velocity)
    return EffectState(model, t_s, whole, unit_along(state.angle_rad), absolute=True)


def reach_m(state: State) -> float:
    """Largest distance of a bar's centre from the common one."""
    return float(np.linalg.norm(state.position_m, axis=1).max())


def distance_m(state: State) -> float:
    """Of the centre of mass from the body's centre."""
    return float(np.linalg.norm(state.com_m))


def vectors(numbers: Array) -> Array:
    """Complex numbers as rows."""
    return np.stack([numbers.real, numbers.imag], axis=-1)
