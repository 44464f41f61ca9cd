"""Simulation of a chain in a chosen set of coordinates, with its observables at the samples."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from scipy.integrate import DOP853

from reference_impl.integrate import stiffness
from reference_impl.integrate.coordinate_sets import COORDINATE_SETS, CoordinateSet, ProjectedCoordinates
from reference_impl.integrate.discrete_modes import DiscreteModes
from reference_impl.integrate.stepper import Integration, integrate
from reference_impl.model.arrays import Array
from reference_impl.model.complex_vectors import as_complex, unit_along
from reference_impl.model.gravity import perigee_m
from reference_impl.model.joints import condition_number, joint_matrix
from reference_impl.model.kinematics import consistent_state

if TYPE_CHECKING:
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.state import State

ESTIMATED_RADIANS = 0.3
"""Longest step, in radians of the fastest rate, where round-off holds the tolerance up and a finer request shortens
none: at 0.8 the error estimate of DOP853 was 2000 times too small on a chain of soft springs"""
PERTURBED_OVER_CENTRAL = 1.05  # total over central gravity, bound: oblateness, other bodies, air and light included
LOWEST_OVER_PERIGEE = 0.9
"""Radius down to which a disturbed orbit is followed, over the perigee of the Kepler orbit"""
MOST_FOLDINGS = 100.0
"""Factors of e by which neighbouring orbits part in a step, at most: beyond, nothing is told, and nothing overflows"""


@dataclass(frozen=True)
class History:
    """Observables at n samples, with the integrator's statistics."""

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
    com_residual_m: Array
    """(n,) |sum mu_j d_j|, centre-of-mass residual, eq. (6)"""
    torque_N_m: Array
    """(n, P)"""
    condition: Array | None
    """(n,) condition numbers of the joint system, if requested"""
    steps: int
    evaluations: int
    landed_s: float | None
    """Instant of contact of a bar with the surface; None without contact"""
    impulse_N_s: Array | None = None
    """(n, N-1, 2) sum of the impulsive reactions so far; None for a model without impulses"""
    method: str = stiffness.METHOD_NAMES[DOP853]
    """Integration method, with the reason for any other than DOP853"""
    position_m: Array | None = None
    """(n, N, 2) bars' centres from the centre of mass, if integrated; None if they follow from the angles"""


Length = TypeVar("Length", float, Array)


def contact_free_radius_m(body_radius_m: float, length_m: Length) -> Length:
    """Orbital radius of the centre of mass above which no bar can touch the surface, m."""
    return body_radius_m + length_m


def contact_free_perigee_m(contact_free_radius_m: Length, length_m: Length) -> Length:
    """Perigee of the centre of mass above which no bar can touch the surface, m.

    The chain departs from the Kepler orbit by up to 12 pi L²/r in one revolution.
    """
    return contact_free_radius_m + 12.0 * np.pi * length_m**2 / contact_free_radius_m


def largest_pull_m_s2(model: ChainModel, contact_free_radius_m: float) -> float:
    """Upper bound of the centre of mass' acceleration above the surface, m/s²: mu/R², slightly more with effects."""
    pull = 0.0 if model.gravity == "none" else model.mu_m3_s2 / contact_free_radius_m**2
    if not model.effects:
        return pull
    return PERTURBED_OVER_CENTRAL * pull + sum(effect.largest_acceleration_m_s2(model) for effect in model.effects)


