"""Weighted sums of slopes for W chains: the stages of DOP853, its error estimates and its interpolant.

Coefficients come from memory, not from the code as in :mod:`reference_impl.fast.dop853`: one short loop serves all
sums, and a coefficient serves two components of all lanes.
"""

from __future__ import annotations

import numpy as np

from reference_impl.fast.dop853 import DENSE_TABLE, E3, E5, END, EXTRA, EXTRA_TABLE, STAGES, TABLE
from reference_impl.fast.lanes.layout import SLOPES, STATE, TAKEN, Y
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.lanes import equal, get, put
from reference_impl.machine_code.structs import Matrix

SUMS = (*TABLE, END, *EXTRA_TABLE, E5, E3, *DENSE_TABLE)
"""Rows of the sums: stages 1 to 11, the end of the step, stages 13 to 15 of the interpolant, then those below"""
ERRORS, DENSE = STAGES + EXTRA, STAGES + EXTRA + 2
TERMS = np.array([np.count_nonzero(weights) for _, weights in SUMS])
COLUMNS = np.array([(*columns, *[0] * (STAGES - len(columns))) for columns, _ in SUMS])
WEIGHTS = np.array([(*weights, *[0.0] * (STAGES - len(weights))) for _, weights in SUMS])


@compiled
def weighted_sum(k: int, n: int, kept: float, to: int, g: Matrix) -> None:
    """Rows from `to`: `kept` times the current state plus the step times sum `k` of the slopes."""
    h, s = get(g, TAKEN), 2 * n + 4
    y, slopes = STATE + Y * s, STATE + SLOPES * s
    for i in range(0, s, 2):  # the number of components is even
        first, second = equal(0.0), equal(0.0)
        for j in range(TERMS[k]):
            weight, row = equal(WEIGHTS[k, j]), slopes + COLUMNS[k, j] * s + i
            first = first + weight * get(g, row)
            second = second + weight * get(g, row + 1)
        put(g, to + i, kept * get(g, y + i) + h * first)
        put(g, to + i + 1, kept * get(g, y + i + 1) + h * second)
