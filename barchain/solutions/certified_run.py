"""A fresh truth: two runs in quadruple precision, and what stands between them.

See docs/certified_solutions.md for why two tolerances in one precision, and not two precisions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.heyoka.compiled import QUAD
from adapters.heyoka.run import Run
from barchain.metrics.quantities import differences
from barchain.solutions.certified_table import CertifiedTable, largest, physics_digest

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

FINE_RTOL, CHECK_RTOL = 1e-30, 1e-28
PRECISION = f"real128, tolerance {FINE_RTOL:g}, against real128, tolerance {CHECK_RTOL:g}"
UNIT_ROUNDOFF = 2.0**-53
ROUNDED = 3.0  # the result's own rounding, and that of the two results whose difference is taken


def fresh(scene: Scene, times_s: Array) -> CertifiedTable:
    """Truth of `scene` at `times_s`, (n,) s, increasing from 0.

    Raises
    ------
    EngineError
        If either run fails.
    """
    fine, check = (run(scene, times_s, rtol) for rtol in (FINE_RTOL, CHECK_RTOL))
    return CertifiedTable(scene.name, physics_digest(scene), PRECISION, "", fine, error_bar(fine, check))


def run(scene: Scene, times_s: Array, rtol: float) -> Trajectory:
    """One run in quadruple precision, rounded to double."""
    made = Run(scene, times_s, QUAD, rtol)
    made.walk()
    return made.trajectory()


def error_bar(fine: Trajectory, check: Trajectory) -> dict[str, Array]:
    """Bound of the error of `fine`, (n,) for each quantity, never falling.

    The looser run's error is at least their difference less the finer run's own, which is far smaller; so the
    difference bounds the finer run's error, with both runs' roundings to double on top.
    """
    apart = differences(fine, check)
    rounding = {name: ROUNDED * UNIT_ROUNDOFF * size for name, size in largest(fine).items()}
    return {name: np.maximum.accumulate(d) + rounding[name][: len(d)] for name, d in apart.items()}
