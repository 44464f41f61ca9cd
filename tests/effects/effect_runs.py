"""Runs of the reference with effects: their error's budget, their events, and the work that is done in them.

DOP853 may err by `rtol` in each step, in units of each block's own scale; a rate's error shifts its angle or place by
itself times the time (`budget`).
"""

from collections.abc import Callable

import numpy as np

from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.integrate.coordinate_sets import CoordinateSet, MinimalCoordinates
from reference_impl.integrate.simulate import History, Simulation
from reference_impl.model import relative
from reference_impl.model.arrays import Array
from reference_impl.model.chain import ChainModel
from reference_impl.model.effect import Modes
from reference_impl.model.invariants import (
    com_angular_momentum,
    com_energy,
    relative_angular_momentum,
    relative_kinetic_energy,
    tidal_energy,
)
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.state import State

RTOL = 1e-11


def started(
    model: ChainModel, state: State, *, rtol: float = RTOL, coordinates: CoordinateSet = "minimal"
) -> Simulation:
    """A run from a joined state."""
    start = (state.com_m, state.com_velocity_m_s, state.angle_rad, state.rate_rad_s)
    return Simulation(model, *start, rtol=rtol, coordinates=coordinates)


def ran(
    model: ChainModel, state: State, t_s: Array, *, rtol: float = RTOL, coordinates: CoordinateSet = "minimal"
) -> History:
    """What is seen in it."""
    run = started(model, state, rtol=rtol, coordinates=coordinates)
    return run.history(run.integrate(t_s))


def placed(model: ChainModel, r_m: float, speed_m_s: float, angle_rad: Array, rate_rad_s: Array) -> State:
    """A chain on the z1 axis, moving along z2."""
    return consistent_state(model, np.array([r_m, 0.0]), np.array([0.0, speed_m_s]), angle_rad, rate_rad_s)


def at_sample(model: ChainModel, h: History, i: int) -> State:
    """State at a sample."""
    return consistent_state(model, h.com_m[i], h.com_velocity_m_s[i], h.angle_rad[i], h.rate_rad_s[i])


def budget(h: History, rate_rad_s: float, rtol: float = RTOL) -> float:
    """Steps x rtol x (1 + rate t)."""
    return h.steps * rtol * (1.0 + rate_rad_s * float(h.t_s[-1] - h.t_s[0]))


def fastest(model: ChainModel, h: History) -> float:
    """Larger of the orbit's and the bars' rates: the unit of a rate's tolerance, or more."""
    return max(np.sqrt(model.mu_m3_s2 / np.linalg.norm(h.com_m, axis=1).min() ** 3), np.abs(h.rate_rad_s).max())


def energy(model: ChainModel, h: History) -> Array:
    """Kinetic energy and all potentials there are, (n,) J."""
    total = relative_kinetic_energy(model, h.angle_rad, h.rate_rad_s) + com_energy(model, h.com_m, h.com_velocity_m_s)
    if model.gravity != "none":
        total = total + tidal_energy(model, h.com_m, h.angle_rad)
    for effect in model.effects:
        if effect.potential or isinstance(effect, JointSpringDamperEffect):  # springs have theirs beside dampers too
            total = total + effect.energy(model, h.com_m, h.angle_rad)
    return total


def angular_momentum(model: ChainModel, h: History) -> Array:
    """About the centre of the body, (n,) N m s."""
    whole = com_angular_momentum(model, h.com_m, h.com_velocity_m_s)
    total: Array = whole + relative_angular_momentum(model, h.angle_rad, h.rate_rad_s)
    return total


def unit_rate(model: ChainModel, h: History) -> float:
    """Rate that tolerances count in: the larger of the orbit's and the bars' initial rates."""
    return float(max(np.sqrt(model.mu_m3_s2 / np.linalg.norm(h.com_m[0]) ** 3), np.abs(h.rate_rad_s[0]).max()))


def energy_allowed(model: ChainModel, h: History, rtol: float = RTOL) -> float:
    """Steps x rtol x the energy's gradient along the units: four terms of size M v², and the chain's own M L² rate²."""
    mass, r, unit = model.mass_kg.sum(), np.linalg.norm(h.com_m, axis=1).max(), unit_rate(model, h)
    speed = np.linalg.norm(h.com_velocity_m_s, axis=1).max() + unit * r
    return float(h.steps * rtol * 4.0 * mass * (speed**2 + (model.length_m.sum() * fastest(model, h)) ** 2))


def momentum_allowed(model: ChainModel, h: History, rtol: float = RTOL) -> float:
    """The same of the angular momentum: four terms of size M r² times the unit, and of M L² times the rate."""
    mass, r, size = model.mass_kg.sum(), np.linalg.norm(h.com_m, axis=1).max(), model.length_m.sum()
    speed = np.linalg.norm(h.com_velocity_m_s, axis=1).max() + unit_rate(model, h) * r
    return float(h.steps * rtol * 4.0 * mass * (r * speed + size**2 * fastest(model, h)))


class Accounted(MinimalCoordinates):
    """Minimal coordinates, and the work done so far, integrated beside them."""

    def __init__(
        self, model: ChainModel, power: Callable[[ChainModel, float, State, relative.Accelerations, Modes], float]
    ) -> None:
        super().__init__(model)
        self.power = power

    def pack(self, state: State) -> Array:
        return np.append(super().pack(state), 0.0)

    def unpack(self, y: Array) -> State:
        return super().unpack(y[:-1])

    def rhs(self, t_s: float, y: Array) -> Array:
        state, modes = self.unpack(y), self.modes or (None,) * len(self.model.effects)
        a = relative.accelerations(self.model, t_s, state, modes)
        power = self.power(self.model, t_s, state, a, modes)
        return np.concatenate([y[2:4], a.com_m_s2, state.rate_rad_s, a.angle_rad_s2, [power]])


def accounted(
    model: ChainModel, state: State, t_s: Array, power, unit_J: float, *, rtol: float = RTOL
) -> tuple[History, Array]:
    """A run, and the work (n,) by `power` until each sample, W; `unit_J` is the unit of its tolerance."""
    run = started(model, state, rtol=rtol)
    run.coordinates = Accounted(model, power)
    run.y0, run.atol = np.append(run.y0, 0.0), np.append(run.atol, rtol * unit_J)
    seen = run.integrate(t_s)
    return run.history(seen), seen.y[:, -1]