class Simulation:
    """One run: set-up, integration, observables."""

    most_events: float = math.inf
    """State events after which the run gives up"""

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
            Error allowed in one step, in units of each block's own scale: radius, bar length, radian, and each of these
            times the larger of the orbital and the bars' own initial rate.
        coordinates : {"minimal", "redundant", "projected", "absolute"}
        """
        self.model = model
        self.coordinates = COORDINATE_SETS[coordinates](model)
        start = consistent_state(model, com_m, com_velocity_m_s, angle_rad, rate_rad_s)
        self.y0 = self.coordinates.pack(start)
        radius = float(np.linalg.norm(com_m))
        rate = max(np.sqrt(model.mu_m3_s2 / radius**3), float(np.abs(rate_rad_s).max()))
        self.events: DiscreteModes | None = None
        self.method: stiffness.Method = DOP853
        requested, floor = rtol * self.coordinates.scales(radius, rate), self.coordinates.roundoff_floor(radius, rate)
        self.atol = np.maximum(requested, floor)
        held_up = bool(np.any(floor[-model.bars :] > requested[-model.bars :]))
        self.longest_step_s = ESTIMATED_RADIANS / max(rate, model.spring_rate_rad_s) if held_up else np.inf

    def integrate(self, t_s: Array) -> Integration:
        """Integrate over the sample instants; stop at contact of a bar with the surface.

        Raises
        ------
        ArithmeticError
            As :func:`reference_impl.integrate.stepper.integrate`.
        """
        if self.model.effects or self.model.impulses:
            self.events = DiscreteModes(self.coordinates, float(t_s[-1]), most_events=self.most_events)
        try:
            self.method = stiffness.choose_method(self.coordinates, self.y0, t_s, self.atol)
            return integrate(
                self.coordinates.rhs,
                self.y0,
                t_s,
                self.atol,
                breaks_s=self.model.breaks_s,
                project=self.coordinates.project if isinstance(self.coordinates, ProjectedCoordinates) else None,
                surface=self if self.model.body_radius_m > 0.0 else None,
                events=self.events,
                method=self.method,
                longest_step_s=self.longest_step_s if self.method is DOP853 else np.inf,
                state_roundoff_floor=self.coordinates.state_roundoff_floor,
            )
        except ArithmeticError as error:
            raise ArithmeticError(f"{error}{self.failure_hint}") from error
        finally:
            self.coordinates.modes = None

    @property
    def failure_hint(self) -> str:
        """Likely cause of a failed run; empty if none is known."""
        if all(p.reacts_on is None for p in self.model.prescriptions):
            return ""
        return (
            " Possible cause: the effect of a joint motor on its bar's angle passes through zero, "
            "where no torque satisfies the law."
        )

    @cached_property
    def contact_free_radius_m(self) -> float:
        """:func:`contact_free_radius_m` of this chain; 0 for a body without surface."""
        return (
            contact_free_radius_m(self.model.body_radius_m, float(self.model.length_m.sum()))
            if self.model.body_radius_m
            else 0.0
        )

    @cached_property
    def contact_free_perigee_m(self) -> float:
        """:func:`contact_free_perigee_m` of this chain; infinite with effects, as the orbit is not Keplerian."""
        return (
            np.inf
            if self.model.effects
            else contact_free_perigee_m(self.contact_free_radius_m, float(self.model.length_m.sum()))
        )

    @cached_property
    def largest_pull_m_s2(self) -> float:
        """:func:`largest_pull_m_s2` of this chain."""
        return largest_pull_m_s2(self.model, self.contact_free_radius_m) if self.contact_free_radius_m else 0.0

    def stays_above(self, perigee_m: float, step_s: float) -> bool:
        """Whether a step is too short to fall from a Kepler orbit through one of its ends to where contact is possible.

        Above a radius r, neighbouring orbits part at most as exp(k t), k² = 2 mu/r³. A bar is as far from the centre of
        mass as the chain is long, at most.
        """
        lowest_m = max(self.contact_free_radius_m, LOWEST_OVER_PERIGEE * perigee_m)
        nearest_m = lowest_m - (self.contact_free_radius_m - self.model.body_radius_m)
        central, nearest = (self.model.mu_m3_s2 / r**2 for r in (lowest_m, nearest_m))
        disturbance = largest_pull_m_s2(self.model, lowest_m) - central + nearest - central
        square = 2.0 * central / lowest_m
        foldings = min(math.sqrt(square) * step_s, MOST_FOLDINGS)
        return lowest_m + disturbance / square * (math.cosh(foldings) - 1.0) < perigee_m

    def perigee_m(self, y: Array) -> float:
        """Perigee of the Kepler orbit through the centre of mass of a vector, m from the body's centre."""
        return perigee_m(self.model.mu_m3_s2, self.coordinates.com_m(y), self.coordinates.com_velocity_m_s(y))

    def clears_surface(self, before: Array, after: Array, step_s: float) -> bool:
        """Whether contact with the surface is impossible in a step between these two states.

        Either the orbit's perigee is high enough, for ever or for the length of the step, or free fall is too short. No
        acceleration above the surface exceeds :func:`largest_pull_m_s2`. A parabola from either end of the step, over
        half of the step, bounds the fall.
        """
        if self.model.gravity != "none":
            perigee_m = self.perigee_m(after)
            if perigee_m > self.contact_free_perigee_m or self.stays_above(perigee_m, step_s):
                return True
        half, pull = 0.5 * step_s, self.largest_pull_m_s2
        lowest = []
        for y, way in ((before, 1.0), (after, -1.0)):
            place, velocity = self.coordinates.com_m(y), self.coordinates.com_velocity_m_s(y)
            r = float(np.linalg.norm(place))
            lowest.append(r + min(0.0, way * float(place @ velocity) / r) * half - 0.5 * pull * half * half)
        return min(lowest) > self.contact_free_radius_m

    def height(self, y: Array) -> float:
        """Smallest distance of any point of any bar from the surface, m."""
        s = self.coordinates.unpack(y)
        unit, place = unit_along(s.angle_rad), as_complex(s.com_m + s.position_m)
        # nearest point of the bar, from its centre
        foot = np.clip(-(unit.conj() * place).real, -self.model.left_m, self.model.right_m)
        return float(np.abs(place + foot * unit).min() - self.model.body_radius_m)

    def history(self, result: Integration, *, condition: bool = False) -> History:
        """Observables at the samples of an integration."""
        coordinates = self.coordinates
        states = [coordinates.unpack(y) for y in result.y]
        found = [coordinates.accelerations(t, y, refine=True) for t, y in zip(result.t_s, result.y, strict=True)]
        weight = self.model.weight
        return History(
            t_s=result.t_s,
            com_m=np.array([s.com_m for s in states]),
            com_velocity_m_s=np.array([s.com_velocity_m_s for s in states]),
            angle_rad=np.array([s.angle_rad for s in states]),
            rate_rad_s=np.array([s.rate_rad_s for s in states]),
            reaction_N=np.array([a.reaction_N for a in found]),
            gap_m=np.array([coordinates.joint_gaps_m(y) for y in result.y]),
            com_residual_m=np.array([np.linalg.norm(weight @ s.position_m) for s in states]),
            torque_N_m=np.array([a.torque_N_m for a in found]),
            impulse_N_s=self.events.impulse_sums(result.t_s) if self.events else None,
            condition=np.array([self.condition(s) for s in states]) if condition else None,
            steps=result.steps,
            evaluations=result.evaluations,
            landed_s=result.stopped_s,
            method=stiffness.METHOD_NAMES[self.method],
            position_m=np.array([s.position_m for s in states]) if coordinates.integrates_positions else None,
        )

    def condition(self, state: State) -> float:
        """Condition number of the joint system at a state."""
        return condition_number(joint_matrix(self.model, 1j * unit_along(state.angle_rad)))
