"""DOP853 at equal steps on the reference's right-hand side: its order, without the step control's own doing.

A controller aims at the requested error, not at a step; counts of evaluations then carry its first steps,
rejections and a last step cut short, and their slope is no order. Equal steps leave the method alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853

from adapters.common.initial_state import chain_model, initial_state
from reference_impl.integrate.simulate import Simulation

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.studies.cost.points import BoundedSolution
    from scenarios import Scene

STEPS_PER_ORBIT = (16, 20, 25, 32, 40, 50, 64, 80)
ORDER = 8.0


def errors_at_equal_steps(solution: BoundedSolution) -> tuple[Array, Array]:
    """Steps (s) and errors of the attitude at the end (rad), each (n,), above the certified solution's floor.

    Empty for scenes with prescribed rotations: their laws have kinks, which steps would straddle.
    """
    scene, angle = solution.scene, solution.trajectory.angle_rad
    if scene.effects.prescribed_rotation or angle is None or len(solution.trajectory.t_s) < scene.run.samples:
        return np.empty(0), np.empty(0)
    orbits = scene.run.duration_s / scene.step_period_s
    counts = [max(1, round(n * orbits)) for n in STEPS_PER_ORBIT]
    off = np.array([np.abs(end_attitude(scene, n) - angle[-1]).max() for n in counts])
    told = off >= 10.0 * solution.error["attitude"][-1]
    return scene.run.duration_s / np.array(counts)[told], off[told]


def end_attitude(scene: Scene, steps: int) -> Array:
    """Angles at the end, (N,) rad, after `steps` equal steps."""
    start = initial_state(scene)
    simulation = Simulation(
        chain_model(scene), start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s, rtol=1.0
    )
    end_s = scene.run.duration_s
    step_s = end_s / steps
    solver = DOP853(
        simulation.coordinates.rhs, 0.0, simulation.y0, end_s,
        max_step=step_s, first_step=step_s, rtol=1.0, atol=np.inf,
    )  # fmt: skip
    with np.errstate(all="ignore"):  # steps too long for the motion blow up: what they give is no error to be fitted
        while solver.status == "running":
            solver.step()
    return simulation.coordinates.unpack(solver.y).angle_rad
