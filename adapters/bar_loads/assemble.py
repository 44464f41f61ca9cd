"""All loads on a chain in plain floats, assembled from the effects of its scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.bar_loads.fields import InversePowerField
from adapters.bar_loads.interface import FaceDependentLoad, bars_of
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarLoad, BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import Scene

SUPPORTED = frozenset({
    *(f"gravity.{gravity}" for gravity in Gravity), "oblateness", "third_body", "drag", "solar_pressure",
    "joint_spring_damper", "thrust.body", "thrust.inertial", "impulse",
})  # fmt: skip
"""Names of the effects that these loads support"""


class ChainLoads:
    """Gravity of the central body, and every other effect of a scene."""

    def __init__(self, scene: Scene, gravity: Loads, effects: tuple[BarLoad, ...]) -> None:
        """Sum of `gravity` and `effects`."""
        self.pulls = scene.effects.gravity is not Gravity.NONE
        self.gravity, self.effects = gravity, effects
        self.halves = [0.5 * length for length in scene.chain.length_m]
        self.of_rates = any(effect.of_rates for effect in effects)
        self.faced = [effect for effect in effects if isinstance(effect, FaceDependentLoad)]

    def __call__(
        self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate] = ()
    ) -> list[Load]:
        """Load of each bar; `rates` may be omitted unless `of_rates`.

        Raises
        ------
        LandedError
            If a bar touches the surface.
        """
        parts = [effect(frame, positions, rates) for effect in self.effects]
        if self.pulls:
            self.gravity.move_to(frame.x, frame.y)
            load = self.gravity.load
            parts.append([load(x, y, a, half) for (x, y, a), half in zip(positions, self.halves, strict=True)])
        if not parts:
            return [(0.0, 0.0, 0.0)] * len(self.halves)
        return [
            (sum(ax for ax, _, _ in loads), sum(ay for _, ay, _ in loads), sum(spin for _, _, spin in loads))
            for loads in zip(*parts, strict=True)
        ]


def chain_loads(scene: Scene, gravity: Loads, *, free_falling: bool) -> ChainLoads | None:
    """Loads on the chain of `scene`, or None where `gravity` is the only one (or there is none).

    Parameters
    ----------
    scene : Scene
    gravity : Loads
        In the frame of the coordinates.
    free_falling : bool
        Whether the frame falls with all fields; otherwise it is at rest at the centre of the body.
    """
    effects = tuple(effects_of(scene, bars_of(scene.chain), free_falling=free_falling))
    return ChainLoads(scene, gravity, effects) if effects else None


def effects_of(scene: Scene, bars: list[BarProperties], *, free_falling: bool) -> Iterator[BarLoad]:
    """Effects besides the central body's pull on points and its gradient."""
    called, mu = scene.effects, scene.central_body.mu_m3_s2
    spread = called.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER)
    if spread:
        from adapters.bar_loads.bar_gravity_corrections import SecondMomentLoad, SlenderLoad

        slender = called.gravity is Gravity.SLENDER
        yield SlenderLoad(bars, mu) if slender else SecondMomentLoad(bars, InversePowerField(mu, 3))
    if called.oblateness:
        from adapters.bar_loads.fields import AbsoluteOblatenessLoad, OblatenessLoad, oblateness_field

        j2 = OblatenessLoad if free_falling else AbsoluteOblatenessLoad
        yield j2(bars, oblateness_field(mu, called.oblateness), called.gravity.turns, spread)
    if called.third_body:
        from adapters.bar_loads.tides import ThirdBodyLoad

        for body in called.third_body:
            yield ThirdBodyLoad(bars, InversePowerField(body.mu_m3_s2, 3), called.gravity.turns, spread, body)
    yield from nongravitational_loads(scene, bars)


def nongravitational_loads(scene: Scene, bars: list[BarProperties]) -> Iterator[BarLoad]:
    """Effects other than gravity; they are the same in every frame."""
    called = scene.effects
    if called.drag:
        from adapters.bar_loads.drag import DragLoad

        yield DragLoad(bars, called.drag, scene.central_body.radius_m)
    if called.solar_pressure:
        from adapters.bar_loads.sunlight import SunlightLoad

        yield SunlightLoad(bars, called.solar_pressure)
    if called.joint_spring_damper:
        from adapters.bar_loads.springs import DampedSpringLoad, SpringLoad

        damped = any(called.joint_spring_damper.damping_N_m_s_rad)
        yield (DampedSpringLoad if damped else SpringLoad)(bars, called.joint_spring_damper)
    if called.thrust:
        from adapters.bar_loads.thrusts import ThrustLoad

        yield ThrustLoad(bars, called.thrust)
