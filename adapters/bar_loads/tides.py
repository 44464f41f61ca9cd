"""Third bodies' gravity on bars in plain floats, as tidal differences without cancellation."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

from adapters.bar_loads.fields import FieldLoad

if TYPE_CHECKING:
    from scenarios import ThirdBody


@dataclass(frozen=True)
class ThirdBodyLoad(FieldLoad):
    """Third body's gravity less that on the frame's origin, which falls freely or is the central body's centre."""

    body: ThirdBody

    def source(self, t_s: float) -> tuple[float, float]:
        """Position on its circle."""
        return third_body_position(self.body, t_s)


def third_body_position(body: ThirdBody, t_s: float) -> tuple[float, float]:
    """Position of a third body at `t_s`, m from the centre of the central body."""
    longitude = body.longitude_rad + body.rate_rad_s * t_s
    return body.distance_m * cos(longitude), body.distance_m * sin(longitude)
