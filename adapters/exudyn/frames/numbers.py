"""Quantities in the loads' expressions: a bar's motion in the frame, and the frame's orbit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

Number = Any
"""A float, an array, or Exudyn's symbolic Real: all have the same arithmetic."""


@dataclass(frozen=True)
class BarMotion:
    """Motion of a bar in the frame's axes."""

    x_m: Number
    y_m: Number
    vx_m_s: Number
    vy_m_s: Number
    cosine: Number
    """of the bar's angle from the frame's x axis"""
    sine: Number
    spin_rad_s: Number = 0.0
    """relative to the frame"""


@dataclass(frozen=True)
class OrbitNumbers:
    """The frame's orbit, named as in :class:`adapters.exudyn.frames.orbit.OrbitTrack`."""

    radius_m: Number
    rate_rad_s: Number
    spin_up_rad_s2: Number
    pull_s2: Number
    shape: Number
