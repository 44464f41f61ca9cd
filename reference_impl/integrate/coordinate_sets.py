"""Sets of coordinates for the integrator's state vector; see docs/explanation/numerics.md."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from reference_impl.integrate.roundings import ROUNDINGS
from reference_impl.model import absolute, relative
from reference_impl.model.kinematics import consistent_state, gap_vectors
from reference_impl.model.state import Accelerations, State

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import Modes

ANGLE_ROUNDOFF = 0.5 * float(np.finfo(float).eps)  # rad, rounding error of an angle of about a radian
CoordinateSet = Literal["minimal", "redundant", "projected", "absolute"]


class StateCoordinates(ABC):
    """Layout of a state in the integrator's vector; see docs/explanation/numerics.md."""

    integrates_positions: ClassVar[bool] = False
    """Whether the vector contains the bars' positions; otherwise the positions follow from the angles"""

    def __init__(self, model: ChainModel) -> None:
        self.model = model
        self.modes: Modes | None = None
        """Modes of the effects in the right-hand side; None: they follow from the state"""
        self.reaction_N: Array = np.zeros((model.bars - 1, 2))
        """(N-1, 2) reactions of the last evaluation of the right-hand side"""

    @abstractmethod
    def pack(self, state: State) -> Array:
        """Vector of a state."""

    @abstractmethod
    def unpack(self, y: Array) -> State:
        """State of a vector."""

    @abstractmethod
    def rhs(self, t_s: float, y: Array) -> Array:
        """Time derivative of the vector."""

    @abstractmethod
    def scales(self, radius_m: float, rate_rad_s: float) -> Array:
        """Unit of the requested tolerance in each component."""

    def roundoff_floor(self, radius_m: float, rate_rad_s: float) -> Array:
        """Round-off error of each component in one step; smaller tolerances make the step size collapse.

        Springs turn the last digit of an angle into a rate error, by their own frequency.
        """
        found = np.zeros_like(self.scales(radius_m, rate_rad_s))
        found[-self.model.bars :] = ANGLE_ROUNDOFF * self.model.spring_rate_rad_s
        return found

    def state_roundoff_floor(self, y: Array) -> Array:
        """Round-off error of the angles and rates (2N,), rad and rad/s, at the current state.

        A bar under reactions is a pendulum of frequency sqrt((l/2J) |R_j + R_{j-1}|). An angle error gives a rate error
        of that frequency times the angle error. Smaller tolerances make the step size collapse.
        """
        ends = np.zeros((self.model.bars + 1, 2))
        ends[1:-1] = self.reaction_N
        pull = np.linalg.norm(ends[1:] + ends[:-1], axis=1)
        turned = np.abs(y[-2 * self.model.bars : -self.model.bars])
        swing = np.maximum(turned, 1.0) * np.sqrt(self.model.lever * pull)
        return ANGLE_ROUNDOFF * np.concatenate([turned, swing])

    def accelerations(self, t_s: float, y: Array, *, refine: bool = False) -> Accelerations:
        """Accelerations, reactions and torques at a vector."""
        return relative.accelerations(self.model, t_s, self.unpack(y), self.modes, refine=refine)

    def project(self, y: Array) -> Array:
        """Projection of a vector on closed joints; the identity for coordinates without drift."""
        return y

    def com_m(self, y: Array) -> Array:
        """Centre of mass (2,) of a vector, m."""
        return y[0:2]

    def com_velocity_m_s(self, y: Array) -> Array:
        """Velocity of the centre of mass (2,) of a vector, m/s."""
        return y[2:4]

    def joint_gaps_m(self, y: Array) -> Array:
        """Joint gaps (N-1,), m, in the arithmetic of these coordinates."""
        state = self.unpack(y)
        opened: Array = np.linalg.norm(gap_vectors(self.model, state.position_m, state.angle_rad), axis=-1)
        return opened


class MinimalCoordinates(StateCoordinates):
    """Centre of mass and angles: [Z0, Z0', theta, theta']; relative positions follow from the angles."""

    def pack(self, state: State) -> Array:
        """Vector of 4 + 2N."""
        return np.concatenate([state.com_m, state.com_velocity_m_s, state.angle_rad, state.rate_rad_s])

    def unpack(self, y: Array) -> State:
        """State with joints closed by construction."""
        n = self.model.bars
        return consistent_state(self.model, y[0:2], y[2:4], y[4 : 4 + n], y[4 + n :])

    def rhs(self, t_s: float, y: Array) -> Array:
        """Eq. (24) without its redundant rows."""
        a = self.accelerations(t_s, y)
        self.reaction_N = a.reaction_N
        return np.concatenate([y[2:4], a.com_m_s2, y[4 + self.model.bars :], a.angle_rad_s2])

    def scales(self, radius_m: float, rate_rad_s: float) -> Array:
        """Radius, its rate, one radian, its rate."""
        n = self.model.bars
        return np.repeat([radius_m, radius_m * rate_rad_s, 1.0, rate_rad_s], [2, 2, n, n])


