r"""All loads on a chain besides its joints, as heyoka expressions; only the effects of a structure are present.

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

from adapters.heyoka.bars import Load, Pair, Symbol, SymbolicBar, cross, dot
from adapters.heyoka.fields import Attractor, Companion, Flattening, companion, distance_ratio

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.heyoka.structure import EndForceShape, Structure

    Parameter = Callable[[str], Any]


@dataclass(frozen=True)
class SymbolicDrag:
    """Drag of the atmosphere about the chain's centre."""

    parameter: Parameter
    centre: Pair
    r2: Symbol

    def wind(self, bar: SymbolicBar) -> Pair:
        """Velocity W of the bar's centre relative to the air."""
        turn = self.parameter("drag_turn")
        return bar.velocity[0] + turn * bar.position[1], bar.velocity[1] - turn * bar.position[0]

    def facing(self, bar: SymbolicBar) -> Symbol:
        """Normal component v; its sign is the exposed face."""
        return dot(bar.normal, self.wind(bar))

    def load(self, bar: SymbolicBar) -> Load:
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
        (ux, uy), (nx, ny) = bar.along, bar.normal
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

    def facing(self, bar: SymbolicBar) -> Symbol:
        """Normal component n·s; its sign is the exposed face."""
        return dot(bar.normal, self.sun)

    def load(self, bar: SymbolicBar) -> Load:
        """Load on one bar."""
        p, j, (sx, sy), (nx, ny) = self.parameter, bar.index, self.sun, bar.normal
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


def thrust_load(shape: EndForceShape, parameter: Parameter, k: int, bar: SymbolicBar, angle: Symbol) -> Load:
    """Load of thrust k, its force linear in time."""
    size = size_in_time(parameter, f"thrust_{k}", sloped=shape.sloped)
    force = end_force(shape, parameter(f"thrust_{k}_direction"), size, angle)
    return bar.pushed(force, cross(bar.arm(shape.side), force))


def size_in_time(parameter: Parameter, name: str, *, sloped: bool = True) -> Symbol:
    """Size on the present segment of a table in time."""
    import heyoka as hy

    size = parameter(f"{name}_size")
    return size + parameter(f"{name}_slope") * (hy.time - parameter(f"{name}_since")) if sloped else size


def joint_torques(structure: Structure, angle: list[Symbol], rate: list[Symbol]) -> list[Symbol]:
    """Torque of the joint springs, dampers and motors on each bar."""
    torque: list[Symbol] = [0.0] * len(angle)
    parameter = structure.parameter
    for k, j in enumerate(structure.motors):
        motor = size_in_time(parameter, f"motor_{k}")
        torque[j] = torque[j] - motor
        torque[j + 1] = torque[j + 1] + motor
    for j in range(len(angle) - 1 if structure.springs else 0):
        bend = angle[j + 1] - angle[j] - parameter(f"spring_rest_{j}")
        bending = rate[j + 1] - rate[j]
        straightening = -parameter(f"spring_stiffness_{j}") * bend - parameter(f"spring_damping_{j}") * bending
        torque[j] = torque[j] - straightening
        torque[j + 1] = torque[j + 1] + straightening
    return torque


@dataclass(frozen=True)
class SymbolicState:
    """State variables of the chain as heyoka expressions."""

    centre: Pair
    velocity: Pair
    angle: list[Symbol]
    rate: list[Symbol]
    r2: Symbol

    @property
    def variables(self) -> list[Symbol]:
        """All variables in the order of the state."""
        return [*self.centre, *self.velocity, *self.angle, *self.rate]


class SymbolicLoads:
    """Loads on the bars of a structure besides their joints."""

    def __init__(self, structure: Structure, state: SymbolicState) -> None:
        """Expressions that all bars share."""
        import heyoka as hy

        self.structure, self.state, self.parameter = structure, state, structure.parameter
        r2 = state.r2
        self.pull: Symbol = self.parameter("mu") / (r2 * hy.sqrt(r2)) if structure.gravity != "none" else 0.0
        self.attractor = Attractor(state.centre, r2, self.pull, structure.gravity)
        self.companions = [self.companion(k) for k in range(structure.third_bodies)]
        self.flattening = self.oblateness() if structure.oblate else None
        self.air = SymbolicDrag(self.parameter, state.centre, r2) if structure.drag else None
        self.light = SymbolicSunlight(self.parameter, structure.shadow) if structure.light else None
        driven = structure.springs or structure.motors
        self.joints = joint_torques(structure, state.angle, state.rate) if driven else None
        self.seen: list[SymbolicBar] = []

    def oblateness(self) -> Flattening:
        """Oblateness, J2."""
        r2 = self.state.r2
        return Flattening(self.state.centre, r2, self.parameter("oblateness") * r2**-2.5, self.structure.gravity)

    def companion(self, k: int) -> Companion:
        """Third body k on its circle."""
        import heyoka as hy

        pull, distance, longitude, rate = (
            self.parameter(f"body_{k}_{x}") for x in ("pull", "distance", "longitude", "rate")
        )
        at = longitude + rate * hy.time
        position = distance * hy.cos(at), distance * hy.sin(at)
        return companion(self.state.centre, position, distance * distance, pull, self.structure.gravity)

    @property
    def frame(self) -> list[Symbol]:
        """Acceleration of the frame that falls with the centre of mass."""
        found = [-self.pull * x for x in self.state.centre]
        frames = [self.flattening.frame] if self.flattening else []
        for frame in frames + [c.frame for c in self.companions]:
            found = [f + x for f, x in zip(found, frame, strict=True)]
        return found

    def load(self, bar: SymbolicBar) -> Load:
        """Sum of the loads on one bar."""
        found = Load() if self.structure.gravity == "none" else self.attractor.load(bar)
        for more in self.others(bar):
            found = found + more
        self.seen.append(bar)
        return found

    def others(self, bar: SymbolicBar) -> list[Load]:
        """Loads besides the central body's main field."""
        fields = [*self.companions, *(x for x in (self.flattening, self.air, self.light) if x)]
        found = [x.load(bar) for x in fields]
        if self.joints:
            found.append(Load((0.0, 0.0), self.joints[bar.index]))
        angle = self.state.angle[bar.index]
        found += [
            thrust_load(shape, self.parameter, k, bar, angle)
            for k, shape in enumerate(self.structure.thrusts)
            if shape.bar == bar.index
        ]
        return found

    @property
    def event_functions(self) -> tuple[list[Symbol], Symbol]:
        """Event functions of the modes, and Z0·s."""
        import heyoka as hy

        found = [x.facing(bar) for x in (self.air, self.light) if x for bar in self.seen]
        if not (self.light and self.light.shadow):
            return found, hy.expression(0.0)
        sun, centre = self.light.sun, self.state.centre
        return [*found, self.light.edge(centre, self.parameter("surface"))], centre[0] * sun[0] + centre[1] * sun[1]
