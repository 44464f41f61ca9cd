"""pymunk behind the engines' contract: impulses and joints of a game physics engine, made second order.

The engine gives no reaction's direction, so reactions are the momentum balance along the chain: what
each bar's velocity gained in the step that is centred on the sample, less gravity there. Rates and the
centre of mass' velocity are the mean of the two half steps around the sample.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from adapters.bar_loads import AbsoluteLoads, LandedError, Loads, MovingLoads
from adapters.engine import (
    Array,
    Coordinates,
    Engine,
    EngineError,
    Knob,
    Ladder,
    Observable,
    Setting,
    Trajectory,
)
from adapters.falling_frame import falling
from adapters.initial_state import InitialState, initial_state
from adapters.pymunk_sweeps import SETTLED_STEPS, sweeps
from adapters.steps import step_s, steps_between_samples
from reference_impl.kinematics import directions
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.pymunk_space import Glimpse
    from scenarios import Scene

MOST_SWEEPS = 1000  # of a step: about 57 equal bars, at a millisecond or two for each step
NOISE_GRAINS = 8.0  # measured: at most 6.3 in reactions (1.4 rms), less in rates, dt 0.005 to 0.3 s

NO_MOTOR = "pymunk's motors hold a rate with a limited impulse, they do not follow a law of angle"


class PymunkEngine(Engine):
    """What both coordinate sets share."""

    order = 2.0
    ladder = Ladder(Knob.STEPS_PER_ORBIT, (500, 1000, 2000, 5000, 10000, 20000, 50000, 100000, 200000), default=10000)
    effects = frozenset({"gravity.none", "gravity.point", "gravity.gradient"})
    observables = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION, Observable.GAP})
    why_not: ClassVar[dict[str, str]] = {
        f"prescribed_rotation.{what}": NO_MOTOR for what in ("inertial", "local_horizontal", "external", "joint")
    }

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Also refuse chains whose joints take the engine too many sweeps to settle."""
        needed = sweeps(scene.chain)
        if needed > MOST_SWEEPS:
            return (
                f"{scene.bars} bars of these masses: pymunk's iterative joints would need {needed} sweeps "
                f"in each step to hold, allowed: {MOST_SWEEPS} "
                "(about 57 equal bars, fewer with light bars between heavy ones)"
            )
        return super().unsupported(scene)

    @abstractmethod
    def frame(self, scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
        """Origin of the coordinates and its velocity at `t_s`, each (n, 2), m and m/s."""

    @abstractmethod
    def loads(self, scene: Scene) -> Loads:
        """Gravity in these coordinates."""

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Tell what the rounding of places does to the joints: it grows as the step shrinks.

        A joint's gap is a difference of places, each rounded by a grain, the spacing of floats at the
        farthest of them. The engine closes it in one step: impulses are off by m grain/dt, reactions
        by m grain/dt², rates by grain/(l dt), each a few times over.
        """
        del t_s
        dt_s = step_s(scene, setting.value)
        grains = NOISE_GRAINS * float(np.spacing(cls.farthest_m(scene)))
        return {
            "reaction": grains * max(scene.chain.mass_kg) / dt_s**2,
            "rate": grains / (min(scene.chain.length_m) * dt_s),
        }

    @staticmethod
    @abstractmethod
    def farthest_m(scene: Scene) -> float:
        """Largest coordinate of a bar in a run."""

    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the space; the frame's track is part of the run and is computed there."""
        from adapters.pymunk_space import ChainSpace

        intervals = scene.run.samples - 1
        self.every = steps_between_samples(scene, setting.value)
        self.dt_s = scene.run.duration_s / (intervals * self.every)
        self.scene, self.start = scene, initial_state(scene)
        origin, drift = self.frame(scene, self.start, np.zeros(1))
        self.chain = ChainSpace(scene.chain, self.start, origin[0], drift[0], self.dt_s)
        self.gravity = self.loads(scene)
        if scene.effects.gravity is not Gravity.NONE:
            self.chain.install(self.gravity)
        self.seen: list[Glimpse] = []
        self.ended = ""

    def simulate(self) -> None:
        """Step from sample to sample."""
        t_s = np.linspace(0.0, self.scene.run.duration_s, (self.scene.run.samples - 1) * self.every + 1)
        self.origin_m, self.drift_m_s = self.frame(self.scene, self.start, t_s)
        chain, gravity, dt, step = self.chain, self.gravity, self.dt_s, 0
        try:
            for step, (x, y) in enumerate(self.origin_m.tolist()):
                gravity.move_to(x, y)
                if step == SETTLED_STEPS:
                    chain.settle()
                if step % self.every:
                    chain.step(dt)
                else:
                    self.seen.append(chain.look(first=step == 0))
            chain.check_joints()
        except LandedError:
            self.ended = f"a bar reached the surface at t = {t_s[step]:.6f} s"
        except (ArithmeticError, ValueError) as error:
            raise EngineError(f"the chain was lost at t = {t_s[step]:.6g} s: {error}") from error

    def read(self) -> Trajectory:
        """Observables at the samples, from what was seen around each."""
        n, dt = len(self.seen), self.dt_s
        place, before, after = (np.array(values) for values in zip(*self.seen, strict=True))
        origin, drift = self.origin_m[:: self.every][:n], self.drift_m_s[:: self.every][:n]
        gain, mean = (after - before) / dt, 0.5 * (before + after)
        gain[0], mean[0] = (
            2.0 * gain[0],
            before[0],
        )  # the first one is half a step, from the initial instant on
        mass = np.array(self.scene.chain.mass_kg)
        share = mass / mass.sum()
        pull = mass[:, None] * (gain[..., :2] - self.field(origin, place))
        return Trajectory(
            self.scene.times_s[:n],
            origin + np.einsum("j,njk->nk", share, place[..., :2]),
            drift + np.einsum("j,njk->nk", share, mean[..., :2]),
            place[..., 2],
            mean[..., 2],
            np.cumsum(pull, axis=1)[:, :-1],
            self.gaps(place),
            ended=self.ended,
            info={
                "steps": n * self.every if self.ended else (n - 1) * self.every,
                "dt_s": dt,
                "sweeps": self.chain.sweeps,
            },
        )

    def field(self, origin_m: Array, place: Array) -> Array:
        """Gravity's acceleration of each bar at the samples, (n, N, 2) m/s², by the loads of the run."""
        found = np.zeros((*place.shape[:2], 2))
        if self.scene.effects.gravity is Gravity.NONE:
            return found
        half = self.chain.half_m
        for i, bars in enumerate(place.tolist()):
            self.gravity.move_to(*origin_m[i].tolist())
            found[i] = [self.gravity.load(x, y, a, h)[:2] for (x, y, a), h in zip(bars, half, strict=True)]
        return found

    def gaps(self, place: Array) -> Array:
        """Distance of the ends that each joint ties, (n, N-1) m."""
        along, _ = directions(place[..., 2])
        reach = np.array(self.chain.half_m)[:, None] * along
        gap = np.diff(place[..., :2], axis=1) - (reach[:, 1:] + reach[:, :-1])
        return np.hypot(gap[..., 0], gap[..., 1])


@final
class Pymunk(PymunkEngine):
    """In a frame that falls freely with the chain's centre of mass at first: exact, by Kepler."""

    title = "pymunk, impulses and joints in a freely falling frame"
    coordinates = Coordinates.MOVING_FRAME

    @staticmethod
    def farthest_m(scene: Scene) -> float:
        """Bars stay within the chain's length of the frame's origin."""
        return scene.size_m

    def frame(self, scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
        """Kepler's orbit of a particle started as the centre of mass is; uniform motion without gravity."""
        return falling(scene, start, t_s)

    def loads(self, scene: Scene) -> Loads:
        """Gravity less that at the origin."""
        return MovingLoads(scene)


@final
class PymunkAbsolute(PymunkEngine):
    """From the centre of the body: joints and gravity out of differences of large numbers."""

    title = "pymunk, impulses and joints in inertial coordinates"
    coordinates = Coordinates.ABSOLUTE

    @staticmethod
    def farthest_m(scene: Scene) -> float:
        """Far apsis of a bound orbit; else what the initial speed, the greatest, can reach."""
        r0, beta2 = scene.radius0_m, scene.orbit.speed_factor**2
        if scene.bound:
            return r0 * max(1.0, beta2 / (2.0 - beta2))
        return r0 + scene.speed0_m_s * scene.run.duration_s

    def frame(self, scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return the centre of the body, at rest."""
        return np.zeros((len(t_s), 2)), np.zeros((len(t_s), 2))

    def loads(self, scene: Scene) -> Loads:
        """Gravity as it is."""
        return AbsoluteLoads(scene)
