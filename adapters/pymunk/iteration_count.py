"""How many sweeps over the joints pymunk needs in one step: worked out, because too few burst the joints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigvalsh_tridiagonal

if TYPE_CHECKING:
    from scenarios.scene import Chain, Scene

SWEEPS_LEAVE = 0.05  # of an error of the impulses after a step's sweeps; the joints burst from about 0.5 on
FEWEST_SWEEPS = 8
MOST_SWEEPS = 1000  # of a step: about 57 equal bars, at a millisecond or two for each step
SMALLEST_TURN = 1e-6  # rad in a step: what is left of less is below the rounding of places
COLD_START_FACTOR = 12  # more sweeps, to round-off, while the cached impulses are no start for the next ones
SETTLED_STEPS = 3
"""Steps after which they are: the first half step has none, and the engine, whose cached impulse is not
rescaled when the step's length changes, starts the second whole step from half of what it needs."""


def sweeps(chain: Chain, leave: float = SWEEPS_LEAVE) -> int:
    """Sweeps over the joints that one step needs: 0.3 N² for equal bars, more for light ones between heavy.

    `leave` is what they leave of an error of the impulses.

    The engine's sweeps are Gauss-Seidel's on the joint system, slowest along a straight chain, where the
    system is tridiagonal with 1/m_j + 1/m_{j+1} and -1/m_{j+1}. Of an error one sweep leaves the square of
    the largest eigenvalue of Jacobi's.
    """
    if chain.bars < 3:
        return FEWEST_SWEEPS
    give = 1.0 / np.array(chain.mass_kg)
    diagonal = give[:-1] + give[1:]
    coupling = give[1:-1] / np.sqrt(diagonal[:-1] * diagonal[1:])
    slowest = float(eigvalsh_tridiagonal(np.zeros(chain.bars - 1), coupling)[-1])
    return max(FEWEST_SWEEPS, math.ceil(0.5 * math.log(leave) / math.log(slowest)))


def step_sweeps(scene: Scene, dt_s: float) -> int:
    """Sweeps in each step of a run, and at least those that hold the joints.

    Impulses change by about h w of themselves from step to step, and what the sweeps leave of that change is an error
    of the reactions, until the gaps that it opens make up for it some steps later. So no more than h w is left, which
    makes that error one of second order, as the method's own are.
    """
    least, most = sweeps(scene.chain), MOST_SWEEPS
    turn = dt_s * scene.fastest_rate_rad_s
    wanted = sweeps(scene.chain, min(SWEEPS_LEAVE, max(turn, SMALLEST_TURN)))
    return max(least, min(wanted, most))
