"""All loads on a chain besides its joints, as heyoka expressions; only the effects of a structure are present."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.heyoka.applied_forces import BarKinematics, SymbolicDrag, SymbolicSunlight, spring_torques, thrust_load
from adapters.heyoka.fields import Attractor, Companion, Flattening, Load, Pair, Rod, Symbol, companion

if TYPE_CHECKING:
    from adapters.heyoka.structure import Structure


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

        self.structure, self.state, effects = structure, state, structure.effects
        r2 = state.r2
        self.pull: Symbol = hy.par[0] / (r2 * hy.sqrt(r2)) if structure.gravity != "none" else 0.0
        self.attractor = Attractor(state.centre, r2, self.pull, structure.gravity)
        self.companions = [self.companion(k) for k in range(effects.third_bodies)]
        self.flattening = self.oblateness() if effects.oblate else None
        self.air = SymbolicDrag(self.parameter, state.centre, r2) if effects.drag else None
        self.light = SymbolicSunlight(self.parameter, effects.shadow) if effects.light else None
        self.springs = spring_torques(self.parameter, state.angle, state.rate) if effects.springs else None
        self.seen: list[BarKinematics] = []

    def parameter(self, name: str) -> Symbol:
        """Parameter of an effect."""
        import heyoka as hy

        return hy.par[self.structure.slot(name)]

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

    def load(self, rod: Rod, bar: BarKinematics) -> Load:
        """Sum of the loads on one bar."""
        found = Load((0.0, 0.0)) if self.structure.gravity == "none" else self.attractor.load(rod)
        for more in self.others(rod, bar):
            found = found + more
        self.seen.append(bar)
        return found

    def others(self, rod: Rod, bar: BarKinematics) -> list[Load]:
        """Loads besides the central body's main field."""
        found = [c.load(rod, bar.position) for c in self.companions]
        found += [x.load(rod) for x in [self.flattening] if x]
        found += [x.load(bar) for x in (self.air, self.light) if x]
        if self.springs:
            found.append(Load((0.0, 0.0), self.springs[bar.index]))
        angle = self.state.angle[bar.index]
        found += [
            thrust_load(shape, self.parameter, k, bar, angle)
            for k, shape in enumerate(self.structure.effects.thrusts)
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
        return [*found, self.light.edge(centre, hy.par[1])], centre[0] * sun[0] + centre[1] * sun[1]
