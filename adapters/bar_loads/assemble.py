"""Everything that acts on a chain, in plain floats: composed of what its scene calls for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.bar_loads.fields import Central
from adapters.bar_loads.interface import Faced, bars_of
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import Bar, Effect, Here, Load, Place, Rate
    from scenarios import Scene

CARRIED = frozenset({
    *(f"gravity.{gravity}" for gravity in Gravity), "oblateness", "third_body", "drag", "solar_pressure",
    "joint_spring_damper", "thrust.body", "thrust.inertial", "impulse",
})  # fmt: skip
"""Names of the effects that are here"""


class ChainLoads:
    """Gravity of the central body, and every other effect that a scene calls for."""

    def __init__(self, scene: Scene, gravity: Loads, effects: tuple[Effect, ...]) -> None:
        """Sum of `gravity` and `effects`."""
        self.pulls = scene.effects.gravity is not Gravity.NONE
        self.gravity, self.effects = gravity, effects
        self.halves = [0.5 * length for length in scene.chain.length_m]
        self.of_rates = any(effect.of_rates for effect in effects)
        self.faced = [effect for effect in effects if isinstance(effect, Faced)]

    def __call__(self, here: Here, places: Sequence[Place], rates: Sequence[Rate] = ()) -> list[Load]:
        """Load of each bar; `rates` may be left out unless `of_rates`.

        Raises
        ------
        LandedError
            If a bar touches the surface.
        """
        parts = [effect(here, places, rates) for effect in self.effects]
        if self.pulls:
            self.gravity.move_to(here.x, here.y)
            load = self.gravity.load
            parts.append([load(x, y, a, half) for (x, y, a), half in zip(places, self.halves, strict=True)])
        return [
            (sum(ax for ax, _, _ in loads), sum(ay for _, ay, _ in loads), sum(spin for _, _, spin in loads))
            for loads in zip(*parts, strict=True)
        ]


def chain_loads(scene: Scene, gravity: Loads, *, falls: bool) -> ChainLoads | None:
    """What acts on `scene`'s chain, or None where that is `gravity` alone (or nothing).

    Parameters
    ----------
    scene : Scene
    gravity : Loads
        In the frame that is meant.
    falls : bool
        Whether the frame falls with all fields; if not, it is at rest at the centre of the body.
    """
    effects = tuple(effects_of(scene, bars_of(scene.chain), falls=falls))
    return ChainLoads(scene, gravity, effects) if effects else None


def effects_of(scene: Scene, bars: list[Bar], *, falls: bool) -> Iterator[Effect]:
    """Effects besides the central body's pull on points, and its gradient."""
    called, mu = scene.effects, scene.central_body.mu_m3_s2
    spread = called.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER)
    if spread:
        from adapters.bar_loads.second_moment import SecondMoment, Slender

        slender = called.gravity is Gravity.SLENDER
        yield Slender(bars, mu) if slender else SecondMoment(bars, Central(mu, 3))
    if called.oblateness:
        from adapters.bar_loads.fields import Flattened, FlattenedWhole, flattening

        j2 = Flattened if falls else FlattenedWhole
        yield j2(bars, flattening(mu, called.oblateness), called.gravity.turns, spread)
    if called.third_body:
        from adapters.bar_loads.tides import Tide

        for body in called.third_body:
            yield Tide(bars, Central(body.mu_m3_s2, 3), called.gravity.turns, spread, body)
    yield from contacts(scene, bars)


def contacts(scene: Scene, bars: list[Bar]) -> Iterator[Effect]:
    """Effects that no field exerts, the same in every frame."""
    called = scene.effects
    if called.drag:
        from adapters.bar_loads.drag import Air

        yield Air(bars, called.drag, scene.central_body.radius_m)
    if called.solar_pressure:
        from adapters.bar_loads.sunlight import Sunlight

        yield Sunlight(bars, called.solar_pressure)
    if called.joint_spring_damper:
        from adapters.bar_loads.springs import DampedSprings, Springs

        damped = any(called.joint_spring_damper.damping_N_m_s_rad)
        yield (DampedSprings if damped else Springs)(bars, called.joint_spring_damper)
    if called.thrust:
        from adapters.bar_loads.thrusts import Push

        yield Push(bars, called.thrust)
