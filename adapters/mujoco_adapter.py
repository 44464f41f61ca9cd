"""MuJoCo behind the engines' contract: joint coordinates in a freely falling frame, its own RK4.

Reactions are MuJoCo's inner forces: `cfrc_int` of a body is what its parent exerts on it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from adapters.bar_loads import LandedError, MovingLoads
from adapters.engine import Array, Coordinates, Engine, EngineError, Knob, Ladder, Observable, Setting, Trajectory
from adapters.falling_frame import falling
from adapters.initial_state import initial_state
from adapters.joint_coordinates import angles, folded, places, velocities
from adapters.steps import step_s, steps_between_samples
from scenarios import Gravity

if TYPE_CHECKING:
    from scenarios import Scene

NO_LAW = "prescribed rotation: MuJoCo's constraints are soft, so that none holds a law of angle exactly"


@final
class Mujoco(Engine):
    """Tree of hinges on two slides."""

    title = "MuJoCo, joint coordinates in a freely falling frame, RK4"
    coordinates = Coordinates.JOINT
    order = 4.0
    ladder = Ladder(Knob.STEPS_PER_ORBIT, (50, 100, 200, 500, 1000, 2000, 5000), default=1000)
    effects = frozenset({"gravity.none", "gravity.point", "gravity.gradient"})
    observables = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION})
    why_not: ClassVar[dict[str, str]] = {
        f"prescribed_rotation.{what}": NO_LAW for what in ("inertial", "local_horizontal", "external", "joint")
    }

    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the model; the frame's track is part of the run and is computed there."""
        from adapters.mujoco_chain import model_of, posed

        self.scene, self.start = scene, initial_state(scene)
        self.every, self.dt_s = steps_between_samples(scene, setting.value), step_s(scene, setting.value)
        self.length_m = np.array(scene.chain.length_m)
        self.model = model_of(scene.chain, self.dt_s)
        self.data = posed(self.model, *folded(self.length_m, self.start))
        self.seen: list[tuple[Array, Array]] = []
        self.landed_s: float | None = None

    def simulate(self) -> None:
        """Step from sample to sample."""
        import mujoco as mj

        from adapters.mujoco_chain import AppliedLoads, installed

        samples, data = self.scene.run.samples, self.data
        halves: Array = 0.5 * self.dt_s * np.arange(2 * self.every * (samples - 1) + 1, dtype=np.float64)
        self.origin_m, self.drift_m_s = falling(self.scene, self.start, halves)
        self.control = None
        if self.scene.effects.gravity is not Gravity.NONE:
            loads = MovingLoads(self.scene)
            self.control = AppliedLoads(self.scene.chain, data, loads, self.origin_m, 0.5 * self.dt_s)
        self.seen.append((data.qpos.copy(), data.qvel.copy()))
        try:
            with installed(self.control):
                for _ in range(samples - 1):
                    mj.mj_step(self.model, data, nstep=self.every)
                    self.seen.append((data.qpos.copy(), data.qvel.copy()))
        except LandedError:
            self.landed_s = float(data.time)
        except (ArithmeticError, ValueError) as error:
            raise EngineError(f"the chain was lost at t = {data.time:.6g} s: {error}") from error

    def read(self) -> Trajectory:
        """Observables at the samples."""
        reaction = self.reactions()
        n = len(reaction)
        q, q_t = (np.array(rows)[:n] for rows in zip(*self.seen, strict=True))
        weight = np.array(self.scene.chain.mass_kg) / self.scene.mass_kg
        origin, drift = (track[:: 2 * self.every][:n] for track in (self.origin_m, self.drift_m_s))
        return Trajectory(
            self.scene.times_s[:n],
            origin + np.einsum("j,njk->nk", weight, places(self.length_m, q)),
            drift + np.einsum("j,njk->nk", weight, velocities(self.length_m, q, q_t)),
            angles(q),
            angles(q_t),
            reaction,
            ended="" if self.landed_s is None else f"a bar reached the surface at t = {self.landed_s:.6f} s",
            info={
                "steps": (len(self.seen) - 1) * self.every,
                "dt_s": self.dt_s,
                "evaluations": 4 * (len(self.seen) - 1) * self.every,
            },
        )

    def reactions(self) -> Array:
        """Force on each bar from the next, (n, N-1, 2), at the samples before the surface."""
        from adapters.mujoco_chain import installed, reactions

        data, found = self.data, []
        try:
            with installed(self.control):
                for t, (q, q_t) in zip(self.scene.times_s, self.seen, strict=False):
                    if self.landed_s is not None and t >= self.landed_s:
                        break
                    data.time, data.qpos, data.qvel = t, q, q_t
                    found.append(reactions(self.model, data))
        except LandedError:
            self.landed_s = float(data.time)
        return np.array(found)
