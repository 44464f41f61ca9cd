"""Gravity fields on bars in plain floats: inverse powers of the distance.

A field -A Z/r^n is the central body's with n = 3 and A its mu, that of J2 with n = 5 and A = (3/2) mu J2 R², and a
third body's with n = 3. Its gradient along a bar exerts a torque, and the bar's second moment changes the force:

    torque        n A J (u·Z)(n·Z)/r^(n+2)
    acceleration  (n A J/2m r^(n+2)) (Z + 2 (u·Z) u - (n+2) c² Z),   c = u·Z/r
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, expm1, log1p, sin
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import Oblateness


@dataclass(frozen=True)
class InversePowerField:
    """The field -A Z/r^n."""

    strength: float
    """A, m^n/s²"""
    power: int
    """n"""

    def pull(self, x: float, y: float) -> tuple[float, float]:
        """Acceleration at (x, y) m from its centre, m/s²."""
        k = -self.strength * (x * x + y * y) ** (-0.5 * self.power)
        return k * x, k * y

    def difference(self, x0: float, y0: float, x: float, y: float) -> tuple[float, float]:
        """Acceleration at (x0 + x, y0 + y) less that at (x0, y0), by Encke's q, without cancellation."""
        r2, px, py = x0 * x0 + y0 * y0, x0 + x, y0 + y
        change = expm1(-0.5 * self.power * log1p(((x0 + px) * x + (y0 + py) * y) / r2))
        k = -self.strength * r2 ** (-0.5 * self.power)
        return k * (x + px * change), k * (y + py * change)

    def spin(self, x: float, y: float, c: float, s: float) -> float:
        """Angular acceleration of a bar at (x, y) m along (c, s), rad/s²."""
        n = self.power
        spin: float = n * self.strength * (c * x + s * y) * (c * y - s * x) * (x * x + y * y) ** (-0.5 * (n + 2))
        return spin

    def second_moment(self, x: float, y: float, c: float, s: float, spread: float) -> tuple[float, float]:
        """Acceleration of a bar with J/m = `spread` m² less that of a point, m/s²."""
        n, r2, p = self.power, x * x + y * y, c * x + s * y
        k = 0.5 * n * self.strength * spread * r2 ** (-0.5 * (n + 2))
        along = 1.0 - (n + 2) * p * p / r2
        return k * (along * x + 2.0 * p * c), k * (along * y + 2.0 * p * s)


@dataclass(frozen=True)
class FieldLoad:
    """Load of a field besides the central body's: on the bars' centres and, by the gravity model, beyond."""

    of_rates: ClassVar[bool] = False
    bars: list[BarProperties]
    field: InversePowerField
    turns: bool
    """Whether the field exerts torques"""
    spread: bool
    """Whether the bars' second moment changes the force"""

    def source(self, t_s: float) -> tuple[float, float]:
        """Position of the source, m from the centre of the central body."""
        del t_s
        return 0.0, 0.0

    def point(self, x0: float, y0: float, x: float, y: float) -> tuple[float, float]:
        """Acceleration of a bar's centre at (x, y) m in the frame, whose origin is at (x0, y0) m from the source."""
        return self.field.difference(x0, y0, x, y)

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del rates
        bx, by = self.source(frame.t_s)
        x0, y0 = frame.x - bx, frame.y - by
        return [self.load(x0, y0, position, bar) for position, bar in zip(positions, self.bars, strict=True)]

    def load(self, x0: float, y0: float, position: BarPosition, bar: BarProperties) -> Load:
        """Load of one bar, the frame's origin at (x0, y0) m from the source."""
        x, y, angle = position
        ax, ay = self.point(x0, y0, x, y)
        if not self.turns:
            return ax, ay, 0.0
        c, s = cos(angle), sin(angle)
        spin = self.field.spin(x0 + x, y0 + y, c, s)
        if self.spread:
            dx, dy = self.field.second_moment(x0 + x, y0 + y, c, s, bar.inertia_kg_m2 / bar.mass_kg)
            ax, ay = ax + dx, ay + dy
        return ax, ay, spin


class OblatenessLoad(FieldLoad):
    """J2, in a frame that falls with it."""


class AbsoluteOblatenessLoad(FieldLoad):
    """J2, in a frame at rest at the centre of the body."""

    def point(self, x0: float, y0: float, x: float, y: float) -> tuple[float, float]:
        """Total acceleration."""
        return self.field.pull(x0 + x, y0 + y)


def oblateness_field(mu: float, oblateness: Oblateness) -> InversePowerField:
    """Field of J2 in the equatorial plane."""
    return InversePowerField(1.5 * mu * oblateness.j2 * oblateness.radius_m**2, 5)