class RedundantCoordinates(StateCoordinates):
    """The paper's unknowns in inertial angles: [Z0, Z0', d, d', theta, theta']; joints may drift."""

    integrates_positions = True

    def pack(self, state: State) -> Array:
        """Vector of 4 + 6N."""
        parts = [state.com_m, state.com_velocity_m_s, state.position_m, state.velocity_m_s]
        return np.concatenate([*map(np.ravel, parts), state.angle_rad, state.rate_rad_s])

    def unpack(self, y: Array) -> State:
        """State including its drift."""
        n = self.model.bars
        d, v = y[4 : 4 + 2 * n].reshape(n, 2), y[4 + 2 * n : 4 + 4 * n].reshape(n, 2)
        return State(y[0:2], y[2:4], y[4 + 4 * n : 4 + 5 * n], y[4 + 5 * n :], d, v)

    def rhs(self, t_s: float, y: Array) -> Array:
        """Eq. (24)."""
        a, n = self.accelerations(t_s, y), self.model.bars
        self.reaction_N = a.reaction_N
        return np.concatenate(
            [
                y[2:4],
                a.com_m_s2,
                y[4 + 2 * n : 4 + 4 * n],
                a.position_m_s2.ravel(),
                y[4 + 5 * n :],
                a.angle_rad_s2,
            ]
        )

    def scales(self, radius_m: float, rate_rad_s: float) -> Array:
        """Radius, bar length and radian, each with its rate."""
        n, length = self.model.bars, float(self.model.length_m.max())
        units = [radius_m, radius_m * rate_rad_s, length, length * rate_rad_s, 1.0, rate_rad_s]
        return np.repeat(units, [2, 2, 2 * n, 2 * n, n, n])


class ProjectedCoordinates(RedundantCoordinates):
    """Redundant coordinates with positions and velocities recomputed from the angles after every step."""

    def project(self, y: Array) -> Array:
        """Vector with closed joints."""
        s = self.unpack(y)
        return self.pack(consistent_state(self.model, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s))


class AbsoluteCoordinates(StateCoordinates):
    """Inertial coordinates from the centre of the body: [Z, Z', theta, theta']."""

    integrates_positions = True

    def pack(self, state: State) -> Array:
        """Vector of 6N."""
        place, velocity = state.com_m + state.position_m, state.com_velocity_m_s + state.velocity_m_s
        return np.concatenate([place.ravel(), velocity.ravel(), state.angle_rad, state.rate_rad_s])

    def split(self, y: Array) -> tuple[Array, Array, Array, Array]:
        """Z, Z', theta, theta' of a vector."""
        n = self.model.bars
        return y[: 2 * n].reshape(n, 2), y[2 * n : 4 * n].reshape(n, 2), y[4 * n : 5 * n], y[5 * n :]

    def unpack(self, y: Array) -> State:
        """State; the relative part results from a subtraction that the relative formulation avoids."""
        place, velocity, angle, rate = self.split(y)
        com, drift = self.model.weight @ place, self.model.weight @ velocity
        return State(com, drift, angle, rate, place - com, velocity - drift)

    def accelerations(self, t_s: float, y: Array, *, refine: bool = False) -> Accelerations:
        """Accelerations from absolute coordinates."""
        return absolute.accelerations(self.model, t_s, *self.split(y), self.modes, refine=refine)

    def rhs(self, t_s: float, y: Array) -> Array:
        """Eqs. (8) and (15) with the reactions eliminated."""
        a, n = self.accelerations(t_s, y), self.model.bars
        self.reaction_N = a.reaction_N
        return np.concatenate([y[2 * n : 4 * n], a.position_m_s2.ravel(), y[5 * n :], a.angle_rad_s2])

    def scales(self, radius_m: float, rate_rad_s: float) -> Array:
        """Bar length and radian, each with its rate: joints need positions to a bar's accuracy."""
        n, length = self.model.bars, float(self.model.length_m.max())
        del radius_m
        return np.repeat([length, length * rate_rad_s, 1.0, rate_rad_s], [2 * n, 2 * n, n, n])

    def roundoff_floor(self, radius_m: float, rate_rad_s: float) -> Array:
        """Round-off of the radius, and the angle error that it causes over the shortest bar."""
        n, place = self.model.bars, ROUNDINGS * np.finfo(float).eps * radius_m
        turn = place / float(self.model.length_m.min())
        rounded = np.repeat([place, place * rate_rad_s, turn, turn * rate_rad_s], [2 * n, 2 * n, n, n])
        found: Array = np.maximum(rounded, super().roundoff_floor(radius_m, rate_rad_s))
        return found

    def com_m(self, y: Array) -> Array:
        """Mass-weighted mean of the bars' positions."""
        place: Array = self.model.weight @ self.split(y)[0]
        return place

    def com_velocity_m_s(self, y: Array) -> Array:
        """Mass-weighted mean of the bars' velocities."""
        velocity: Array = self.model.weight @ self.split(y)[1]
        return velocity

    def joint_gaps_m(self, y: Array) -> Array:
        """Joint gaps (N-1,), m, by subtraction of absolute positions."""
        place, _, angle, _ = self.split(y)
        opened: Array = np.linalg.norm(gap_vectors(self.model, place, angle), axis=-1)
        return opened


COORDINATE_SETS: dict[CoordinateSet, type[StateCoordinates]] = {
    "minimal": MinimalCoordinates,
    "redundant": RedundantCoordinates,
    "projected": ProjectedCoordinates,
    "absolute": AbsoluteCoordinates,
}
