"""Certified solution from two runs in quadruple precision, whose difference bounds the error.

The runs differ in tolerance and not in precision; docs/explanation/certified_solutions.md gives the reasons.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.heyoka.compiled import QUAD
from adapters.heyoka.run import HeyokaRun
from barchain.metrics.quantities import differences, largest
from barchain.solutions.certified_table import CertifiedTable, physics_digest
from barchain.solutions.reference import ROUNDED, UNIT_ROUNDOFF

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

CERTIFIED_RTOL, CERTIFIED_CHECK_RTOL = 1e-30, 1e-28
PRECISION = f"real128, tolerance {CERTIFIED_RTOL:g}, against real128, tolerance {CERTIFIED_CHECK_RTOL:g}"


def fresh(scene: Scene, times_s: Array) -> CertifiedTable:
    """Certified solution of `scene` at `times_s`, (n,) s, increasing from 0.

    Raises
    ------
    EngineError
        If either run fails.
    """
    fine, check = (run(scene, times_s, rtol) for rtol in (CERTIFIED_RTOL, CERTIFIED_CHECK_RTOL))
    return CertifiedTable(scene.name, physics_digest(scene), PRECISION, "", fine, error_bar(fine, check))


def run(scene: Scene, times_s: Array, rtol: float) -> Trajectory:
    """One run in quadruple precision, rounded to double."""
    made = HeyokaRun(scene, times_s, QUAD, rtol)
    made.walk()
    return made.trajectory()


def error_bar(fine: Trajectory, check: Trajectory) -> dict[str, Array]:
    """Bound of the error of `fine`, (n,) for each quantity, never falling.

    The looser run's error is at least the difference of the runs less the finer run's error, which is far smaller.
    The difference therefore bounds the finer run's error. Rounding of both runs to double is added.
    """
    apart = differences(fine, check)
    rounding = {name: ROUNDED * UNIT_ROUNDOFF * size for name, size in largest(fine).items()}
    return {name: np.maximum.accumulate(d) + rounding[name][: len(d)] for name, d in apart.items()}
