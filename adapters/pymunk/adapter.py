"""pymunk adapter: impulses and joints of a game physics engine, made second order.

pymunk gives no direction of a reaction. Reactions are therefore the momentum balance along the chain: each bar's change
of velocity in the step centred on the sample, less the loads there. Rates and the centre of mass' velocity are the mean
of the half steps before and after the sample.

The chain restarts after each event, as at t = 0, from the angles, their rates and the centre of mass just before the
event. Impulses change these states under closed joints.
"""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from adapters.bar_loads.chain_loads import SUPPORTED, ChainLoads
from adapters.bar_loads.falling_frame import free_fall, orbit_noise
from adapters.bar_loads.forces import impulse_jumps
from adapters.bar_loads.gravity import AbsoluteLoads, LandedError, Loads, MovingLoads
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.common.departure import drift_bound_m
from adapters.common.equal_steps import step_s, steps_between_samples
from adapters.common.initial_state import InitialState, initial_state
from adapters.common.landing import landing_text
from adapters.common.reference_model import chain_model
from adapters.common.step_alignment import NO_SHADOW, events_by_step, misalignment
from adapters.engine import (
    PRESCRIBED_ROTATIONS,
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    EngineError,
    Setting,
)
from adapters.pymunk.iteration_count import MOST_SWEEPS, SETTLED_STEPS, step_sweeps, sweeps
from adapters.trajectory import Array, Observable, Trajectory
from reference_impl.model.kinematics import directions, relative_positions, relative_velocities
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.pymunk.space import ChainSpace, StaggeredSample
    from scenarios import Impulse, Scene

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
    effects = SUPPORTED | {COM_SHARE}
    observables = frozenset(Observable) - {Observable.COM_RESIDUAL, Observable.TORQUE}
    unsupported_reasons: ClassVar[dict[str, str]] = {
        **dict.fromkeys(PRESCRIBED_ROTATIONS, NO_PRESCRIBED_ROTATION),
        "solar_pressure.shadow": NO_SHADOW,
    }

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
    def gravity(self, scene: Scene) -> Loads:
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
        """Make the space; the frame's orbit belongs to the timed run.

        Raises
        ------
        EngineError
            If a sample would coincide with the step after an event, whose reactions are of first order: see
            :mod:`adapters.pymunk.space`.
        """
        from adapters.pymunk.space import ChainSpace, StepLoads

        intervals = scene.run.samples - 1
        self.every = steps_between_samples(scene, setting.value)
        self.dt_s = scene.run.duration_s / (intervals * self.every)
        self.scene, self.start, self.restarted_at = scene, initial_state(scene), 0
        origin, drift = self.frame(scene, self.start, np.zeros(1))
        self.sweeps = step_sweeps(scene, self.dt_s)
        self.chain = ChainSpace(scene.chain, self.start, origin[0], drift[0], self.dt_s, self.sweeps)
        falling = self.coordinates is Coordinates.MOVING_FRAME
        self.loads = StepLoads(ChainLoads(scene, self.gravity(scene), falling=falling))
        self.chain.install(self.loads)
        self.jumps = events_by_step(scene, self.dt_s)
        if any((step + 1) % self.every == 0 for step in self.jumps):
            raise EngineError(
                "a sample is one step after an event; at least two steps are required: request twice the steps"
            )
        self.seen: list[StaggeredSample] = []
        self.impulse_N_s: Array = np.zeros((scene.bars - 1, 2))
        self.impulses: list[Array] = []
        self.ended = ""

    def simulate(self) -> None:
        """Step from sample to sample."""
        t_s = np.linspace(0.0, self.scene.run.duration_s, self.last_step + 1)
        self.origin_m, self.drift_m_s = self.frame(self.scene, self.start, t_s)
        self.track = np.hstack([self.origin_m, self.drift_m_s]).tolist()
        step = 0
        try:
            if 0 in self.jumps:
                self.restart(0, self.frame_start())
            for step in range(self.last_step + 1):
                self.loads.move_to(self.frame_state(step, before=step > 0))
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
            self.restart(step, synchronised(self.scene, staggered))
            self.loads.move_to(self.frame_state(step, before=False))
            self.chain.half_step()

    def frame_start(self) -> InitialState:
        """Initial state in the space's own axes."""
        start = self.start
        com, drift = start.com_m - self.origin_m[0], start.com_velocity_m_s - self.drift_m_s[0]
        return dataclasses.replace(start, com_m=com, com_velocity_m_s=drift)

    def restart(self, step: int, state: InitialState) -> None:
        """Restart from `state`, in the space's own axes, after the impulses at the end of `step`."""
        if self.jumps[step]:
            state, found = self.after_impulses(state, self.jumps[step])
            self.impulse_N_s = self.impulse_N_s + found
        self.chain, self.restarted_at = self.space_at(state), step
        self.chain.install(self.loads)

    def space_at(self, state: InitialState) -> ChainSpace:
        """A chain that starts from `state`, in the space's own axes."""
        from adapters.pymunk.space import ChainSpace

        return ChainSpace(self.scene.chain, state, np.zeros(2), np.zeros(2), self.dt_s, self.sweeps)

    def after_impulses(self, start: InitialState, impulses: Sequence[Impulse]) -> tuple[InitialState, Array]:
        """State after impulses under closed joints, and the impulsive reactions by momentum along the chain."""
        scene, chain, mass = self.scene, self.space_at(start), np.array(self.scene.chain.mass_kg)
        jumps = impulse_jumps(bars_of(scene.chain), impulses, start.angle_rad.tolist())
        before = np.array(chain.velocities())
        chain.apply_impulses(jumps)
        after, given = np.array(chain.velocities()), np.array(jumps)
        held = np.cumsum(mass[:, None] * (after - before - given)[:, :2], axis=0)[:-1]
        gained = mass @ given[:, :2] / mass.sum()
        return chain_state(scene, start.com_m, start.com_velocity_m_s + gained, start.angle_rad, after[:, 2]), held

    def read(self) -> Trajectory:
        """Observables at the samples, from the half steps around each."""
        n, dt = len(self.seen), self.dt_s
        position, before, after = (np.array(values) for values in zip(*self.seen, strict=True))
        origin, drift = self.origin_m[:: self.every][:n], self.drift_m_s[:: self.every][:n]
        gain, mean = (after - before) / dt, 0.5 * (before + after)
        gain[0], mean[0] = 2.0 * gain[0], before[0]  # the first one is half a step, from the initial instant on
        mass = np.array(self.scene.chain.mass_kg)
        share = mass / mass.sum()
        pull = mass[:, None] * (gain[..., :2] - self.field(position, mean))
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

    def field(self, position: Array, rate: Array) -> Array:
        """Acceleration of each bar by the loads of the run at the samples, (n, N, 2) m/s²."""
        found = np.zeros((*position.shape[:2], 2))
        for i, (bars, rates) in enumerate(zip(position.tolist(), rate.tolist(), strict=True)):
            frame_state = self.frame_state(i * self.every, before=i > 0)
            found[i] = [load[:2] for load in self.loads.chain_loads(frame_state, bars, rates)]
        return found

    def gaps(self, position: Array) -> Array:
        """Distance between the bar ends at each joint, (n, N-1) m."""
        along, _ = directions(position[..., 2])
        left, right = (
            np.array(lever_m)[:, None] * along for lever_m in (self.scene.chain.left_m, self.scene.chain.right_m)
        )
        gap = np.diff(position[..., :2], axis=1) - (left[:, 1:] + right[:, :-1])
        return np.hypot(gap[..., 0], gap[..., 1])


