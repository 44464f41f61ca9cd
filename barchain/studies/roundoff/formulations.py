"""Formulations of the joint reactions: their inputs, their results, and the exact results.

The relative formulation, the absolute one, and reactions read off from known motion by Newton's second law, as the
paper's introduction warns against; for measure, the last with relative motion too. Then the reference and its compiled
form: double precision only, one state after the other.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from reference_impl.kernel import layout
from reference_impl.kernel.library import evaluate
from reference_impl.model import relative as reference_model
from reference_impl.model.chain import ChainModel
from reference_impl.model.state import State
from reference_impl.precision.arithmetic import EXACT, FLOAT64, Arithmetic, Values
from reference_impl.precision.chain import ChainParameters, RelativeState, consistent_chain_state
from reference_impl.precision.coordinates import HighPrecisionMinimal, InitialChains
from reference_impl.precision.formulations import absolute, newton_reactions, point_field, relative, tidal_accelerations
from reference_impl.precision.steppers import extrapolated

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.studies.roundoff.evaluation import Exact
    from reference_impl.precision.chain import AbsoluteState

EXACT_SUBSTEPS = (2, 4, 6, 8)  # to the neighbouring instants: order 8, far below what differencing leaves

LONGEST_STEP = 0.3  # of 1/n, between positions that are differenced
NOTHING = np.zeros(2)


@dataclass(frozen=True)
class Given:
    """Numbers that a formulation starts from."""

    bars: ChainParameters
    state: Any
    """A dataclass of arrays"""

    def cast(self, to: Arithmetic) -> Given:
        """Rounded to another arithmetic."""
        rounded = [to.cast(getattr(self.state, f.name)) for f in fields(self.state)]
        return Given(self.bars.cast(to), type(self.state)(*rounded))


@dataclass(frozen=True)
class MovingBars:
    """Bars whose motion is known."""

    com_m: Values
    """(2, B) Z0; zero where places count from the body's centre"""
    place_m: Values
    """(2, N, B)"""
    acceleration_m_s2: Values
    """(2, N, B) of the places"""


@dataclass(frozen=True)
class Snapshots:
    """Bars at three instants."""

    com_m: Values
    """(2, B) at the middle one"""
    before_m: Values
    """(2, N, B)"""
    place_m: Values
    """(2, N, B)"""
    after_m: Values
    """(2, N, B)"""
    step_s: Values
    """(B,)"""


@dataclass(frozen=True)
class Turned:
    """The coordinates of the reference."""

    com_m: Values
    """(2, B)"""
    angle_rad: Values
    """(N, B)"""
    rate_rad_s: Values
    """(N, B)"""


@dataclass(frozen=True)
class Formulation:
    """A way to the reactions."""

    name: str
    given: Callable[[Exact, Arithmetic], Given]
    """Exact numbers to start from, which will be rounded to an arithmetic"""
    reactions: Callable[[Arithmetic, Given], Values]
    """Reactions (2, N-1, B) in an arithmetic"""
    absolutely: Callable[[Given], AbsoluteState] | None = None
    """State in absolute coordinates, whose cancellation exact numbers do not feel; None: its own formula is exact"""

    def exactly(self, given: Given) -> Values:
        """Reactions in exact arithmetic, of exact numbers: where there is one, by another formula."""
        if self.absolutely is None:
            return self.reactions(EXACT, given)
        return absolute(EXACT, given.bars, self.absolutely(given)).reaction_N


def turned(exact: Exact, _: Arithmetic) -> Given:
    """State without the places."""
    s = exact.state
    return Given(exact.bars, Turned(s.com_m, s.angle_rad, s.rate_rad_s))


def joined(a: Arithmetic, given: Given) -> RelativeState:
    """Chain whose places are made from the angles, eqs. (6) and (7')."""
    s = given.state
    return consistent_chain_state(a, given.bars, s.com_m, s.angle_rad, s.rate_rad_s)


def moving(exact: Exact, _: Arithmetic) -> Given:
    """Places and their exact accelerations."""
    at = exact.state.absolute
    found = absolute(EXACT, exact.bars, at)
    return Given(exact.bars, MovingBars(0 * exact.state.com_m, at.place_m, found.place_m_s2))


def from_accelerations(a: Arithmetic, given: Given) -> Values:
    """Newton's second law read backwards, eq. (8), summed up from the free end."""
    s = given.state
    return newton_reactions(given.bars, s.acceleration_m_s2 - point_field(a, given.bars, s.place_m))


def absolute_snapshots(exact: Exact, to: Arithmetic) -> Given:
    """Places from the body's centre, a step before, now, and a step after."""
    com, places, step = snapshots(exact, best_step(exact, to, absolute=True))
    before, now, after = (c[:, None] + d for c, d in zip(com, places, strict=True))
    return Given(exact.bars, Snapshots(0 * com[1], before, now, after, step))


def from_absolute_places(a: Arithmetic, given: Given) -> Values:
    """Differenced places, eq. (8), summed up from one free end so that nothing is left at the other.

    What all bars have in common, truncation n⁴ r h²/12 of their fall above all, is no reaction and drops out with the
    mean.
    """
    unexplained = second_difference(given.state) - point_field(a, given.bars, given.state.place_m)
    return newton_reactions(given.bars, unexplained - (unexplained * given.bars.weight).sum(axis=1)[:, None])


def relative_snapshots(exact: Exact, to: Arithmetic) -> Given:
    """Places from the centre of mass, a step before, now, and a step after."""
    com, (before, now, after), step = snapshots(exact, best_step(exact, to, absolute=False))
    return Given(exact.bars, Snapshots(com[1], before, now, after, step))


