"""Number of pymunk's joint iterations (sweeps) per step, from the masses; with too few the joints separate."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigvalsh_tridiagonal

if TYPE_CHECKING:
    from scenarios.scene import Chain, Scene

SWEEPS_LEAVE = 0.05  # remaining share of an error of the impulses after a step; the joints separate from about 0.5
FEWEST_SWEEPS = 8
MOST_SWEEPS = 1000  # of a step: about 57 equal bars, at a millisecond or two for each step
SMALLEST_TURN = 1e-6  # rad in a step: the remaining errors of smaller changes are below the rounding of positions
COLD_START_FACTOR = 12  # more sweeps, to round-off, while the cached impulses are no start for the next ones
SETTLED_STEPS = 3
"""Steps until the cached impulses are a good start for the next ones. The first half step has none. pymunk does not
rescale the cached impulse when the step's length changes, so the second whole step starts from half the required
impulse."""


def sweeps(chain: Chain, leave: float = SWEEPS_LEAVE) -> int:
    """Sweeps over the joints in one step: 0.3 N² for equal bars, more for light bars between heavy ones.

    `leave` is the remaining share of an error of the impulses.

    pymunk's sweeps are Gauss-Seidel iterations on the joint system. They converge slowest along a straight chain, where
    the system is tridiagonal with 1/m_j + 1/m_{j+1} and -1/m_{j+1}. One sweep reduces an error by the square of the
    largest eigenvalue of Jacobi's iteration.
    """
    if chain.bars < 3:
        return FEWEST_SWEEPS
    give = 1.0 / np.array(chain.mass_kg)
    diagonal = give[:-1] + give[1:]
    coupling = give[1:-1] / np.sqrt(diagonal[:-1] * diagonal[1:])
    last = chain.bars - 2
    slowest = float(eigvalsh_tridiagonal(np.zeros(last + 1), coupling, select="i", select_range=(last, last))[0])
    return max(FEWEST_SWEEPS, math.ceil(0.5 * math.log(leave) / math.log(slowest)))


def step_sweeps(scene: Scene, dt_s: float) -> int:
    """Sweeps in each step of a run, at least as many as hold the joints.

    Impulses change by about h w relative to themselves from step to step. The sweeps leave a share of that change as an
    error of the reactions, until the resulting gaps compensate for it some steps later. The share is limited to h w,
    which makes the error one of second order, like the method's own.
    """
    least, most = sweeps(scene.chain), MOST_SWEEPS
    turn = dt_s * scene.fastest_rate_rad_s
    wanted = sweeps(scene.chain, min(SWEEPS_LEAVE, max(turn, SMALLEST_TURN)))
    return max(least, min(wanted, most))
