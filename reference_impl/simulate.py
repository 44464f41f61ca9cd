"""Integrate the chain in a chosen set of coordinates, and look at it at every sample."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, TypeVar

import numpy as np
from scipy.integrate import DOP853

from reference_impl import absolute, relative, stiffness
from reference_impl.chain import Accelerations, Array, ChainModel, State
from reference_impl.joints import condition_number, joint_matrix
from reference_impl.kinematics import gap_vectors, joined_state
from reference_impl.plane import along, as_complex
from reference_impl.stepper import Walk, walk
from reference_impl.switches import ModelSwitches

if TYPE_CHECKING:
    from reference_impl.effect import Modes

GRAINS = 4.0  # roundings of a stage that an absolute coordinate keeps
BESIDES = 1.05  # gravity with all that a body's shape, other bodies, air and light add, over gravity
CoordinateSet = Literal["minimal", "redundant", "projected", "absolute"]


@dataclass(frozen=True)
class History:
    """The motion at n samples, and how it was come by."""

    t_s: Array
    """(n,)"""
    com_m: Array
    """(n, 2)"""
    com_velocity_m_s: Array
    """(n, 2)"""
    angle_rad: Array
    """(n, N)"""
    rate_rad_s: Array
    """(n, N)"""
    reaction_N: Array
    """(n, N-1, 2) force on bar j from bar j+1"""
    gap_m: Array
    """(n, N-1)"""
    identity_m: Array
    """(n,) |sum mu_j d_j|, eq. (6)"""
    torque_N_m: Array
    """(n, P)"""
    condition: Array | None
    """(n,) of the joint system, if asked for"""
    steps: int
    evaluations: int
    landed_s: float | None
    """Instant at which a bar reached the surface; None if none did"""
    impulse_N_s: Array | None = None
    """(n, N-1, 2) sum of the impulsive reactions so far; None where nothing strikes"""
    method: str = stiffness.WORDS[DOP853]
    """What took the steps, and why where it is not the usual one"""


Length = TypeVar("Length", float, Array)


def floor_m(body_radius_m: float, length_m: Length) -> Length:
    """Distance of the centre of mass from the body's centre above which no bar can touch the surface, m."""
    return body_radius_m + length_m


def safe_perigee_m(floor_m: Length, length_m: Length) -> Length:
    """The same for the lowest point of its orbit, from which it departs by 12 pi L²/r in one revolution, m."""
    return floor_m + 12.0 * np.pi * length_m**2 / floor_m


def strongest_pull_m_s2(model: ChainModel, floor_m: float) -> float:
    """Bound of what may pull the centre of mass down above the surface, m/s²: mu/R², with effects a little more."""
    pull = 0.0 if model.gravity == "none" else model.mu_m3_s2 / floor_m**2
    if not model.effects:
        return pull
    return BESIDES * pull + sum(effect.strongest_m_s2(model) for effect in model.effects)


class Packing(ABC):
    """How a state is laid out in the integrator's vector; see design/coordinates.md."""

    def __init__(self, model: ChainModel) -> None:
        self.model = model
        self.modes: Modes | None = None
        """What the right-hand side holds for the model's effects; None: what the state says"""

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
        """What counts as 1 in each component: the unit of the requested tolerance."""

    def grain(self, radius_m: float, rate_rad_s: float) -> Array | float:
        """Error that rounding makes in each component anyway: to ask for less makes the steps collapse."""
        del radius_m, rate_rad_s
        return 0.0

    def accelerations(self, t_s: float, y: Array, *, refine: bool = False) -> Accelerations:
        """Accelerations, reactions and torques at a vector."""
        return relative.accelerations(self.model, t_s, self.unpack(y), self.modes, refine=refine)

    def project(self, y: Array) -> Array:
        """Nearest vector allowed; the same one where nothing can drift."""
        return y

    def centre(self, y: Array) -> Array:
        """Centre of mass (2,) of a vector."""
        return y[0:2]

    def drift(self, y: Array) -> Array:
        """Velocity of the centre of mass (2,) of a vector."""
        return y[2:4]

    def gaps(self, y: Array) -> Array:
        """Joint gaps (N-1,), m, in these coordinates' own arithmetic."""
        state = self.unpack(y)
        opened: Array = np.linalg.norm(gap_vectors(self.model, state.position_m, state.angle_rad), axis=-1)
        return opened


