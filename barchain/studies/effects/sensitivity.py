"""Change of a run by switching an effect, and the numerical error of that change.

Both scenes are run at a tolerance and at one ten times looser. As in :mod:`barchain.solutions.reference`, the
difference of the two bounds the tighter run's own error; so the difference of two scenes is off by at most the sum of
both scenes' bounds, and a change below that sum is not resolved. Nothing is compared after either scene's two runs have
parted.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.metrics.quantities import differences
from barchain.solutions.reference import divergence_instant_s
from reports.tables.effects import QUANTITIES

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory

LOOSER = 10.0
ROUNDING = 4.0 * float(np.finfo(float).eps)  # two roundings of each run, that even equal runs may hide


@dataclass(frozen=True)
class RunPair:
    """One scene at two tolerances."""

    tight: Trajectory
    loose: Trajectory

    @property
    def limit_s(self) -> float:
        """Last instant before the two part."""
        return divergence_instant_s(self.tight, self.loose)


@dataclass(frozen=True)
class SwitchResponse:
    """Changes that a switch causes; a quantity that either scene lacks is left out."""

    largest: dict[str, float]
    """``com`` (m), ``attitude`` (rad), ``reaction`` (N), the largest over what was compared"""
    noise: dict[str, float]
    """Numerical error of each change, by the same names"""
    compared_s: float
    """Until when"""


def change(scene: RunPair, switched: RunPair) -> SwitchResponse:
    """Largest differences of two scenes over their common samples."""
    until = min(scene.limit_s, switched.limit_s)
    apart = upto(until, scene.tight, switched.tight)
    own, other = (upto(until, runs.tight, runs.loose) for runs in (scene, switched))
    size = sizes(scene.tight, until)
    noise = {name: own[name] + other[name] + ROUNDING * size[name] for name in apart}
    return SwitchResponse(apart, noise, until)


def upto(until_s: float, a: Trajectory, b: Trajectory) -> dict[str, float]:
    """Largest difference of two runs until an instant, for each quantity."""
    inside = slice(0, int(np.searchsorted(a.t_s, until_s, side="right")))
    return {name: float(d[inside].max()) for name, d in differences(a, b).items() if name in QUANTITIES}


def sizes(trajectory: Trajectory, until_s: float) -> dict[str, float]:
    """Largest size of each quantity until an instant: the scale of its round-off."""
    inside = trajectory.t_s <= until_s
    found = {"com": largest(trajectory.com_m[inside]), "attitude": 1.0}
    if trajectory.reaction_N is not None and trajectory.reaction_N.shape[1]:
        found["reaction"] = largest(trajectory.reaction_N[inside])
    return found


def largest(vectors: Array) -> float:
    """Length of the longest plane vector."""
    return float(np.linalg.norm(vectors, axis=-1).max())
