"""Sunlight on flat bars in plain floats, without shadow: docs/effects/solar_pressure.md."""

from __future__ import annotations

from math import copysign, cos, sin
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import SolarPressure


class SunlightLoad:
    """Force of the light on each bar."""

    of_rates: ClassVar[bool] = False

    def __init__(self, bars: list[BarProperties], light: SolarPressure) -> None:
        """Light of a scene."""
        self.light = light
        self.held: Sequence[float] | None = None
        areas = zip(bars, light.width_m, strict=True)
        self.weight = [light.pressure_Pa * width * 2.0 * bar.half_length_m / bar.mass_kg for bar, width in areas]

    def sun(self, t_s: float) -> tuple[float, float]:
        """Unit vector to the Sun."""
        longitude = self.light.sun_longitude_rad + self.light.sun_rate_rad_s * t_s
        return cos(longitude), sin(longitude)

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del rates
        sx, sy = self.sun(frame.t_s)
        faces = self.held or [0.0] * len(self.weight)
        return [
            self.load(sx, sy, angle, weight, face)
            for (_, _, angle), weight, face in zip(positions, self.weight, faces, strict=True)
        ]

    def load(self, sx: float, sy: float, angle: float, weight: float, face: float) -> Load:
        """Load of one bar.

        `weight` is the acceleration in m/s² of a black bar normal to the light; a `face` of 0 is that of the state.
        """
        c, s, mirrored = cos(angle), sin(angle), self.light.reflectivity
        facing = c * sy - s * sx
        side = 2.0 * mirrored * facing  # 2 rho k n' = 2 rho (n·s) n
        k = -weight * facing * (face or copysign(1.0, facing))
        return k * ((1.0 - mirrored) * sx - side * s), k * ((1.0 - mirrored) * sy + side * c), 0.0

    def incidence(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[float]:
        """Sine of the angle between each bar and the direction of the Sun."""
        del rates
        sx, sy = self.sun(frame.t_s)
        return [cos(a) * sy - sin(a) * sx for _, _, a in positions]
