"""Accelerations of a bar by gravity beyond a point mass and the gradient's torque, in plain floats.

Symbols as in docs/effects/gravity.md: p, q, e, x, delta, sigma, tau, and sigma_root for its final ς.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, sin, sqrt
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.fields import InversePowerField
    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load


@dataclass(frozen=True)
class SecondMomentLoad:
    """Acceleration by the central body beyond that of a point, to the bar's second moment."""

    of_rates: ClassVar[bool] = False
    bars: list[BarProperties]
    field: InversePowerField

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Accelerations of each bar."""
        del rates
        return [
            self.load(frame.x + x, frame.y + y, a, bar) for (x, y, a), bar in zip(positions, self.bars, strict=True)
        ]

    def load(self, x: float, y: float, angle: float, bar: BarProperties) -> Load:
        """Accelerations of one bar at (x, y) m from the centre of the body."""
        return *self.field.second_moment(x, y, cos(angle), sin(angle), bar.inertia_kg_m2 / bar.mass_kg), 0.0


@dataclass(frozen=True)
class SlenderLoad:
    """Accelerations of a uniform slender bar by the central body beyond those of a point."""

    of_rates: ClassVar[bool] = False
    bars: list[BarProperties]
    mu: float
    """m³/s²"""

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Accelerations of each bar."""
        del rates
        return [
            slender(self.mu, frame.x + x, frame.y + y, a, bar.half_length_m)
            for (x, y, a), bar in zip(positions, self.bars, strict=True)
        ]


def slender(mu: float, x: float, y: float, angle: float, h: float) -> Load:
    """Accelerations of a bar of half length `h` at (x, y) m from the body beyond a point's, free of cancellation."""
    ux, uy = cos(angle), sin(angle)
    p, q, r2 = ux * x + uy * y, ux * y - uy * x, x * x + y * y
    e, one_minus_2c2 = h * h / r2, 1.0 - 2.0 * p * p / r2
    delta = sqrt1pm1(e * (2.0 * one_minus_2c2 + e))  # ab/r² - 1
    sigma, tau = 0.5 * (e + delta), 0.5 * (delta - e)  # S²/4r² - 1, and (S² - l²)/4r² - 1
    sigma_root = sqrt1pm1(sigma)  # S/2r - 1
    b = (delta + (1.0 + delta) * sigma_root) / (1.0 + delta + (1.0 + delta) * sigma_root)
    c = (tau + delta + tau * delta - sigma_root) / ((1.0 + tau) * (1.0 + delta))
    k = mu / (r2 * sqrt(r2))
    ends = hypot(x - h * ux, y - h * uy), hypot(x + h * ux, y + h * uy)
    ab, total = ends[0] * ends[1], ends[0] + ends[1]
    spin = 24.0 * mu * p * q / (ab * total * (total * total - 4.0 * h * h))  # torque over m l²/12
    return k * (p * b * ux - q * c * uy), k * (p * b * uy + q * c * ux), spin


def sqrt1pm1(x: float) -> float:
    """Sqrt(1 + x) - 1 without cancellation."""
    return x / (1.0 + sqrt(1.0 + x))