@final
class Pymunk(PymunkEngine):
    """In a frame that falls freely with the chain's centre of mass at first."""

    title = "pymunk, impulses and joints in a freely falling frame"
    coordinates = Coordinates.MOVING_FRAME

    @staticmethod
    def farthest_m(scene: Scene) -> float:
        """Bars stay within the chain's length of the frame's origin, plus the drift by nongravitational forces."""
        return scene.size_m + drift_bound_m(scene)

    def frame(self, scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:
        """Orbit of a particle started as the centre of mass is; uniform motion without gravity."""
        return free_fall(scene, start, t_s)

    def gravity(self, scene: Scene) -> Loads:
        """Gravity less that at the origin."""
        return MovingLoads(scene)


@final
class PymunkAbsolute(PymunkEngine):
    """From the centre of the body: joints and gravity out of differences of large numbers."""

    title = "pymunk, impulses and joints in inertial coordinates"
    coordinates = Coordinates.ABSOLUTE

    @staticmethod
    def farthest_m(scene: Scene) -> float:
        """Apoapsis of a bound orbit; else the distance at the initial speed."""
        if scene.bound:
            return max(scene.radius0_m, scene.highest_radius_m)
        return scene.radius0_m + scene.speed0_m_s * scene.run.duration_s

    def frame(self, scene: Scene, start: InitialState, t_s: Array) -> tuple[Array, Array]:  # noqa: ARG002
        """Return the centre of the body, at rest."""
        return np.zeros((len(t_s), 2)), np.zeros((len(t_s), 2))

    def gravity(self, scene: Scene) -> Loads:
        """Gravity as it is."""
        return AbsoluteLoads(scene)


def synchronised(scene: Scene, staggered: StaggeredSample) -> InitialState:
    """State in the space's axes at an instant between two half steps, with closed joints."""
    position, before, after = (np.array(rows) for rows in staggered)
    mean, share = 0.5 * (before + after), np.array(scene.chain.mass_kg) / scene.mass_kg
    return chain_state(scene, share @ position[:, :2], share @ mean[:, :2], position[:, 2], mean[:, 2])


def chain_state(scene: Scene, com_m: Array, com_velocity_m_s: Array, angle: Array, rate: Array) -> InitialState:
    """State of a chain with closed joints."""
    model = chain_model(scene)
    position, velocity = relative_positions(model, angle), relative_velocities(model, angle, rate)
    return InitialState(com_m, com_velocity_m_s, angle, rate, position, velocity)
