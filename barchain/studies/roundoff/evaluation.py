"""One evaluation of the reactions: its errors, whether they know of the longitude, and its time.

Errors are against exact arithmetic. Three are told apart: that of the formula, against the exact answer for the very
numbers that it was given; that of the input, which rounding the state makes whatever is done with it; and both
together.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import gmpy2
import numpy as np
from scipy.stats import kruskal

from barchain.studies.roundoff.formulations import FORMULATIONS, PRODUCTION
from barchain.studies.roundoff.third_parties import THIRD_PARTIES
from barchain.studies.timing.evaluation import SCENE, divided, evaluation_times, numpy_loop
from barchain.studies.timing.statistics import interval
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT, Values, exact_numbers
from reference_impl.precision.chain import ChainParameters, RelativeState, consistent_chain_state
from reference_impl.precision.formulations import absolute, relative
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.random import Generator

    from adapters.trajectory import Array
    from barchain.studies.roundoff.formulations import Formulation
    from reference_impl.precision.arithmetic import Arithmetic

SHARES = {"q05": 0.05, "median": 0.5, "q95": 0.95, "largest": 1.0}
REACTION, ORDINARY = "reaction", "m n² l"  # yardsticks
FORMULA, INPUT, BOTH = "formula", "input", "both"  # sources
SECTORS = 8
TURNS, TIMED, LEAST_S = 9, 256, 0.02  # of times: repetitions, states at once, least time of one
Errors = dict[tuple[str, str], "Array"]
"""Errors (B,) by source and yardstick"""


def errors(formulation: Formulation, a: Arithmetic, exact: Exact, solution: Values | None = None) -> Errors:
    """Errors of a formulation in an arithmetic at a case's members; where exact numbers are in force.

    Parameters
    ----------
    formulation : Formulation
    a : Arithmetic
    exact : Exact
    solution : ndarray of objects, shape (2, N-1, B), optional
        Exact reactions of the exact state; found here if not given.

    Returns
    -------
    dict
        Largest joint's error, (B,), over the largest joint's reaction and over m n² l.
    """
    if solution is None:
        solution = FORMULATIONS["absolute"].exactly(FORMULATIONS["absolute"].given(exact, EXACT))
    rounded = formulation.given(exact, a).cast(a)
    with np.errstate(all="ignore"):  # what overflows or is lost is found, and shown, as an error
        found = formulation.reactions(a, rounded)
    lost = ~np.isfinite(found.astype(float))
    answer = formulation.exactly(rounded.cast(EXACT))
    seen = EXACT.cast(np.where(lost, 0.0, found))
    differences = {FORMULA: seen - answer, INPUT: answer - solution, BOTH: seen - solution}
    yards = {REACTION: largest(solution), ORDINARY: exact.yard_N}
    return {
        (source, yard): np.where(lost.any(axis=(0, 1)) & (source != INPUT), np.inf, over(difference, yards[yard]))
        for source, difference in differences.items()
        for yard in yards
    }


def largest(vectors: Values) -> Values:
    """Largest length of vectors (2, J, B), (B,)."""
    return EXACT.sqrt(vectors[0] * vectors[0] + vectors[1] * vectors[1]).max(axis=0)


def over(difference: Values, yard: Values) -> Array:
    """Largest of differences over a yardstick, (B,)."""
    return np.asarray(largest(difference) / yard, dtype=float)


def rows_of(case: EvaluationCase, formulations: Iterable[str], arithmetics: Iterable[str]) -> list[dict[str, Any]]:
    """Rows of the table `evaluation` for a case."""
    found: list[dict[str, Any]] = []
    with exact_numbers():
        exact = exact_case(case)
        plain, known = FORMULATIONS["absolute"], FORMULATIONS | PRODUCTION | THIRD_PARTIES
        solution = plain.exactly(plain.given(exact, EXACT))
        for name in formulations:
            for arithmetic in arithmetics:
                for (source, yard), values in errors(known[name], ARITHMETICS[arithmetic], exact, solution).items():
                    head = {"state": str(case.kind), "bars": case.bars, "ratio": case.ratio}
                    ways = {"formulation": name, "arithmetic": arithmetic, "source": source, "yardstick": yard}
                    found.append(head | ways | quantiles(values))
    return found


def quantiles(values: Array) -> dict[str, float]:
    """Quantiles of errors, and their number; an error that is infinite stays so."""
    shares = {name: float(np.quantile(values, share, method="higher")) for name, share in SHARES.items()}
    return shares | {"members": len(values)}


def longitude_rows(
    case: EvaluationCase, formulations: Iterable[str], arithmetics: Iterable[str]
) -> list[dict[str, Any]]:
    """Rows of the table `longitudes`: errors in each eighth of the circle, and the chance that all eighths are alike.

    No reaction knows of the longitude. Errors of the formulas should not either. Rounding the input may: an inertial
    angle is the larger, and so is the unit in its last place, the further round the circle the chain starts.
    """
    rows: list[dict[str, Any]] = []
    with exact_numbers():
        exact = exact_case(case)
        sector = np.floor(longitude_rad(exact) / (2.0 * np.pi / SECTORS)).astype(int) % SECTORS
        for name in formulations:
            for arithmetic in arithmetics:
                found = errors(FORMULATIONS[name], ARITHMETICS[arithmetic], exact)
                head = {"state": str(case.kind), "ratio": case.ratio, "formulation": name, "arithmetic": arithmetic}
                for source in (FORMULA, INPUT):
                    groups = [found[source, REACTION][sector == k] for k in range(SECTORS)]
                    rows += sector_rows(head | {"source": source}, groups)
    return rows


def sector_rows(head: dict[str, Any], groups: list[Array]) -> list[dict[str, Any]]:
    """One row for each sector's errors."""
    alike = {"p_value": float(kruskal(*groups).pvalue)}
    return [head | {"sector_deg": 360.0 / SECTORS * k} | quantiles(own) | alike for k, own in enumerate(groups)]


