"""Third bodies' pull on bars in plain floats: tidal differences, never a difference of two large pulls."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

from adapters.bar_loads.fields import FieldLoad

if TYPE_CHECKING:
    from scenarios import ThirdBody


@dataclass(frozen=True)
class ThirdBodyLoad(FieldLoad):
    """A third body's pull less that on the frame's origin: a falling one, or the central body, which falls too."""

    body: ThirdBody

    def source(self, t_s: float) -> tuple[float, float]:
        """On its circle."""
        return third_body_position(self.body, t_s)


def third_body_position(body: ThirdBody, t_s: float) -> tuple[float, float]:
    """Where a third body is at `t_s`, m from the centre of the central one."""
    longitude = body.longitude_rad + body.rate_rad_s * t_s
    return body.distance_m * cos(longitude), body.distance_m * sin(longitude)
