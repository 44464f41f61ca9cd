"""Drag on bars in plain floats: free-molecular flow on a flat bar, docs/effects/drag.md."""

from __future__ import annotations

from math import copysign, cos, exp, hypot, sin
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import Drag


class DragLoad:
    """Force and torque of the air on each bar."""

    of_rates: ClassVar[bool] = True

    def __init__(self, bars: list[BarProperties], drag: Drag, radius_m: float) -> None:
        """Drag about a body of `radius_m`."""
        self.bars, self.drag = list(zip(bars, drag.width_m, strict=True)), drag
        self.reference_m = radius_m + drag.altitude_m
        self.held: Sequence[float] | None = None

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        r0 = hypot(frame.x, frame.y)
        faces = self.held or [0.0] * len(self.bars)
        return [
            self.load(frame, r0, position, rate, bar, width, face)
            for position, rate, (bar, width), face in zip(positions, rates, self.bars, faces, strict=True)
        ]

    def load(
        self,
        frame: FrameState,
        r0: float,
        position: BarPosition,
        rate: BarRate,
        bar: BarProperties,
        width: float,
        face: float,
    ) -> Load:
        """Load of one bar; the frame's origin is `r0` m from the body's centre, a `face` of 0 that of the state."""
        (x, y, angle), (vx, vy, w), drag = position, rate, self.drag
        px, py, c, s = frame.x + x, frame.y + y, cos(angle), sin(angle)
        r = hypot(px, py)
        higher = ((frame.x + px) * x + (frame.y + py) * y) / (r + r0)  # r - r0
        density = drag.density_kg_m3 * exp((self.reference_m - r0 - higher) / drag.scale_height_m)
        kappa = (c * px + s * py) / (r * drag.scale_height_m)
        turn = drag.rotation_rad_s
        wx, wy, w = frame.vx + vx + turn * py, frame.vy + vy - turn * px, w - turn
        across, along, length = c * wy - s * wx, c * wx + s * wy, 2.0 * bar.half_length_m
        i2, i4 = length**3 / 12.0, length**5 / 80.0
        k = -0.5 * width * density * (face or copysign(1.0, across))
        normal = k * drag.normal_coefficient * (across * (length * across - 2.0 * kappa * i2 * w) + i2 * w * w)
        tangent = k * drag.tangential_coefficient * along * (length * across - kappa * i2 * w)
        square = i2 * across * across + i4 * w * w
        torque = k * drag.normal_coefficient * (2.0 * i2 * across * w - kappa * square)
        return (
            (tangent * c - normal * s) / bar.mass_kg,
            (tangent * s + normal * c) / bar.mass_kg,
            torque / bar.inertia_kg_m2,
        )

    def incidence(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[float]:
        """Sine of the angle between each bar and its velocity relative to the air."""
        turn, found = self.drag.rotation_rad_s, []
        for (x, y, a), (vx, vy, _) in zip(positions, rates, strict=True):
            wx, wy = frame.vx + vx + turn * (frame.y + y), frame.vy + vy - turn * (frame.x + x)
            found.append((cos(a) * wy - sin(a) * wx) / hypot(wx, wy))
        return found