@dataclass(frozen=True)
class Pair:
    """One evaluation in both coordinates."""

    code: str
    arithmetic: str
    bars: int
    relative: Callable[[int], None]
    absolute: Callable[[int], None]
    states: int = 1
    """Evaluated in one call"""

    def row(self) -> dict[str, Any]:
        """Row of the table `times`; both are timed in turn, so that disturbances meet both."""
        times = evaluation_times((self.relative, self.absolute), TURNS, LEAST_S, batches=1) / self.states
        ours, theirs = np.median(times, axis=0)
        ratio = interval(float(ours / theirs), [(1.0, times[:, 0]), (-1.0, times[:, 1])])
        head = {"code": self.code, "arithmetic": self.arithmetic, "bars": self.bars, "turns": TURNS}
        spread = {"ratio": ratio.value, "low": ratio.low, "high": ratio.high}
        return head | {"relative_s": float(ours), "absolute_s": float(theirs)} | spread


def many_states(arithmetic: str, bars: int) -> Pair:
    """Both formulations of the study on many states at once."""
    a = ARITHMETICS[arithmetic]
    with exact_numbers():
        exact = exact_case(EvaluationCase(StateKind.GENERIC, bars, 1e-5, TIMED))
        chain, state, places = exact.bars.cast(a), exact.state.cast(a), exact.state.absolute.cast(a)

    def by_relative(times: int) -> None:
        for _ in range(times):
            relative(a, chain, state)

    def by_absolute(times: int) -> None:
        for _ in range(times):
            absolute(a, chain, places)

    return Pair("many states at once", arithmetic, bars, by_relative, by_absolute, TIMED)


def one_state(bars: int) -> Pair:
    """The reference's own right-hand sides, both with six unknowns a bar."""
    scene = divided(load_scene(SCENE), bars)
    return Pair("reference", "float64", bars, numpy_loop(scene, "redundant"), numpy_loop(scene, "absolute"))


def from_angles(bars: int) -> Pair:
    """Evaluation with positions computed from the angles, as the reference runs by default."""
    scene = divided(load_scene(SCENE), bars)
    code = "reference, places from angles"
    return Pair(code, "float64", bars, numpy_loop(scene, "minimal"), numpy_loop(scene, "absolute"))


def time_rows(bars: tuple[int, ...]) -> list[dict[str, Any]]:
    """Rows of the table `times`."""
    pairs = [make(n) for n in bars for make in (one_state, from_angles, lambda n: many_states("float64", n),
                                                lambda n: many_states("float32", n))]  # fmt: skip
    return [pair.row() for pair in pairs]


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
