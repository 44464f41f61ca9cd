"""diffrax adapter: barchain's equations in JAX, stepped by diffrax."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from adapters.common.initial_state import POINT_PART, initial_state
from adapters.common.landing import landing_text
from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, EngineError
from adapters.trajectory import ENDED, Observable, Trajectory

if TYPE_CHECKING:
    from adapters.engine import Setting
    from scenarios import Scene


@final
class DiffraxDopri8(Engine):
    """Dopri8 with diffrax's default step control."""

    title = "diffrax (JAX), Dopri8, on barchain's equations in JAX"
    coordinates = Coordinates.RELATIVE
    order = None
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13), default=1e-10
    )
    effects = frozenset({"gravity.none", "gravity.point", "gravity.gradient"})
    observables = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION})

    def build(self, scene: Scene, setting: Setting) -> None:
        """Compile the run, unless one of this shape is compiled already."""
        from adapters.ode_solvers.diffrax.compiled import Shape, compiled_run, double
        from adapters.ode_solvers.diffrax.equations import jax_chain

        start = initial_state(scene)
        gravity = POINT_PART[scene.effects.gravity]
        self.shape = Shape(scene.bars, gravity, scene.run.samples, scene.central_body.radius_m > 0.0)
        self.times_s, self.chain = scene.times_s, jax_chain(scene)
        y0 = np.concatenate([start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s])
        self.given = self.chain, double(y0), double(self.times_s), double(setting.value)
        self.compiled = compiled_run(self.shape)

    def simulate(self) -> None:
        """Run the compiled code to its end."""
        self.solved = self.compiled(*self.given)
        self.solved.y.block_until_ready()

    def read(self) -> Trajectory:
        """Observables at the samples."""
        from adapters.ode_solvers.diffrax.compiled import STAGES, compiled_reactions

        found, n = self.solved, self.shape.bars
        end_s, steps = float(found.end_s[0]), int(found.steps)
        landed = end_s < self.times_s[-1]
        count = int(np.searchsorted(self.times_s, end_s, side="right"))
        y = np.asarray(found.y)[:count]
        if bool(found.failed) or not np.isfinite(y).all():
            raise EngineError(f"diffrax: the run failed after {steps} steps")
        info: dict[str, float | str] = {"steps": int(found.accepted), "evaluations": STAGES * steps + 2}
        reaction = np.asarray(compiled_reactions(self.shape)(self.chain, found.y))[:count]
        return Trajectory(
            self.times_s[:count],
            y[:, :2],
            y[:, 2:4],
            y[:, 4 : 4 + n],
            y[:, 4 + n :],
            reaction,
            ended=landing_text(end_s if landed else None),
            info=info | ({ENDED: end_s} if landed else {}),
        )