def from_relative_places(a: Arithmetic, given: Given) -> Values:
    """Differenced places, eqs. (13) and (14), summed up from the free end."""
    s = given.state
    difference, mean, _ = tidal_accelerations(a, given.bars, s.com_m, s.place_m)
    return newton_reactions(given.bars, second_difference(s) - (difference - mean[:, None]))


def second_difference(s: Snapshots) -> Values:
    """Acceleration by three positions: nothing but subtractions of neighbours."""
    return ((s.after_m - s.place_m) - (s.place_m - s.before_m)) / (s.step_s * s.step_s)


def circular_rate_rad_s(exact: Exact) -> Values:
    """Mean motion n of a circular orbit there, (B,)."""
    com = exact.state.com_m
    r2 = com[0] * com[0] + com[1] * com[1]
    return EXACT.sqrt(exact.bars.mu_m3_s2 / (r2 * EXACT.sqrt(r2)))


def circular_m_s(exact: Exact) -> Values:
    """Velocity of the centre of mass on a circular orbit, (2, B)."""
    com = exact.state.com_m
    return circular_rate_rad_s(exact) * np.stack([-com[1], com[0]])


def best_step(exact: Exact, to: Arithmetic, *, absolute: bool) -> Values:
    """Step at which truncation n⁴ l h²/12 and round-off u p/h² of a second difference are alike, (B,) s.

    Places are of the order p of the radius, or of a bar. No longer than that the motion is still a parabola.
    """
    com = exact.state.com_m
    extent = EXACT.sqrt(com[0] * com[0] + com[1] * com[1]) / exact.bars.length_m.max(axis=0) if absolute else 1.0
    alike = (12.0 * to.unit_roundoff * np.asarray(extent, float)) ** 0.25
    return EXACT.cast(np.minimum(alike, LONGEST_STEP) * np.ones(com.shape[-1])) / circular_rate_rad_s(exact)


def snapshots(exact: Exact, step: Values) -> tuple[list[Values], list[Values], Values]:
    """Centre of mass and relative places at three instants, and the step (B,) between them."""
    state, bars = exact.state, exact.bars
    minimal = HighPrecisionMinimal(EXACT, bars)
    y = minimal.pack(InitialChains(EXACT, bars, state.com_m, circular_m_s(exact), state.angle_rad, state.rate_rad_s))
    seen = [minimal.bar_positions(end) for end in (
        extrapolated(minimal.rates, y, -step, EXACT_SUBSTEPS), y, extrapolated(minimal.rates, y, step, EXACT_SUBSTEPS)
    )]  # fmt: skip
    return [com for _, com, _ in seen], [place for place, _, _ in seen], step


RELATIVE = Formulation(
    "relative", lambda exact, _: Given(exact.bars, exact.state),
    lambda a, given: relative(a, given.bars, given.state).reaction_N, lambda given: given.state.absolute,
)  # fmt: skip
"""Centre of mass, relative places, angles: eqs. (9)-(24)"""
MINIMAL = Formulation(
    "minimal", turned, lambda a, given: relative(a, given.bars, joined(a, given)).reaction_N,
    lambda given: joined(EXACT, given).absolute,
)  # fmt: skip
"""The same, its places made from the angles"""
ABSOLUTE = Formulation(
    "absolute", lambda exact, _: Given(exact.bars, exact.state.absolute),
    lambda a, given: absolute(a, given.bars, given.state).reaction_N,
)  # fmt: skip
"""Places counted from the body's centre: eqs. (8), (15), (19)"""
FORMULATIONS = {
    f.name: f
    for f in (
        RELATIVE, MINIMAL, ABSOLUTE,
        Formulation("absolute accelerations", moving, from_accelerations),
        Formulation("absolute positions", absolute_snapshots, from_absolute_places),
        Formulation("relative positions", relative_snapshots, from_relative_places),
    )
}  # fmt: skip


def model_of(bars: ChainParameters, member: int) -> ChainModel:
    """One member's chain, in the paper's gravity."""
    mass, length, inertia = (v[:, member].copy() for v in (bars.mass_kg, bars.length_m, bars.inertia_kg_m2))
    return ChainModel(float(bars.mu_m3_s2[member]), mass, length, inertia, "gradient")


def numpy_reactions(a: Arithmetic, given: Given) -> Values:
    """Reactions of each member by the code that `reference` runs."""
    assert a is FLOAT64
    s, found = given.state, []
    for k in range(s.com_m.shape[-1]):
        place = np.ascontiguousarray(s.position_m[..., k].T)
        state = State(s.com_m[:, k].copy(), NOTHING, s.angle_rad[:, k], s.rate_rad_s[:, k], place, 0.0 * place)
        found.append(reference_model.accelerations(model_of(given.bars, k), 0.0, state).reaction_N.T)
    return np.stack(found, axis=-1)


def compiled_reactions(a: Arithmetic, given: Given) -> Values:
    """Reactions of each member by the code that `reference-fast` runs, which makes places of the angles itself."""
    assert a is FLOAT64
    s, found = given.state, []
    for k in range(s.com_m.shape[-1]):
        model = model_of(given.bars, k)
        work = layout.workspace(model.bars, 0)
        y = layout.pack(s.com_m[:, k], NOTHING, s.angle_rad[:, k], s.rate_rad_s[:, k])
        if not evaluate(0.0, y, np.zeros_like(y), layout.compiled_chain(model), work):
            raise np.linalg.LinAlgError("the joint system is not positive definite in double precision")
        found.append(work.bars[[layout.RX, layout.RY], : model.bars - 1].copy())
    return np.stack(found, axis=-1)


PRODUCTION = {
    "reference": replace(RELATIVE, name="reference", reactions=numpy_reactions),
    "reference-fast": replace(MINIMAL, name="reference-fast", reactions=compiled_reactions),
}
