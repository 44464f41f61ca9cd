"""pymunk adapter: impulses and joints of a game physics engine, made second order.

pymunk gives no direction of a reaction. Reactions are therefore the momentum balance along the chain: each bar's change
of velocity in the step centred on the sample, less the loads there. Rates and the centre of mass' velocity are the mean
of the half steps before and after the sample.
"""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from adapters.bar_loads.assemble import SUPPORTED, chain_loads
from adapters.bar_loads.falling_frame import free_fall, orbit_noise
from adapters.bar_loads.gravity import AbsoluteLoads, LandedError, Loads, MovingLoads
from adapters.bar_loads.interface import FrameState
from adapters.common.equal_steps import step_s, steps_between_samples
from adapters.common.initial_state import InitialState, initial_state
from adapters.common.landing import landing_text
from adapters.common.step_alignment import NO_SHADOW, events_by_step, misalignment
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, EngineError, Setting
from adapters.pymunk.iteration_count import MOST_SWEEPS, SETTLED_STEPS, step_sweeps, sweeps
from adapters.trajectory import Array, Observable, Trajectory
from reference_impl.model.kinematics import directions
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.pymunk.samples import StaggeredSample
    from adapters.pymunk.step_loads import StepLoads
    from scenarios import Scene

NOISE_GRAINS = 8.0  # measured: at most 6.3 in reactions (1.4 rms), less in rates, dt 0.005 to 0.3 s

NO_PRESCRIBED_ROTATION = (
    "prescribed rotation is not supported: pymunk's motors hold a rate with a limited impulse "
    "and do not follow a law of the angle"
)


