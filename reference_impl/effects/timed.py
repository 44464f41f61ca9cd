"""Effects whose size is a table in time, piecewise linear, with jumps where two instants are equal and zero outside."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.effect import ChainEffect, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array

SAME_INSTANT = 1e-12  # relative; a sample this close after an instant of the table coincides with that instant
SMALLEST = np.nextafter(0.0, 1.0)


@dataclass(frozen=True)
class TimedEffect(ChainEffect, ABC):
    """Effect with a table of sizes; the mode is the segment of its table, counted from 0, or -1 outside."""

    times_s: Array
    """(k,)"""
    sizes: Array
    """(k,)"""

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants of the table."""
        return tuple(self.times_s.tolist())

    def interpolated(self, piece: Array, t_s: float) -> Array:
        """Size on segments of the table, extrapolated beyond their ends; 0 outside the table."""
        k = piece.astype(int)
        t0, f0, t1, f1 = self.times_s[k], self.sizes[k], self.times_s[k + 1], self.sizes[k + 1]
        found: Array = np.where(k < 0, 0.0, f0 + (f1 - f0) * ((t_s - t0) / (t1 - t0)))
        return found

    def size(self, at: EffectState, mode: Array | None) -> Array:
        """Size (1,) at a state, in the given mode; None: the mode follows from the state."""
        return self.interpolated(self.mode(at) if mode is None else mode, at.t_s)

    def mode(self, at: EffectState) -> Array:
        """Segment just before an instant; at t = 0, just after."""
        return self.segment_at(np.maximum(at.t_s * (1.0 - SAME_INSTANT), SMALLEST))

    def segment_mode(self, start_s: float, end_s: float) -> Array:
        """Segment between two known instants."""
        return self.segment_at(0.5 * (start_s + end_s))

    def segment_at(self, t_s: float) -> Array:
        """(1,) index of the segment that contains an instant; of instants (k, 1) as many."""
        after = np.searchsorted(self.times_s, np.atleast_1d(t_s))
        found: Array = np.where(after < len(self.times_s), after - 1.0, -1.0)
        return found
