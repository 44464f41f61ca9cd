"""Units of length and time in heyoka's equations: powers of two, so that the change of units rounds no number."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Scene


@dataclass(frozen=True)
class HeyokaUnits:
    """Powers of two."""

    length_m: float
    time_s: float

    @property
    def force(self) -> float:
        """Unit of force, N; masses stay in kg."""
        return self.length_m / self.time_s**2


def units_of(scene: Scene) -> HeyokaUnits:
    """Units near the initial radius and the fastest rate."""
    return HeyokaUnits(2.0 ** round(math.log2(scene.radius0_m)), 2.0 ** -round(math.log2(scene.fastest_rate_rad_s)))
