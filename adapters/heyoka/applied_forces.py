r"""Nongravitational forces on bars in heyoka's equations: drag, light, thrusts, and joint springs.

Discrete modes are parameters, constant over a segment: the face of a bar exposed to the wind, the face exposed to the
Sun, and light or shadow. An event function for each passes zero where the mode changes, and stops the integrator.

*Drag.* The force per length at a point s along the bar is -(b/2) rho (1 - kappa s) sigma (v + s w) times
C_n (v + s w) n + C_t t u, with sigma the sign of v. With A, B, C the integrals of b/2 times 1, s² and s⁴ over the bar,

    force  -rho sigma (C_n (A v² + B w (w - 2 kappa v)) n + C_t t (A v - B kappa w) u)
    torque -rho sigma C_n (B v (2 w - kappa v) - C kappa w²)

rho is the density at the chain's centre times exp(-(r - r0)/H), with r - r0 = r0 q/(1 + sqrt(1 + q)), see
:mod:`adapters.heyoka.fields`.

*Light.* With g = n·s and sigma its sign, the force is -P b l sigma g ((1 - rho) s + 2 rho g n).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from adapters.heyoka.fields import Load, Pair, Symbol, cross, distance_ratio

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.heyoka.effects import EndForceShape

    Parameter = Callable[[str], Any]


@dataclass(frozen=True)
class BarKinematics:
    """Position, velocity and mass of a bar, for drag, light and thrusts."""

    index: int
    mass: Symbol
    along: Pair
    """u"""
    offset: Pair
    position: Pair
    velocity: Pair
    reach: Pair
    rate: Symbol

    @property
    def across(self) -> Pair:
        """Unit vector n."""
        return -self.along[1], self.along[0]

    def pushed(self, force: Pair, torque: Symbol = 0.0) -> Load:
        """Load of a force at its centre."""
        push = force[0] / self.mass, force[1] / self.mass
        return Load(push, torque, cross(self.position, push))


def dot(a: Pair, b: Pair) -> Symbol:
    """Dot product."""
    return a[0] * b[0] + a[1] * b[1]


@dataclass(frozen=True)
class SymbolicDrag:
    """Drag of the atmosphere about the chain's centre."""

    parameter: Parameter
    centre: Pair
    r2: Symbol

    def wind(self, bar: BarKinematics) -> Pair:
        """Velocity W of the bar's centre relative to the air."""
        turn = self.parameter("drag_turn")
        return bar.velocity[0] + turn * bar.position[1], bar.velocity[1] - turn * bar.position[0]

    def facing(self, bar: BarKinematics) -> Symbol:
        """Normal component v; its sign is the exposed face."""
        return dot(bar.across, self.wind(bar))

    def load(self, bar: BarKinematics) -> Load:
        """Load on one bar."""
        import heyoka as hy

        p, j = self.parameter, bar.index
        area, second, fourth = (p(f"drag_{x}_{j}") for x in ("area", "second", "fourth"))
        near, radius = distance_ratio(self.centre, self.r2, bar.offset), hy.sqrt(self.r2)
        higher = radius * near.q * near.y / (1.0 + near.y)
        at_centre = p("drag_density") * hy.exp((p("drag_radius") - radius) / p("drag_height"))
        strength = p(f"drag_face_{j}") * at_centre * hy.exp(-higher / p("drag_height"))
        kappa = dot(bar.along, bar.position) * near.y / (radius * p("drag_height"))
        v, t, w = self.facing(bar), dot(bar.along, self.wind(bar)), bar.rate - p("drag_turn")
        normal = -strength * p("drag_normal")
        over = normal * (area * v * v + second * w * (w - 2.0 * kappa * v))
        down = -strength * p("drag_tangential") * t * (area * v - second * kappa * w)
        torque = normal * (second * v * (2.0 * w - kappa * v) - fourth * kappa * w * w)
        (ux, uy), (nx, ny) = bar.along, bar.across
        return bar.pushed((over * nx + down * ux, over * ny + down * uy), torque)


@dataclass(frozen=True)
class SymbolicSunlight:
    """Light of a distant Sun."""

    parameter: Parameter
    shadow: bool

    @property
    def sun(self) -> Pair:
        """Unit vector s."""
        import heyoka as hy

        at = self.parameter("light_longitude") + self.parameter("light_rate") * hy.time
        return hy.cos(at), hy.sin(at)

    def facing(self, bar: BarKinematics) -> Symbol:
        """Normal component n·s; its sign is the exposed face."""
        return dot(bar.across, self.sun)

    def load(self, bar: BarKinematics) -> Load:
        """Load on one bar."""
        p, j, (sx, sy), (nx, ny) = self.parameter, bar.index, self.sun, bar.across
        g = self.facing(bar)
        strength = -p(f"light_area_{j}") * p(f"light_face_{j}") * g
        if self.shadow:
            strength = strength * p("lit")
        black, mirror = p("light_absorbed"), p("light_mirrored") * g
        return bar.pushed((strength * (black * sx + mirror * nx), strength * (black * sy + mirror * ny)))

    def edge(self, centre: Pair, radius: Symbol) -> Symbol:
        """Squared distance from the shadow's axis less that of its wall; negative in the shadow."""
        aside = cross(centre, self.sun)
        return aside * aside - radius * radius


def end_force(shape: EndForceShape, direction: Symbol, size: Symbol, angle: Symbol) -> Pair:
    """Force or impulse on a bar's end."""
    import heyoka as hy

    at = angle + direction if shape.body else direction
    return size * hy.cos(at), size * hy.sin(at)


def thrust_load(shape: EndForceShape, parameter: Parameter, k: int, bar: BarKinematics, angle: Symbol) -> Load:
    """Load of thrust k, its force linear in time."""
    import heyoka as hy

    size = parameter(f"thrust_{k}_size")
    if shape.sloped:
        size = size + parameter(f"thrust_{k}_slope") * (hy.time - parameter(f"thrust_{k}_since"))
    force = end_force(shape, parameter(f"thrust_{k}_direction"), size, angle)
    return bar.pushed(force, shape.side * cross(bar.reach, force))


def spring_torques(parameter: Parameter, angle: list[Symbol], rate: list[Symbol]) -> list[Symbol]:
    """Torque of the joint springs and dampers on each bar."""
    torque: list[Symbol] = [0.0] * len(angle)
    for j in range(len(angle) - 1):
        bend = angle[j + 1] - angle[j] - parameter(f"spring_rest_{j}")
        bending = rate[j + 1] - rate[j]
        straightening = -parameter(f"spring_stiffness_{j}") * bend - parameter(f"spring_damping_{j}") * bending
        torque[j] = torque[j] - straightening
        torque[j + 1] = torque[j + 1] + straightening
    return torque