class Minimal(Packing):
    """Centre of mass and angles: [Z0, Z0', theta, theta']; relative positions follow from the angles."""

    def pack(self, state: State) -> Array:
        """Vector of 4 + 2N."""
        return np.concatenate([state.com_m, state.com_velocity_m_s, state.angle_rad, state.rate_rad_s])

    def unpack(self, y: Array) -> State:
        """State with its joints closed by construction."""
        n = self.model.bars
        return joined_state(self.model, y[0:2], y[2:4], y[4 : 4 + n], y[4 + n :])

    def rhs(self, t_s: float, y: Array) -> Array:
        """Eq. (24) without its redundant rows."""
        a = self.accelerations(t_s, y)
        return np.concatenate([y[2:4], a.com_m_s2, y[4 + self.model.bars :], a.angle_rad_s2])

    def scales(self, radius_m: float, rate_rad_s: float) -> Array:
        """Radius, its rate, one radian, its rate."""
        n = self.model.bars
        return np.repeat([radius_m, radius_m * rate_rad_s, 1.0, rate_rad_s], [2, 2, n, n])


class Redundant(Packing):
    """The paper's unknowns in inertial angles: [Z0, Z0', d, d', theta, theta']; joints may drift."""

    def pack(self, state: State) -> Array:
        """Vector of 4 + 6N."""
        parts = [state.com_m, state.com_velocity_m_s, state.position_m, state.velocity_m_s]
        return np.concatenate([*map(np.ravel, parts), state.angle_rad, state.rate_rad_s])

    def unpack(self, y: Array) -> State:
        """State as it is, drift and all."""
        n = self.model.bars
        d, v = y[4 : 4 + 2 * n].reshape(n, 2), y[4 + 2 * n : 4 + 4 * n].reshape(n, 2)
        return State(y[0:2], y[2:4], y[4 + 4 * n : 4 + 5 * n], y[4 + 5 * n :], d, v)

    def rhs(self, t_s: float, y: Array) -> Array:
        """Eq. (24)."""
        a, n = self.accelerations(t_s, y), self.model.bars
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


class Projected(Redundant):
    """Redundant, with positions and velocities set right from the angles after every step."""

    def project(self, y: Array) -> Array:
        """Vector with its joints closed."""
        s = self.unpack(y)
        return self.pack(joined_state(self.model, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s))


class Absolute(Packing):
    """Distances from the centre of the body: [Z, Z', theta, theta']."""

    def pack(self, state: State) -> Array:
        """Vector of 6N."""
        place, velocity = state.com_m + state.position_m, state.com_velocity_m_s + state.velocity_m_s
        return np.concatenate([place.ravel(), velocity.ravel(), state.angle_rad, state.rate_rad_s])

    def split(self, y: Array) -> tuple[Array, Array, Array, Array]:
        """Z, Z', theta, theta' of a vector."""
        n = self.model.bars
        return y[: 2 * n].reshape(n, 2), y[2 * n : 4 * n].reshape(n, 2), y[4 * n : 5 * n], y[5 * n :]

    def unpack(self, y: Array) -> State:
        """State with the relative part got by the subtraction that the relative formulation avoids."""
        place, velocity, angle, rate = self.split(y)
        com, drift = self.model.weight @ place, self.model.weight @ velocity
        return State(com, drift, angle, rate, place - com, velocity - drift)

    def accelerations(self, t_s: float, y: Array, *, refine: bool = False) -> Accelerations:
        """Accelerations from absolute coordinates."""
        return absolute.accelerations(self.model, t_s, *self.split(y), self.modes, refine=refine)

    def rhs(self, t_s: float, y: Array) -> Array:
        """Eqs. (8) and (15) with the reactions eliminated."""
        a, n = self.accelerations(t_s, y), self.model.bars
        return np.concatenate([y[2 * n : 4 * n], a.position_m_s2.ravel(), y[5 * n :], a.angle_rad_s2])

    def scales(self, radius_m: float, rate_rad_s: float) -> Array:
        """Bar length and radian, each with its rate: joints need positions to a bar's accuracy."""
        n, length = self.model.bars, float(self.model.length_m.max())
        del radius_m
        return np.repeat([length, length * rate_rad_s, 1.0, rate_rad_s], [2 * n, 2 * n, n, n])

    def grain(self, radius_m: float, rate_rad_s: float) -> Array:
        """Units in the last place of the radius, and of what an angle makes of it over the shortest bar."""
        n, place = self.model.bars, GRAINS * np.finfo(float).eps * radius_m
        turn = place / float(self.model.length_m.min())
        return np.repeat([place, place * rate_rad_s, turn, turn * rate_rad_s], [2 * n, 2 * n, n, n])

    def centre(self, y: Array) -> Array:
        """Weighted mean of the bars' places."""
        place: Array = self.model.weight @ self.split(y)[0]
        return place

    def drift(self, y: Array) -> Array:
        """Weighted mean of the bars' velocities."""
        velocity: Array = self.model.weight @ self.split(y)[1]
        return velocity

    def gaps(self, y: Array) -> Array:
        """Joint gaps (N-1,), m, by subtracting absolute positions."""
        place, _, angle, _ = self.split(y)
        opened: Array = np.linalg.norm(gap_vectors(self.model, place, angle), axis=-1)
        return opened


