"""Errors of one evaluation of the reactions, by formulation and arithmetic, against exact arithmetic.

Three errors are told apart: that of the formula, against the exact answer for the very numbers that it was given; that
of the input, which rounding the state makes whatever is done with it; and both together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.studies.roundoff.formulations.definitions import FORMULATIONS
from barchain.studies.roundoff.formulations.production import PRODUCTION
from barchain.studies.roundoff.formulations.states import exact_case
from barchain.studies.roundoff.formulations.third_parties import THIRD_PARTIES
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT, Values, exact_numbers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.trajectory import Array
    from barchain.studies.roundoff.formulations.definitions import Formulation
    from barchain.studies.roundoff.formulations.states import EvaluationCase, Exact
    from reference_impl.precision.arithmetic import Arithmetic

SHARES = {"q05": 0.05, "median": 0.5, "q95": 0.95, "largest": 1.0}
REACTION, ORDINARY = "reaction", "m n² l"  # yardsticks
FORMULA, INPUT, BOTH = "formula", "input", "both"  # sources
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
    """Rows of evaluation.csv for a case."""
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
