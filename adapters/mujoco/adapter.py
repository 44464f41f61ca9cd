"""MuJoCo adapter: joint coordinates in a freely falling frame, MuJoCo's RK4.

Reactions are MuJoCo's internal forces: `cfrc_int` of a body is its parent's force on the body.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from adapters.bar_loads.chain_loads import SUPPORTED, ChainLoads
from adapters.bar_loads.falling_frame import free_fall, orbit_noise
from adapters.bar_loads.gravity import LandedError, MovingLoads
from adapters.common import face_reversal
from adapters.common.equal_steps import step_s, steps_between_samples
from adapters.common.initial_state import initial_state
from adapters.common.joint_coordinates import from_joint_coordinates, to_joint_coordinates
from adapters.common.landing import landing_text
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
from adapters.mujoco.chain import AppliedLoads, apply_impulses, data_at, installed, model_of, reactions
from adapters.trajectory import Array, Observable, Trajectory
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from scenarios import Scene

NO_PRESCRIBED_ROTATION = (
    "prescribed rotation is not supported: MuJoCo's constraints are soft and do not hold a bar to its law exactly"
)


@final
class Mujoco(Engine):
    """Tree of hinges on two slides."""

    title = "MuJoCo, joint coordinates in a freely falling frame, RK4"
    coordinates = Coordinates.JOINT
    order = 4.0
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (50, 100, 200, 500, 1000, 2000, 5000), default=1000)
    effects = SUPPORTED | {COM_SHARE}
    observables = frozenset(
        {Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION, Observable.IMPULSE}
    )
    unsupported_reasons: ClassVar[dict[str, str]] = {
        **dict.fromkeys(PRESCRIBED_ROTATIONS, NO_PRESCRIBED_ROTATION),
        "solar_pressure.shadow": NO_SHADOW,
    }

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why the engine does not support `scene`, events within a step included."""
        return super().unsupported(scene) or misalignment(scene)

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """Reason why equal steps do not support a motion: a bar turns its other face to the wind or the Sun."""
        return face_reversal.unsupported_motion(scene, motion)

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Error of the frame's track, where it is integrated."""
        del setting
        return orbit_noise(scene, t_s)

    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the model; the frame's orbit belongs to the timed run."""
        self.scene, self.start = scene, initial_state(scene)
        self.every, self.dt_s = steps_between_samples(scene, setting.value), step_s(scene, setting.value)
        self.length_m, self.left_m = np.array(scene.chain.length_m), np.array(scene.chain.left_m)
        self.model = model_of(scene.chain, self.dt_s)
        self.data = data_at(self.model, *to_joint_coordinates(self.length_m, self.start, self.left_m))
        self.seen: list[tuple[Array, Array]] = []
        self.impulses_by_step = {step: found for step, found in events_by_step(scene, self.dt_s).items() if found}
        self.impulse_N_s: Array = np.zeros((scene.bars - 1, 2))
        self.impulses: list[Array] = []
        self.landed_s: float | None = None

    def simulate(self) -> None:
        """Step from sample to sample and from impulse to impulse."""
        import mujoco as mj

        data, step = self.data, 0
        halves: Array = 0.5 * self.dt_s * np.arange(2 * self.last_step + 1, dtype=np.float64)
        self.origin_m, self.drift_m_s = free_fall(self.scene, self.start, halves)
        loads, track = (
            ChainLoads(self.scene, MovingLoads(self.scene), falling=True),
            np.hstack([self.origin_m, self.drift_m_s]),
        )
        self.control = AppliedLoads(self.scene.chain, data, loads, track, 0.5 * self.dt_s) if loads.act else None
        try:
            with installed(self.control):
                self.apply_impulses(0)
                self.take_sample()
                for stop in sorted({*range(self.every, self.last_step + 1, self.every), *self.impulses_by_step} - {0}):
                    mj.mj_step(self.model, data, nstep=stop - step)
                    if stop % self.every == 0:
                        self.take_sample()
                    self.apply_impulses(stop)
                    step = stop
        except LandedError:
            self.landed_s = float(data.time)
        except (ArithmeticError, ValueError) as error:
            raise EngineError(f"MuJoCo: the run failed at t = {data.time:.6g} s: {error}") from error

    @property
    def last_step(self) -> int:
        """Number of steps."""
        return self.every * (self.scene.run.samples - 1)

    def take_sample(self) -> None:
        """Store the state at a sample."""
        self.seen.append((self.data.qpos.copy(), self.data.qvel.copy()))
        self.impulses.append(self.impulse_N_s)

    def apply_impulses(self, step: int) -> None:
        """Apply the impulses at the end of `step`."""
        if step in self.impulses_by_step:
            found = apply_impulses(self.model, self.data, self.scene.chain, self.impulses_by_step[step])
            self.impulse_N_s = self.impulse_N_s + found

    def read(self) -> Trajectory:
        """Observables at the samples."""
        reaction = self.reactions()
        n = len(reaction)
        q, q_t = (np.array(rows)[:n] for rows in zip(*self.seen, strict=True))
        bars = from_joint_coordinates(self.length_m, q, q_t, self.left_m)
        origin, drift = (track[:: 2 * self.every][:n] for track in (self.origin_m, self.drift_m_s))
        return Trajectory(
            self.scene.times_s[:n],
            *bars.track(np.array(self.scene.chain.mass_kg), origin, drift),
            bars.angle_rad,
            bars.rate_rad_s,
            reaction,
            impulse_N_s=np.array(self.impulses)[:n] if self.scene.effects.impulse else None,
            ended=landing_text(self.landed_s),
            info={
                "steps": (len(self.seen) - 1) * self.every,
                "dt_s": self.dt_s,
                "evaluations": 4 * (len(self.seen) - 1) * self.every,
            },
        )

    def reactions(self) -> Array:
        """Force on each bar from the next, (n, N-1, 2), at the samples before the surface."""
        data, found = self.data, []
        try:
            with installed(self.control):
                for k, (t, (q, q_t)) in enumerate(zip(self.scene.times_s, self.seen, strict=False)):
                    if self.landed_s is not None and t >= self.landed_s:
                        break
                    data.time, data.qpos, data.qvel = t, q, q_t
                    if self.control:
                        self.control.move_frame(2 * self.every * k)
                    found.append(reactions(self.model, data))
        except LandedError:
            self.landed_s = float(data.time)
        return np.array(found)
