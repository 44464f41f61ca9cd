"""Rows of a group: W chains in step, each quantity a row of W numbers, one for each lane.

A group is one array (rows, W), as compiled code passes seven numbers for each of its arrays. Counts, clock and
constants come first, then blocks of s = 2N+4 rows in the order [theta, Z0, theta', Z0'], then the rows of each bar.
Row ``STATE + BLOCK s + i`` is component i of a block; row ``STATE + BLOCKS s + BAR_ROWS j + ROW`` belongs to bar j.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.dop853 import POWER, ROWS
from reference_impl.machine_code.values import WIDTH

if TYPE_CHECKING:
    from reference_impl.fast.batch import Batch
    from reference_impl.machine_code.structs import Matrix

# MEMBER, number of the chain in its batch; counts of a chain: SAMPLED samples, STEPS, EVALUATIONS
MEMBER, SAMPLED, STEPS, EVALUATIONS = range(4)
# NOW, s; STEP, size of the next step, s; REACHED, end of the last step, s; TAKEN, its size, s; REJECTED, 1 after a
# rejected step
NOW, STEP, REACHED, TAKEN, REJECTED = range(4, 9)
# MU, m³/s², and the bounds of reference_impl.fast.stepper.SurfaceBounds
MU, LEAST_RADIUS, LEAST_PERIGEE, LARGEST_PULL = range(9, 13)
STATE = 13  # first row of the blocks
# blocks: Y current states; ATOL requested and ALLOWED error of a step; SLOPES rates of the 16 stages, the first the
# current rates; END state of a stage and of the step's end; SCRATCH; POWERS interpolants of the last step
Y, ATOL, ALLOWED, SLOPES = range(4)
END, SCRATCH, POWERS = range(SLOPES + ROWS, SLOPES + ROWS + 3)
BLOCKS = POWERS + POWER
STARTED = SLOPES + 1  # blocks of a chain at its start
# rows of a bar: constants as in reference_impl.fast.layout.CompiledChain.bars; U unit vectors, D positions, ANGULAR, P
# and H of the sweep, R reactions
CONSTANTS = 10
UX, UY, DX, DY, ANGULAR, PX, PY, HXX, HXY, HYX, HYY, RX, RY = range(CONSTANTS, CONSTANTS + 13)
BAR_ROWS = CONSTANTS + 13


def new_group(bars: int) -> Matrix:
    """Group of chains of `bars` bars."""
    return np.zeros((STATE + BLOCKS * (2 * bars + 4) + BAR_ROWS * bars, WIDTH))


def start_columns(batch: Batch) -> Matrix:
    """Counts, constants and states of every chain of a batch at its start, shape (runs, STATE + 2s + 10 N).

    The rows are those of a group up to block ATOL, then the constants of each bar.
    """
    runs, constants, bars = batch.bars.shape
    s = 2 * bars + 4
    columns = np.zeros((runs, STATE + 2 * s + constants * bars))
    columns[:, MEMBER], columns[:, SAMPLED] = np.arange(runs), 1.0
    bounds = (batch.mu_m3_s2, batch.contact_free_radius_m, batch.contact_free_perigee_m, batch.largest_pull_m_s2)
    columns[:, MU : MU + len(bounds)] = np.stack(bounds, axis=1)
    columns[:, STATE : STATE + s], columns[:, STATE + s : STATE + 2 * s] = batch.y0[:, :s], batch.atol[:, :s]
    columns[:, STATE + 2 * s :] = batch.bars.transpose(0, 2, 1).reshape(runs, -1)
    return columns
