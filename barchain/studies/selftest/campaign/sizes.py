"""Size of a fault in a run's samples, relative to the sizes of the quantities, as detection limits are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.metrics.quantities import differences

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array, Trajectory

LOST = 1.0  # of a quantity's scale: what a sample that is missing counts as
MEASURED = {"gap": "gap_m", "com_residual": "com_residual_m"}


def changes(unmodified: Trajectory, faulty: Trajectory) -> dict[str, Array]:
    """Largest change over bars or joints at each common sample, (n,) for each quantity, SI units."""
    n = min(len(unmodified.t_s), len(faulty.t_s))
    found = differences(unmodified, faulty)
    for name, field in MEASURED.items():
        mine, theirs = getattr(unmodified, field), getattr(faulty, field)
        if mine is not None and theirs is not None and mine.size:
            found[name] = np.abs(mine[:n] - theirs[:n]).reshape(n, -1).max(axis=1)
    return found


def sizes(
    unmodified: Trajectory, faulty: Trajectory, scale: Mapping[str, float], until_s: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Largest relative change that a fault makes in each quantity.

    Parameters
    ----------
    unmodified, faulty : Trajectory
        The same run without the fault and with it.
    scale : mapping
        Size of each quantity in the scene, SI units, see `barchain.judge.scales`.
    until_s : mapping, optional
        For each quantity, the last instant that counts, s; the whole run by default.

    Returns
    -------
    dict
        Shares of the scales. A sample that only one of the runs has counts as the whole scale.
    """
    found = {}
    for name, change in changes(unmodified, faulty).items():
        lost = np.full(abs(len(unmodified.t_s) - len(faulty.t_s)), LOST)
        t_s = max(unmodified.t_s, faulty.t_s, key=len)
        share = np.concatenate([change / scale[name] if scale[name] else np.where(change > 0.0, np.inf, 0.0), lost])
        counts = t_s <= (until_s or {}).get(name, np.inf)
        found[name] = float(share[counts].max(initial=0.0))
    return found


def larger(a: Mapping[str, float], b: Mapping[str, float]) -> dict[str, float]:
    """Larger of two sizes of each quantity."""
    return {name: max(a.get(name, 0.0), b.get(name, 0.0)) for name in {**a, **b}}