class PymunkEngine(Engine):
    """Common part of both coordinate sets."""

    order = 2.0
    sweep = AccuracySweep(
        AccuracyParameter.STEPS_PER_ORBIT, (500, 1000, 2000, 5000, 10000, 20000, 50000, 100000, 200000), default=10000
    )
    effects = SUPPORTED
    observables = frozenset(Observable) - {Observable.COM_RESIDUAL, Observable.TORQUE}
    unsupported_reasons: ClassVar[dict[str, str]] = {
        f"prescribed_rotation.{what}": NO_PRESCRIBED_ROTATION
        for what in ("inertial", "local_horizontal", "external", "joint")
    } | {"solar_pressure.shadow": NO_SHADOW}

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why the engine does not support `scene`: events within a step and chains of many bars included."""
        needed = sweeps(scene.chain)
        if needed > MOST_SWEEPS:
            return (
                f"{scene.bars} bars of these masses are not supported: pymunk's iterative joints would need {needed} "
                f"sweeps in each step; allowed: {MOST_SWEEPS} "
                "(about 57 equal bars, fewer with light bars between heavy ones)"
            )
        return super().unsupported(scene) or misalignment(scene)

    @abstractmethod
    def frame(self, scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
        """Origin of the coordinates and its velocity at `t_s`, each (n, 2), m and m/s."""

    @abstractmethod
    def loads(self, scene: Scene) -> Loads:
        """Gravity in these coordinates."""

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Effect of the positions' rounding on the joints, which grows as the step shrinks.

        A joint's gap is a difference of positions, each rounded to the spacing of floats at the largest of them. pymunk
        closes the gap in one step. Impulses are then wrong by m spacing/dt, reactions by m spacing/dt², rates by
        spacing/(l dt), each a few times over.
        """
        dt_s = step_s(scene, setting.value)
        grains = NOISE_GRAINS * float(np.spacing(cls.farthest_m(scene)))
        return {
            "reaction": grains * max(scene.chain.mass_kg) / dt_s**2,
            "rate": grains / (min(scene.chain.length_m) * dt_s),
        } | (orbit_noise(scene, t_s) if cls.coordinates is Coordinates.MOVING_FRAME else {})

    @staticmethod
    @abstractmethod
    def farthest_m(scene: Scene) -> float:
        """Largest coordinate of a bar in a run."""

    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the space; the frame's orbit belongs to the timed run."""
        from adapters.pymunk.space import ChainSpace

        intervals = scene.run.samples - 1
        self.every = steps_between_samples(scene, setting.value)
        self.dt_s = scene.run.duration_s / (intervals * self.every)
        self.scene, self.start = scene, initial_state(scene)
        origin, drift = self.frame(scene, self.start, np.zeros(1))
        needed = step_sweeps(scene, self.dt_s)
        self.chain = ChainSpace(scene.chain, self.start, origin[0], drift[0], self.dt_s, needed)
        self.gravity = self.loads(scene)
        self.prepare_effects()
        self.install()
        self.seen: list[StaggeredSample] = []
        self.ended = ""

    def prepare_effects(self) -> None:
        """Prepare loads besides gravity, and events.

        Raises
        ------
        EngineError
            If a sample would coincide with the step after an event, whose reactions are of first order: see
            :mod:`adapters.pymunk.space`.
        """
        scene, self.restarted_at = self.scene, 0
        self.effect_loads: StepLoads | None = None
        if effect_loads := chain_loads(scene, self.gravity, free_falling=self.coordinates is Coordinates.MOVING_FRAME):
            from adapters.pymunk.step_loads import StepLoads

            self.effect_loads = StepLoads(effect_loads)
        self.jumps = events_by_step(scene, self.dt_s)
        if any((step + 1) % self.every == 0 for step in self.jumps):
            raise EngineError(
                "a sample is one step after an event; at least two steps are required: request twice the steps"
            )
        self.impulse_N_s: Array = np.zeros((scene.bars - 1, 2))
        self.impulses: list[Array] = []

    def install(self) -> None:
        """Install the loads on the chain."""
        if self.effect_loads:
            self.effect_loads.begin()
            self.chain.install_loads(self.effect_loads)
        elif self.scene.effects.gravity is not Gravity.NONE:
            self.chain.install(self.gravity)

    def simulate(self) -> None:
        """Step from sample to sample."""
        t_s = np.linspace(0.0, self.scene.run.duration_s, self.last_step + 1)
        self.origin_m, self.drift_m_s = self.frame(self.scene, self.start, t_s)
        self.track = (np.hstack([self.origin_m, self.drift_m_s]) if self.effect_loads else self.origin_m).tolist()
        step = 0
        try:
            if 0 in self.jumps:
                self.restart(0, self.frame_start())
            for step in range(self.last_step + 1):
                self.move_frame(step, before=step > 0)
                if step == self.restarted_at + SETTLED_STEPS:
                    self.chain.settle()
                if step % self.every and step not in self.jumps:
                    self.chain.step(self.dt_s)
                else:
                    self.take_sample(step)
            self.chain.check_joints()
        except LandedError:
            self.ended = landing_text(float(t_s[step]))
        except (ArithmeticError, ValueError) as error:
            raise EngineError(f"pymunk: the run failed at t = {t_s[step]:.6g} s: {error}") from error

    @property
    def last_step(self) -> int:
        """Number of steps."""
        return self.every * (self.scene.run.samples - 1)

    def move_frame(self, step: int, *, before: bool) -> None:
        """Move the frame to the end of `step`, before or after an event there."""
        if self.effect_loads is None:
            self.gravity.move_to(*self.track[step])
        else:
            self.effect_loads.move_to(self.frame_state(step, before=before))

    def frame_state(self, step: int, *, before: bool) -> FrameState:
        """State of the frame at the end of `step`."""
        t_s = step * self.dt_s
        x, y, vx, vy = self.track[step]
        return FrameState(x, y, vx, vy, t_s, t_s + (-0.5 if before else 0.5) * self.dt_s)

    def take_sample(self, step: int) -> None:
        """Step across a sample or an event, and restart after an event."""
        staggered = self.chain.take_sample(first=step == 0)
        if step % self.every == 0:
            self.seen.append(staggered)
            self.impulses.append(self.impulse_N_s)
        if step and step in self.jumps:
            from adapters.pymunk.effects import synchronised

            self.restart(step, synchronised(self.scene, staggered))
            self.move_frame(step, before=False)
            self.chain.half_step()

    def frame_start(self) -> InitialState:
        """Initial state in the space's own axes."""
        start = self.start
        com, drift = start.com_m - self.origin_m[0], start.com_velocity_m_s - self.drift_m_s[0]
        return dataclasses.replace(start, com_m=com, com_velocity_m_s=drift)

    def restart(self, step: int, state: InitialState) -> None:
        """Restart from `state`, in the space's own axes, after the impulses at the end of `step`."""
        from adapters.pymunk.effects import restart_state

        found = restart_state(self.scene, state, self.jumps[step], self.dt_s)
        self.chain, self.restarted_at = found.chain, step
        self.impulse_N_s = self.impulse_N_s + found.impulse_N_s
        self.install()

    def read(self) -> Trajectory:
        """Observables at the samples, from the half steps around each."""
        n, dt = len(self.seen), self.dt_s
        position, before, after = (np.array(values) for values in zip(*self.seen, strict=True))
        origin, drift = self.origin_m[:: self.every][:n], self.drift_m_s[:: self.every][:n]
        gain, mean = (after - before) / dt, 0.5 * (before + after)
        gain[0], mean[0] = (
            2.0 * gain[0],
            before[0],
        )  # the first one is half a step, from the initial instant on
        mass = np.array(self.scene.chain.mass_kg)
        share = mass / mass.sum()
        pull = mass[:, None] * (gain[..., :2] - self.field(origin, position, mean))
        com = np.einsum("j,njk->nk", share, position[..., :2])
        return Trajectory(
            self.scene.times_s[:n],
            origin + com,
            drift + np.einsum("j,njk->nk", share, mean[..., :2]),
            position[..., 2],
            mean[..., 2],
            np.cumsum(pull, axis=1)[:, :-1],
            self.gaps(position),
            position_m=position[..., :2] - com[:, None],
            impulse_N_s=np.array(self.impulses)[:n] if self.scene.effects.impulse else None,
            ended=self.ended,
            info={
                "steps": n * self.every if self.ended else (n - 1) * self.every,
                "dt_s": dt,
                "sweeps": self.chain.sweeps,
            },
        )

    def field(self, origin_m: Array, position: Array, rate: Array) -> Array:
        """Acceleration of each bar by the loads of the run at the samples, (n, N, 2) m/s²."""
        found = np.zeros((*position.shape[:2], 2))
        if self.effect_loads:
            for i, (bars, rates) in enumerate(zip(position.tolist(), rate.tolist(), strict=True)):
                frame_state = self.frame_state(i * self.every, before=i > 0)
                found[i] = [load[:2] for load in self.effect_loads.effect_loads(frame_state, bars, rates)]
            return found
        if self.scene.effects.gravity is Gravity.NONE:
            return found
        half = self.chain.half_m
        for i, bars in enumerate(position.tolist()):
            self.gravity.move_to(*origin_m[i].tolist())
            found[i] = [self.gravity.load(x, y, a, h)[:2] for (x, y, a), h in zip(bars, half, strict=True)]
        return found

    def gaps(self, position: Array) -> Array:
        """Distance between the bar ends at each joint, (n, N-1) m."""
        along, _ = directions(position[..., 2])
        reach = np.array(self.chain.half_m)[:, None] * along
        gap = np.diff(position[..., :2], axis=1) - (reach[:, 1:] + reach[:, :-1])
        return np.hypot(gap[..., 0], gap[..., 1])


@final
class Pymunk(PymunkEngine):
    """In a frame that falls freely with the chain's centre of mass at first."""

    title = "pymunk, impulses and joints in a freely falling frame"
    coordinates = Coordinates.MOVING_FRAME

    @staticmethod
    def farthest_m(scene: Scene) -> float:
        """Bars stay within the chain's length of the frame's origin, plus the drift by nongravitational forces."""
        if not scene.effects.beyond_basic:
            return scene.size_m
        from adapters.bar_loads.drift_bound import drift_bound_m

        return scene.size_m + drift_bound_m(scene)

    def frame(self, scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
        """Orbit of a particle started as the centre of mass is; uniform motion without gravity."""
        return free_fall(scene, start, t_s)

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
        """Apoapsis of a bound orbit; else the distance at the initial, greatest speed."""
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
