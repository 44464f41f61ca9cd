"""Gravity besides the central point mass: its second moment, the exact bar, oblateness, Moon and Sun.

Each load is an addition to :func:`adapters.exudyn.loads.gravity.orbit_load` or `absolute_load`. All are small relative
to gravity, so that none needs a difference of large numbers.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, final

from adapters.exudyn.loads.gravity import encke
from adapters.exudyn.loads.interface import ExudynLoad, directions_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.frames.axes import ReferenceFrame
    from adapters.exudyn.frames.inertial_view import InertialView
    from adapters.exudyn.frames.numbers import Number
    from adapters.exudyn.loads.interface import BarForce
    from adapters.trajectory import Array
    from scenarios import Gravity, Scene, ThirdBody

    Vector = tuple[Number, Number]


@final
class ExudynQuadrupole(ExudynLoad):
    """Force of a bar's second moment in the central field; its torque is the gradient's."""

    def __init__(self, scene: Scene) -> None:
        self.strength = [1.5 * scene.central_body.mu_m3_s2 * j for j in scene.chain.inertia_kg_m2]

    def load(self, bar: int, view: InertialView, _inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force (3 mu J/2r⁵) (2 p u + Z - 5 (p/r)² Z), with p = u·Z."""
        return *moment_force(self.strength[bar] / fifth_power(view.square_m2, xp), 5.0, view), None


@final
class ExudynSlender(ExudynLoad):
    """Exact gravity on a uniform bar, less that on a point: force and torque in closed form."""

    def __init__(self, scene: Scene) -> None:
        self.mu = scene.central_body.mu_m3_s2
        self.mass = scene.chain.mass_kg
        self.half = [0.5 * length for length in scene.chain.length_m]

    def load(self, bar: int, view: InertialView, _inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force (mu m e/r³) (p b u + q g n) and torque (mu m e/r³) p q/(D E T).

        Here h is half the length, p = u·Z, q = n·Z, e = (h/r)², X = 2 + e - 4 p²/r², D = sqrt(1 + e X),
        E = sqrt((1 + e + D)/2) and T = (1 - e + D)/2 = E² - e. The coefficients B and C of docs/effects/gravity.md are
        B = 1 - 1/(D E) = e b and C = 1 - E/(T D) = e g. The factor e is extracted by hand: b and g are of order 1, no
        small number is a difference, and each expression occurs in few places:

            b = (X + D² (1 + X/(1+D))/2)/(D E (D E + 1)),   g = (T (X/(1+D)/2 - 1/2 + X T) - 1)/(T D (T D + E)).
        """
        h, r2, p = self.half[bar], view.square_m2, view.along_m
        e = (h * h) / r2
        x = 2.0 + e - 4.0 * (p * p) / r2
        d2 = 1.0 + e * x
        d = xp.sqrt(d2)
        square = 0.5 * (1.0 + e + d)
        t = 0.5 * (1.0 - e + d)
        root = xp.sqrt(square)
        half = 0.5 * x / (1.0 + d)
        b = (x + d2 * (0.5 + half)) / (d2 * square + d * root)
        g = (t * (half - 0.5 + x * t) - 1.0) / (d2 * t * t + t * d * root)
        strength = self.mu * self.mass[bar] * e / (r2 * xp.sqrt(r2))
        q = view.across_m
        fx, fy = view.to_frame(p * b, q * g)
        return strength * fx, strength * fy, strength * p * q / (d * root * t)


@final
class ExudynOblateness(ExudynLoad):
    """Oblateness J2 of the central body, in its equatorial plane."""

    def __init__(self, scene: Scene) -> None:
        flat = scene.effects.oblateness
        assert flat is not None
        self.b = 0.5 * scene.central_body.mu_m3_s2 * flat.j2 * flat.radius_m**2
        self.gravity = scene.effects.gravity
        self.mass, self.inertia = scene.chain.mass_kg, scene.chain.inertia_kg_m2

    def load(self, bar: int, view: InertialView, _inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force -3 B m Z/r⁵ + (15 B J/2r⁷) (Z + 2 p u - 7 (p/r)² Z) and torque 15 B J p q/r⁷.

        Here B = mu J2 R²/2, p = u·Z and q = n·Z.
        """
        r5 = fifth_power(view.square_m2, xp)
        pull = -3.0 * self.b * self.mass[bar] / r5
        fx, fy = pull * view.x_m, pull * view.y_m
        if not self.gravity.turns:
            return fx, fy, None
        strength = 15.0 * self.b * self.inertia[bar] / (r5 * view.square_m2)
        if has_second_moment_force(self.gravity):
            gx, gy = moment_force(0.5 * strength, 7.0, view)
            fx, fy = fx + gx, fy + gy
        return fx, fy, strength * view.along_m * view.across_m


@final
class ExudynThirdBody(ExudynLoad):
    """A body on a circle: its gravity on a bar less that on the central body, by Encke's q."""

    time_input_count = 2

    def __init__(self, scene: Scene, body: ThirdBody, frame: ReferenceFrame) -> None:
        self.body, self.frame = body, frame
        self.gravity = scene.effects.gravity
        self.mass, self.inertia = scene.chain.mass_kg, scene.chain.inertia_kg_m2

    def time_inputs(self, at_s: Array, _inside_s: Array) -> Array:
        """Direction to the body in the frame's axes."""
        return directions_of(self.frame, at_s, self.body.longitude_rad + self.body.rate_rad_s * at_s)

    def load(self, bar: int, view: InertialView, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force -(mu_b m/a³) (Z + (Z - X) k), and the load on the bar's second moment.

        Here X is the place of the body, a = |X|, k = (1+q)^(-3/2) - 1 and q = Z·(Z - 2X)/a².
        """
        far = self.body.distance_m
        bx, by = (far * n for n in inputs)
        q = (view.x_m * (view.x_m - 2.0 * bx) + view.y_m * (view.y_m - 2.0 * by)) / far**2
        k, cube = encke(q, xp)
        pull = -self.body.mu_m3_s2 * self.mass[bar] / far**3
        fx, fy = pull * (view.x_m + (view.x_m - bx) * k), pull * (view.y_m + (view.y_m - by) * k)
        if not self.gravity.turns:
            return fx, fy, None
        from_body = relative_to(view, bx, by)
        strength = 3.0 * self.body.mu_m3_s2 * self.inertia[bar] / far**5 / ((1.0 + q) * cube)
        if has_second_moment_force(self.gravity):
            gx, gy = moment_force(0.5 * strength, 5.0, from_body)
            fx, fy = fx + gx, fy + gy
        return fx, fy, strength * from_body.along_m * from_body.across_m


def has_second_moment_force(gravity: Gravity) -> bool:
    """Whether a field exerts a force on a bar's second moment besides a torque."""
    return gravity.turns and gravity.has_potential


def fifth_power(square: Number, xp: Any) -> Number:
    """Fifth power r⁵ from r²."""
    return square * square * xp.sqrt(square)


def moment_force(strength: Number, power: float, view: InertialView) -> Vector:
    """Force `strength` times (2 p u + Z - power (p/r)² Z), with p = u·Z."""
    p = view.along_m
    radial = 1.0 - power * (p * p) / view.square_m2
    return strength * (2.0 * p * view.cosine + radial * view.x_m), strength * (2.0 * p * view.sine + radial * view.y_m)


def relative_to(view: InertialView, x_m: Number, y_m: Number) -> InertialView:
    """View of a bar with its position relative to another point."""
    return dataclasses.replace(view, x_m=view.x_m - x_m, y_m=view.y_m - y_m)
