"""Units in which `rtol` counts: what a requested relative accuracy is relative to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from scenarios import Scene


@dataclass(frozen=True)
class AccuracyScales:
    """Unit of each kind of component; `rtol` times the unit is the requested error of one step.

    A solver with a tolerance for each component takes ``atol = rtol * unit``, and its own relative tolerance as small
    as it permits. A relative tolerance of the component would be lost where the component passes through zero.
    """

    track_m: float
    """Of the centre of mass, or the origin of the frame: initial distance from the centre of the body"""
    length_m: float
    """Of a bar's place relative to the frame: the longest bar"""
    rate_rad_s: float
    """Of a bar's rate: the largest of the circular orbit's rate and the bars' initial rates"""

    @property
    def track_speed_m_s(self) -> float:
        """Of the velocity of the centre of mass."""
        return self.track_m * self.rate_rad_s

    @property
    def speed_m_s(self) -> float:
        """Of a bar's velocity relative to the frame."""
        return self.length_m * self.rate_rad_s

    @property
    def track(self) -> Array:
        """Units of the frame's origin and its velocity, (4,)."""
        return np.repeat([self.track_m, self.track_speed_m_s], 2)

    def joint_coordinates(self, bars: int) -> Array:
        """Units of joint coordinates and of their rates, (2 (N + 2),): lengths, angles, and the rate of each."""
        units = np.repeat([self.length_m, 1.0], [2, bars])
        return np.concatenate([units, self.rate_rad_s * units])


def accuracy_scales(scene: Scene) -> AccuracyScales:
    """Units of `scene`.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    AccuracyScales
    """
    circular = math.sqrt(scene.central_body.mu_m3_s2 / scene.radius0_m**3)
    rate = max(circular, *(abs(a) * scene.orbital_rate_rad_s for a in scene.chain.rate_factor))
    return AccuracyScales(scene.radius0_m, max(scene.chain.length_m), rate)
