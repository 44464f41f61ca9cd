"""An engine that computes in single precision: the chain in minimal coordinates, at equal steps of order 8."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine
from adapters.trajectory import Observable, Trajectory
from barchain.studies.roundoff.scenes import turned_start
from reference_impl.precision.arithmetic import EXACT, FLOAT32
from reference_impl.precision.run import initial_vector, method_of

if TYPE_CHECKING:
    from adapters.engine import Setting
    from scenarios import Scene


class Single(Engine):
    """Rounds its inputs, and every operation, to 24 bits."""

    title = "a chain in single precision"
    coordinates = Coordinates.RELATIVE
    order = 8.0
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (50.0, 100.0), default=50.0)
    effects = frozenset({"gravity.gradient", "gravity.point", "gravity.none"})
    observables: ClassVar = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION})

    def build(self, scene: Scene, setting: Setting) -> None:
        """Round the start."""
        self.scene = scene
        with EXACT.numbers():
            self.chain, self.y = initial_vector(FLOAT32, "minimal", turned_start(scene, np.zeros(1)))
        intervals = scene.run.samples - 1
        self.steps = int(np.ceil(setting.value * scene.run.duration_s / scene.step_period_s / intervals))
        self.h_s = FLOAT32.cast(np.array([scene.run.duration_s / (intervals * self.steps)]))

    def simulate(self) -> None:
        """Step from sample to sample."""
        step, y, self.seen = method_of(FLOAT32, "dop853"), self.y, [self.y]
        for _ in range(self.scene.run.samples - 1):
            for _ in range(self.steps):
                y = step(self.chain.rates, y, self.h_s)
            self.seen.append(y)

    def read(self) -> Trajectory:
        """Samples in double precision; the start as it was given."""
        y, n = np.array(self.seen)[..., 0].astype(float), self.scene.bars
        reaction = np.array([self.chain.observables(v).reaction_N[..., 0].T for v in self.seen], float)
        start = initial_state(self.scene)
        y[0] = np.concatenate([start.com_m, start.angle_rad, start.com_velocity_m_s, start.rate_rad_s])
        return Trajectory(
            self.scene.times_s, y[:, :2], y[:, 2 + n : 4 + n], y[:, 2 : 2 + n], y[:, 4 + n :], reaction_N=reaction
        )
