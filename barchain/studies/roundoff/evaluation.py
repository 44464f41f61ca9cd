"""One evaluation of the reactions: its errors, whether they know of the longitude, and its time.

Errors are against exact arithmetic. Three are told apart: that of the formula, against the exact answer for the very
numbers that it was given; that of the input, which rounding the state makes whatever is done with it; and both
together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import kruskal

from barchain.studies.defaults import DIVIDED_SCENE
from barchain.studies.roundoff.formulations import (
    FORMULATIONS,
    PRODUCTION,
    EvaluationCase,
    StateKind,
    exact_case,
    longitude_rad,
)
from barchain.studies.roundoff.third_parties import THIRD_PARTIES
from barchain.studies.timing.evaluation import divided, evaluation_times, numpy_loop
from barchain.studies.timing.statistics import interval
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT, Values, exact_numbers
from reference_impl.precision.formulations import absolute, relative
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.trajectory import Array
    from barchain.studies.roundoff.formulations import Exact, Formulation
    from reference_impl.integrate.coordinate_sets import CoordinateSet
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


def timed(
    code: str,
    arithmetic: str,
    bars: int,
    relative: Callable[[int], None],
    absolute: Callable[[int], None],
    states: int = 1,
) -> dict[str, Any]:
    """Row of the table `times`: loops over an evaluation of some states in both coordinates.

    Both are timed in turn, so that disturbances meet both.
    """
    times = evaluation_times((relative, absolute), TURNS, LEAST_S, batches=1) / states
    ours, theirs = np.median(times, axis=0)
    ratio = interval(float(ours / theirs), [(1.0, times[:, 0]), (-1.0, times[:, 1])])
    head = {"code": code, "arithmetic": arithmetic, "bars": bars, "turns": TURNS}
    spread = {"ratio": ratio.value, "low": ratio.low, "high": ratio.high}
    return head | {"relative_s": float(ours), "absolute_s": float(theirs)} | spread


def many_states(arithmetic: str, bars: int) -> dict[str, Any]:
    """Times of both formulations of the study on many states at once."""
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

    return timed("many states at once", arithmetic, bars, by_relative, by_absolute, TIMED)


def one_state(bars: int, code: str = "reference", coordinates: CoordinateSet = "redundant") -> dict[str, Any]:
    """Times of the reference's own right-hand sides, by default both with six unknowns a bar."""
    scene = divided(load_scene(DIVIDED_SCENE), bars)
    return timed(code, "float64", bars, numpy_loop(scene, coordinates), numpy_loop(scene, "absolute"))


def time_rows(bars: tuple[int, ...]) -> list[dict[str, Any]]:
    """Rows of the table `times`; those of places from angles are what the reference runs by default."""
    return [
        row
        for n in bars
        for row in (
            one_state(n),
            one_state(n, "reference, places from angles", "minimal"),
            many_states("float64", n),
            many_states("float32", n),
        )
    ]
