"""Largest errors of a run up to the certified solution's predictability limit, and which of them it resolves.

Beside the runs of engines stands DOP853 at equal steps on the reference's right-hand side: its order, without the step
control's own doing. A controller aims at the requested error, not at a step; counts of evaluations then carry its first
steps, rejections and a last step cut short, and their slope is no order. Equal steps leave the method alone.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from barchain.metrics.model_difference import com_displacement
from barchain.metrics.quantities import differences, slowest_rate
from barchain.solutions.certified import MARGIN
from reference_impl.integrate.simulate import Simulation
from reference_impl.model import invariants
from reports.results.comparison import PARTED_RAD
from scenarios import Gravity
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.certified import CertifiedSolution
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

    BoundedSolution = CertifiedSolution | ReferenceSolution
    """Solution with a bound of its error at each sample, (n,) for each quantity: SI units"""

TELLS = MARGIN  # times the certified solution's own error, below which it does not resolve an engine's
VANISHING = 1e-9  # of m n² l: reactions below it are round-off of zero
STEPS_PER_ORBIT = (16, 20, 25, 32, 40, 50, 64, 80)
ORDER = 8.0
"""Of DOP853"""
MEASURED = tuple(CHANNELS[name] for name in ("attitude", "reaction", "com"))
"""Channels whose errors a point has"""


def compared(solution: BoundedSolution) -> int:
    """Count the samples before the certified solution's own error reaches :data:`PARTED_RAD`."""
    bound = solution.error.get("attitude")
    n = len(solution.trajectory.t_s)
    if bound is None:
        return n
    parted = np.nonzero(bound > PARTED_RAD)[0]
    return min(n, int(parted[0])) if len(parted) else n


def errors_of(solution: BoundedSolution, trajectory: Trajectory) -> dict[str, float]:
    """Columns of a point: largest error of each quantity, the certified solution's floor under it, and drifts.

    Parameters
    ----------
    solution : BoundedSolution
    trajectory : Trajectory
        At the same instants; it may end early.

    Returns
    -------
    dict
        ``attitude_error_rad``, ``attitude_floor_rad`` and so on; a quantity that the engine has not got is absent.
    """
    judge, floor = with_particle(solution) if trajectory.angle_rad is None else (solution.trajectory, solution.error)
    n = min(compared(solution), len(trajectory.t_s))
    found: dict[str, float] = {}
    if n == 0:
        return found  # the certified solution is none from the start
    for name, off in differences(trajectory, judge).items():
        if (channel := CHANNELS[name]) in MEASURED:
            found[channel.column_of("error")] = float(off[:n].max())
            found[channel.column_of("floor")] = float(floor[name][:n].max())
    if "reaction_error_N" in found:
        size = reaction_size(solution, n)
        found["reaction_relative"] = found["reaction_error_N"] / size
        found["reaction_floor_relative"] = found["reaction_floor_N"] / size
    if trajectory.gap_m is not None and trajectory.gap_m.size:
        found["gap_m"] = float(trajectory.gap_m[:n].max())
    if trajectory.angle_rad is not None and trajectory.rate_rad_s is not None:
        found["energy_error"] = energy_error(solution, trajectory, n)
    return found


def under_floor(errors: dict[str, float]) -> str:
    """Quantities whose error is below the certified solution's own, joined by commas."""
    blurred = [
        channel.name
        for channel in MEASURED
        if (error := errors.get(channel.column_of("error"))) is not None
        and error < TELLS * errors[channel.column_of("floor")]
    ]
    return ",".join(blurred)


def with_particle(solution: BoundedSolution) -> tuple[Trajectory, dict[str, Array]]:
    """Track that a particle takes for the chain, and the bound of its error.

    An engine without attitude moves a particle: the departure of the chain's centre of mass from that is a
    difference of models, predicted along the certified solution's attitude and taken out.
    """
    apart = com_displacement(solution.scene, solution.trajectory)
    track = solution.trajectory.replace(com_m=solution.trajectory.com_m - apart.vector_m)
    n = len(apart.uncertainty_m)
    return track, {**solution.error, "com": solution.error["com"][:n] + apart.uncertainty_m}


def reaction_size(solution: BoundedSolution, n: int) -> float:
    """Largest true reaction, N; m n² l of the longest bar where reactions vanish."""
    scene, reaction = solution.scene, solution.trajectory.reaction_N
    natural = max(scene.chain.mass_kg) * scene.mean_motion_rad_s**2 * max(scene.chain.length_m)
    largest = 0.0 if reaction is None else float(np.linalg.norm(reaction[:n], axis=-1).max(initial=0.0))
    return largest if largest > VANISHING * natural else natural


def energy(scene: Scene, trajectory: Trajectory) -> tuple[Array, float]:
    """Energy of the chain at each sample, (n,) J, less that of the start, and the kinetic energy there.

    A chain that starts at rest has that of its bars at the orbit's rate instead.
    """
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    model = chain_model(scene)
    inner = invariants.relative_kinetic_energy(model, trajectory.angle_rad, trajectory.rate_rad_s)
    outer = invariants.com_energy(model, trajectory.com_m, trajectory.com_velocity_m_s)
    total = inner + outer
    if scene.effects.gravity is not Gravity.NONE:
        total = total + invariants.tidal_energy(model, trajectory.com_m, trajectory.angle_rad)
    kinetic = inner[0] + 0.5 * scene.mass_kg * float(np.sum(trajectory.com_velocity_m_s[0] ** 2))
    at_rest = 0.5 * float(model.inertia_kg_m2.sum()) * slowest_rate(scene) ** 2
    return total - total[0], float(kinetic) or at_rest


def energy_error(solution: BoundedSolution, trajectory: Trajectory, n: int) -> float:
    """Largest difference of the energy's change from the certified solution's, over the initial kinetic energy.

    The paper's gravity gradient does not conserve energy, so the change is compared, not taken for an error.
    """
    mine, kinetic = energy(solution.scene, head(trajectory, n))
    theirs, _ = energy(solution.scene, head(solution.trajectory, n))
    return float(np.abs(mine - theirs).max()) / kinetic


def head(trajectory: Trajectory, n: int) -> Trajectory:
    """First `n` samples of the quantities in an energy."""
    names = ("t_s", "com_m", "com_velocity_m_s", "angle_rad", "rate_rad_s")
    return dataclasses.replace(trajectory, **{name: getattr(trajectory, name)[:n] for name in names})


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
