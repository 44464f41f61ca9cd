"""Integrate the chain in a chosen set of coordinates, and look at it at every sample."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from scipy.integrate import DOP853

from reference_impl.integrate import stiffness
from reference_impl.integrate.coordinate_sets import PACKINGS, CoordinateSet, Projected
from reference_impl.integrate.discrete_modes import ModelSwitches
from reference_impl.integrate.stepper import Walk, walk
from reference_impl.model.arrays import Array
from reference_impl.model.complex_vectors import along, as_complex
from reference_impl.model.gravity import perigee_m
from reference_impl.model.joints import condition_number, joint_matrix
from reference_impl.model.kinematics import joined_state

if TYPE_CHECKING:
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.state import State

BESIDES = 1.05  # gravity with all that a body's shape, other bodies, air and light add, over gravity


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
    position_m: Array | None = None
    """(n, N, 2) bars' centres from the centre of mass, where they are state of their own; None where they follow from
    the angles"""


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
            As :func:`reference_impl.integrate.stepper.walk`.
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
                shaken=self.packing.shaken,
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
        return perigee_m(self.model.mu_m3_s2, self.packing.centre(y), self.packing.drift(y))

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
            position_m=np.array([s.position_m for s in states]) if packing.holds_places else None,
        )

    def condition(self, state: State) -> float:
        """Condition number of the joint system at a state."""
        return condition_number(joint_matrix(self.model, 1j * along(state.angle_rad)))
