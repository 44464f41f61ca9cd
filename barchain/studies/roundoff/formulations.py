"""Formulations of the joint reactions, and the states in which one evaluation is judged.

A formulation has inputs, results, and exact results. A state is drawn once, in exact numbers that are the same for
every formulation and arithmetic; its members differ by a longitude, which no reaction knows of in a spherical field,
and by a unit in the last place of a double here and there. So each member rounds differently, and none is special.

The relative formulation, the absolute one, and reactions read off from known motion by Newton's second law, as the
paper's introduction warns against; for measure, the last with relative motion too. Then the reference and its compiled
form: double precision only, one state after the other.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import gmpy2
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

    from numpy.random import Generator

    from adapters.trajectory import Array
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


MU_M3_S2, EQUATOR_M, ALTITUDE_M = 3.986004418e14, 6378e3, 350e3
MASS_KG = 100.0
SPIN_FACTOR = 100.0  # rates of the fast state over the orbital one
MASS_RATIO = 1e6
MEMBERS = 32


class StateKind(StrEnum):
    """Kinds of states."""

    GENERIC = "generic"
    """Any attitude and rates, lengths and masses of one order."""
    STRAIGHT = "80°"
    """The paper's straight chain at 80° from the horizontal, turning with the orbit."""
    HORIZONTAL = "horizontal"
    """The same exactly horizontal: reactions nearly vanish."""
    SPIN = "fast spin"
    """As generic, each bar turning a hundred times as fast as the orbit."""
    UNEQUAL = "unequal masses"
    """As generic, masses alternating 1 : 1e6."""


@dataclass(frozen=True)
class EvaluationCase:
    """One point of the study: a state at a size ratio."""

    kind: StateKind
    bars: int
    ratio: float
    """epsilon: length of a bar over the Earth's radius"""
    members: int = MEMBERS


@dataclass(frozen=True)
class Exact:
    """A case's members in exact numbers."""

    bars: ChainParameters
    state: RelativeState

    @property
    def yard_N(self) -> Values:
        """(B,) mean mass times n² times the longest bar: what reactions of an ordinary state are of the order of."""
        com, bars = self.state.com_m, self.bars
        r2 = com[0] * com[0] + com[1] * com[1]
        rate2 = bars.mu_m3_s2 / (r2 * EXACT.sqrt(r2))
        return bars.mass_kg.sum(axis=0) / len(bars.mass_kg) * rate2 * bars.length_m.max(axis=0)


def exact_case(case: EvaluationCase) -> Exact:
    """Members of a case; to be called where exact numbers are in force.

    The same draw serves all size ratios, so that they differ by nothing else.
    """
    random = np.random.default_rng(zlib.crc32(f"{case.kind} {case.bars}".encode()))
    mass, length, angle, factor = configuration(case, random)
    blurred = case.kind is not StateKind.HORIZONTAL  # which must stay exactly so
    shape = (case.bars, case.members)
    lengths = EXACT.cast(length)[:, None] * gmpy2.mpfr(case.ratio) * EQUATOR_M * ulps(random, shape)
    masses = EXACT.cast(mass)[:, None] * ulps(random, shape)
    radius = gmpy2.mpfr(EQUATOR_M + ALTITUDE_M) * ulps(random, shape[1:])
    longitude = EXACT.cast(random.uniform(0.0, 2.0 * np.pi, case.members))
    from_horizontal = EXACT.cast(angle)[:, None] * (ulps(random, shape) if blurred else EXACT.cast(np.ones(shape)))
    mu = EXACT.cast(np.full(case.members, MU_M3_S2))
    rate = EXACT.sqrt(mu / radius) / radius * (EXACT.cast(factor)[:, None] * EXACT.cast(np.ones(shape)))
    bars = ChainParameters(mu, masses, lengths, masses * lengths * lengths / 12)
    com = np.stack([radius * EXACT.cos(longitude), radius * EXACT.sin(longitude)])
    turned = from_horizontal + (longitude - gmpy2.const_pi() / 2)
    return Exact(bars, consistent_chain_state(EXACT, bars, com, turned, rate * (ulps(random, shape) if blurred else 1)))


def configuration(case: EvaluationCase, random: Generator) -> tuple[Array, Array, Array, Array]:
    """Masses, lengths over the nominal one, angles from the horizontal and rates over the orbital one, each (N,)."""
    n = case.bars
    if case.kind in (StateKind.STRAIGHT, StateKind.HORIZONTAL):
        angle = np.radians(80.0) if case.kind is StateKind.STRAIGHT else 0.0
        return np.full(n, MASS_KG), np.ones(n), np.full(n, angle), np.ones(n)
    mass, length = MASS_KG * 10.0 ** random.uniform(-0.5, 0.5, n), random.uniform(0.5, 1.0, n)
    angle, factor = random.uniform(-np.pi, np.pi, n), random.uniform(-3.0, 3.0, n)
    if case.kind is StateKind.SPIN:
        factor = np.full(n, SPIN_FACTOR)
    if case.kind is StateKind.UNEQUAL:
        mass[1::2] /= MASS_RATIO
    return mass, length, angle, factor


def ulps(random: Generator, shape: tuple[int, ...]) -> Values:
    """Exact factors of 1, or a unit in a double's last place more or less."""
    return EXACT.cast(1.0 + random.integers(-1, 2, shape) * np.finfo(float).eps)


def longitude_rad(exact: Exact) -> Array:
    """Longitudes of a case's members, (B,), in [0, 2 pi)."""
    x, y = (v.astype(float) for v in exact.state.com_m)
    found: Array = np.arctan2(y, x) % (2.0 * np.pi)
    return found
