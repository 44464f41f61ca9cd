"""Gravity of the central body on a bar in plain floats: for few numbers Python's arithmetic is faster than NumPy's.

Each `load` is the acceleration of a bar's centre and its angular acceleration. In the moving frame the load is the
field less the field at the frame's origin, by Encke's q, without subtraction of large numbers.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from math import cos, expm1, hypot, log1p, sin, sqrt
from typing import TYPE_CHECKING, final

from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.bar_loads.interface import BarProperties, Load
    from scenarios import Scene


class LandedError(Exception):
    """A bar is at or below the surface: raised by `ChainForces`, unless it was made with ``surface=False``."""


class Loads(ABC):
    """Gravity of a scene's central body on points, with its gradient where the model has one."""

    def __init__(self, scene: Scene, *, surface: bool = True) -> None:
        """Gravity of `scene`; without `surface` bars may pass the surface, for trial states of a solver."""
        self.mu = scene.central_body.mu_m3_s2
        self.radius = scene.central_body.radius_m
        self.gradient = scene.effects.gravity in (Gravity.GRADIENT, Gravity.QUADRUPOLE)
        alarm_m = self.radius + max(*scene.chain.left_m, *scene.chain.right_m) if surface else 0.0
        self.alarm2 = alarm_m**2  # m²: above it no bar reaches the surface

    @abstractmethod
    def move_to(self, x: float, y: float) -> None:
        """Set the frame's origin to (x, y) m from the centre of the body."""

    @abstractmethod
    def load(self, x: float, y: float, angle: float, bar: BarProperties) -> Load:
        """Acceleration of a bar at (x, y) m in the frame, at `angle` rad.

        Raises
        ------
        LandedError
            If the bar touches the surface.
        """

    def spin(self, x: float, y: float, r2: float, angle: float) -> float:
        """Angular acceleration 3 mu sin(phi) cos(phi)/r³ of a bar at (x, y) m, rad/s²."""
        c, s = cos(angle), sin(angle)
        return 3.0 * self.mu * (c * x + s * y) * (c * y - s * x) / (r2 * r2 * sqrt(r2))

    def check_height(self, x: float, y: float, angle: float, bar: BarProperties) -> None:
        """Raise LandedError if the bar's nearest point is not above the surface."""
        c, s = cos(angle), sin(angle)
        foot = min(max(-(c * x + s * y), -bar.left_m), bar.right_m)
        if hypot(x + foot * c, y + foot * s) <= self.radius:
            raise LandedError


@final
class MovingLoads(Loads):
    """Gravity in a freely falling frame: differences only."""

    def move_to(self, x: float, y: float) -> None:
        """Set the frame's origin."""
        self.x, self.y = x, y
        self.r2 = x * x + y * y
        self.strength = -self.mu / (self.r2 * sqrt(self.r2))

    def load(self, x: float, y: float, angle: float, bar: BarProperties) -> Load:
        """g(X + p) - g(X), and the gradient's torque."""
        x0, y0 = self.x, self.y
        px, py = x0 + x, y0 + y
        q = ((x0 + px) * x + (y0 + py) * y) / self.r2
        change = expm1(-1.5 * log1p(q))
        r2 = self.r2 * (1.0 + q)
        if r2 < self.alarm2:
            self.check_height(px, py, angle, bar)
        k = self.strength
        spin = self.spin(px, py, r2, angle) if self.gradient else 0.0
        return k * (x + px * change), k * (y + py * change), spin


@final
class AbsoluteLoads(Loads):
    """Gravity relative to the centre of the body: the whole field."""

    def move_to(self, x: float, y: float) -> None:
        """No change: inertial axes stay in place."""

    def load(self, x: float, y: float, angle: float, bar: BarProperties) -> Load:
        """-mu Z/|Z|³, and the gradient's torque."""
        r2 = x * x + y * y
        if r2 < self.alarm2:
            self.check_height(x, y, angle, bar)
        k = -self.mu / (r2 * sqrt(r2))
        return k * x, k * y, self.spin(x, y, r2, angle) if self.gradient else 0.0
