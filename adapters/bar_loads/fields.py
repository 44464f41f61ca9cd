"""Gravity on bars besides that of the central body on points: second moments, slender bars, J2, third bodies.

A field -A Z/r^n is the central body's with n = 3 and A its mu, that of J2 with n = 5 and A = (3/2) mu J2 R², and a
third body's with n = 3. Its gradient along a bar exerts a torque, and the bar's second moment changes the force:

    torque        n A J (u·Z)(n·Z)/r^(n+2)
    acceleration  (n A J/2m r^(n+2)) (Z + 2 (u·Z) u - (n+2) c² Z),   c = u·Z/r

Symbols of slender bars as in docs/effects/gravity.md: p, q, e, x, delta, sigma, tau, and sigma_root for its final ς.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, expm1, hypot, log1p, sin, sqrt
from typing import TYPE_CHECKING

from adapters.bar_loads.interface import BarLoad

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import Oblateness, ThirdBody


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


def oblateness_field(mu: float, oblateness: Oblateness) -> InversePowerField:
    """Field of J2 in the equatorial plane."""
    return InversePowerField(1.5 * mu * oblateness.j2 * oblateness.radius_m**2, 5)


def third_body_position(body: ThirdBody, t_s: float) -> tuple[float, float]:
    """Position of a third body at `t_s`, m from the centre of the central body."""
    longitude = body.longitude_rad + body.rate_rad_s * t_s
    return body.distance_m * cos(longitude), body.distance_m * sin(longitude)


@dataclass(frozen=True)
class FieldLoad(BarLoad):
    """Load of a field besides the central body's: on the bars' centres and, by the gravity model, beyond.

    Of J2, the acceleration is less that of the frame's origin where the frame falls. Of a third body it is always: in a
    frame at rest the origin is the central body's centre, which falls towards the third body.
    """

    bars: list[BarProperties]
    field: InversePowerField
    turns: bool
    """Whether the field exerts torques"""
    spread: bool
    """Whether the bars' second moment changes the force"""
    body: ThirdBody | None = None
    """Source of the field, on its circle; None: the central body"""
    whole: bool = False
    """Whether nothing is subtracted"""

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del rates
        bx, by = third_body_position(self.body, frame.t_s) if self.body else (0.0, 0.0)
        x0, y0 = frame.x - bx, frame.y - by
        return [self.load(x0, y0, position, bar) for position, bar in zip(positions, self.bars, strict=True)]

    def load(self, x0: float, y0: float, position: BarPosition, bar: BarProperties) -> Load:
        """Load of one bar, the frame's origin at (x0, y0) m from the source."""
        x, y, angle = position
        ax, ay = self.field.pull(x0 + x, y0 + y) if self.whole else self.field.difference(x0, y0, x, y)
        if not self.turns:
            return ax, ay, 0.0
        c, s = cos(angle), sin(angle)
        spin = self.field.spin(x0 + x, y0 + y, c, s)
        if self.spread:
            dx, dy = self.field.second_moment(x0 + x, y0 + y, c, s, bar.inertia_kg_m2 / bar.mass_kg)
            ax, ay = ax + dx, ay + dy
        return ax, ay, spin


@dataclass(frozen=True)
class SecondMomentLoad(BarLoad):
    """Acceleration by the central body beyond that of a point, to the bar's second moment."""

    bars: list[BarProperties]
    field: InversePowerField

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Accelerations of each bar."""
        del rates
        moment = self.field.second_moment
        return [
            (*moment(frame.x + x, frame.y + y, cos(a), sin(a), bar.inertia_kg_m2 / bar.mass_kg), 0.0)
            for (x, y, a), bar in zip(positions, self.bars, strict=True)
        ]


@dataclass(frozen=True)
class SlenderLoad(BarLoad):
    """Accelerations of a uniform slender bar by the central body beyond those of a point."""

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