PACKINGS: dict[CoordinateSet, type[Packing]] = {
    "minimal": Minimal,
    "redundant": Redundant,
    "projected": Projected,
    "absolute": Absolute,
}


class Simulation:
    """One run: made, walked, then looked at."""

    def __init__(
        self,
        model: ChainModel,
        com_m: Array,
        com_velocity_m_s: Array,
        angle_rad: Array,
        rate_rad_s: Array,
        *,
        rtol: float,
        coordinates: CoordinateSet = "minimal",
    ) -> None:
        """Set up a run.

        Parameters
        ----------
        model : ChainModel
        com_m, com_velocity_m_s : ndarray, shape (2,)
        angle_rad, rate_rad_s : ndarray, shape (N,)
            Initial state; relative positions follow from the angles.
        rtol : float
            Error allowed in one step, in units of each block's own scale: radius, bar length, radian,
            and each of these times the larger of the orbital and the bars' own initial rate.
        coordinates : {"minimal", "redundant", "projected", "absolute"}
        """
        self.model = model
        self.packing = PACKINGS[coordinates](model)
        start = joined_state(model, com_m, com_velocity_m_s, angle_rad, rate_rad_s)
        self.y0 = self.packing.pack(start)
        radius = float(np.linalg.norm(com_m))
        rate = max(np.sqrt(model.mu_m3_s2 / radius**3), float(np.abs(rate_rad_s).max()))
        self.switches: ModelSwitches | None = None
        self.method: stiffness.Method = DOP853
        self.atol = np.maximum(rtol * self.packing.scales(radius, rate), self.packing.grain(radius, rate))

    def walk(self, t_s: Array) -> Walk:
        """Integrate over the sample instants; stop where a bar reaches the surface.

        Raises
        ------
        ArithmeticError
            As :func:`reference_impl.stepper.walk`.
        """
        if self.model.effects or self.model.impulses:
            self.switches = ModelSwitches(self.packing, float(t_s[-1]))
        try:
            self.method = stiffness.method(self.packing, self.y0, t_s, self.atol)
            return walk(
                self.packing.rhs,
                self.y0,
                t_s,
                self.atol,
                breaks_s=self.model.breaks_s,
                project=self.packing.project if isinstance(self.packing, Projected) else None,
                surface=self if self.model.body_radius_m > 0.0 else None,
                switches=self.switches,
                method=self.method,
            )
        except ArithmeticError as error:
            raise ArithmeticError(f"{error}{self.suspicion}") from error
        finally:
            self.packing.modes = None

    @property
    def suspicion(self) -> str:
        """What is most likely behind a run that broke down, if anything is known."""
        if all(p.reacts_on is None for p in self.model.prescriptions):
            return ""
        return (
            " A joint motor can lose its grip: where its effect on its bar's angle passes through zero, "
            "no torque holds the law."
        )

    @cached_property
    def floor_m(self) -> float:
        """:func:`floor_m` of this chain; 0 where there is no surface."""
        return floor_m(self.model.body_radius_m, float(self.model.length_m.sum())) if self.model.body_radius_m else 0.0

    @cached_property
    def safe_m(self) -> float:
        """:func:`safe_perigee_m` of this chain; infinite under effects, which turn its orbit into none."""
        return np.inf if self.model.effects else safe_perigee_m(self.floor_m, float(self.model.length_m.sum()))

    @cached_property
    def pull_m_s2(self) -> float:
        """:func:`strongest_pull_m_s2` of this chain."""
        return strongest_pull_m_s2(self.model, self.floor_m) if self.floor_m else 0.0

    def perigee_m(self, y: Array) -> float:
        """Lowest point of the Kepler orbit through the centre of mass of a vector, m from the body's centre."""
        (x, z), (vx, vz), mu = self.packing.centre(y), self.packing.drift(y), self.model.mu_m3_s2
        parameter = (x * vz - z * vx) ** 2 / mu
        energy = 0.5 * (vx * vx + vz * vz) - mu / np.hypot(x, z)
        return float(parameter / (1.0 + np.sqrt(max(0.0, 1.0 + 2.0 * energy * parameter / mu))))

    def clear(self, before: Array, after: Array, step_s: float) -> bool:
        """Whether no bar can have touched the surface in a step between these two states.

        The orbit's lowest point is high enough; or, as nothing above the surface pulls more than
        :func:`strongest_pull_m_s2`, the centre of mass can't have fallen so far by a parabola, from either end of the
        step for half of it.
        """
        if self.model.gravity != "none" and self.perigee_m(after) > self.safe_m:
            return True
        half, pull = 0.5 * step_s, self.pull_m_s2
        lowest = []
        for y, way in ((before, 1.0), (after, -1.0)):
            place, velocity = self.packing.centre(y), self.packing.drift(y)
            r = float(np.linalg.norm(place))
            lowest.append(r + min(0.0, way * float(place @ velocity) / r) * half - 0.5 * pull * half * half)
        return min(lowest) > self.floor_m

    def height(self, y: Array) -> float:
        """Least distance of any point of any bar from the surface, m."""
        s = self.packing.unpack(y)
        unit, place, half = along(s.angle_rad), as_complex(s.com_m + s.position_m), self.model.half_m
        foot = np.clip(-(unit.conj() * place).real, -half, half)  # nearest point of the bar, from its centre
        return float(np.abs(place + foot * unit).min() - self.model.body_radius_m)

    def history(self, seen: Walk, *, condition: bool = False) -> History:
        """Observables at the samples of a walk."""
        packing = self.packing
        states = [packing.unpack(y) for y in seen.y]
        found = [packing.accelerations(t, y, refine=True) for t, y in zip(seen.t_s, seen.y, strict=True)]
        weight = self.model.weight
        return History(
            t_s=seen.t_s,
            com_m=np.array([s.com_m for s in states]),
            com_velocity_m_s=np.array([s.com_velocity_m_s for s in states]),
            angle_rad=np.array([s.angle_rad for s in states]),
            rate_rad_s=np.array([s.rate_rad_s for s in states]),
            reaction_N=np.array([a.reaction_N for a in found]),
            gap_m=np.array([packing.gaps(y) for y in seen.y]),
            identity_m=np.array([np.linalg.norm(weight @ s.position_m) for s in states]),
            torque_N_m=np.array([a.torque_N_m for a in found]),
            impulse_N_s=self.switches.impulses(seen.t_s) if self.switches else None,
            condition=np.array([self.condition(s) for s in states]) if condition else None,
            steps=seen.steps,
            evaluations=seen.evaluations,
            landed_s=seen.stopped_s,
            method=stiffness.WORDS[self.method],
        )

    def condition(self, state: State) -> float:
        """Condition number of the joint system at a state."""
        return condition_number(joint_matrix(self.model, 1j * along(state.angle_rad)))
