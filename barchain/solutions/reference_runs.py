"""Runs of the reference for a scene's reference solution, and the reference solution from their results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, Setting
from adapters.reference.compiled_engine import CLOSE_START_RAD, ReferenceWide
from adapters.registry import COMPILED, ENGINES, WIDE
from barchain.runs.job import SOLUTION_ROLES, Job, Role, RunResult
from barchain.runs.timing.estimate import estimated_run_s
from barchain.solutions.reference import (
    FINE_RTOL,
    SOLUTION_CHECK_RTOL,
    SOLUTION_RTOL,
    WIDE_CHECK_RTOL,
    WIDE_RTOL,
    ReferenceSolution,
    densely_sampled,
    establish,
    with_perturbed_start,
)
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from adapters.trajectory import Trajectory
    from scenarios import Scene

NUMPY = "reference"
MOST_BARS, MOST_BAR_SECONDS = 24, 0.1
"""Size of a scene up to which runs in extended precision take seconds: bars, and bars times the estimated seconds of a
run in double precision (measured: 0.3 to 3 s where the product is 0.002 to 0.04)"""


class SolutionFailedError(RuntimeError):
    """A run for a scene's reference solution failed; the message gives the reason in one line."""


def solution_engine() -> str:
    """Engine of reference solutions: the compiled reference if it is installed, for its speed, else the NumPy form."""
    return NUMPY if ENGINES[COMPILED].missing else COMPILED


def judging_engine(scene: Scene) -> str:
    """Engine of a scene's reference solution: extended precision where its runs take seconds."""
    if solution_engine() == NUMPY or scene.bars > MOST_BARS or ReferenceWide.unsupported(scene):
        return solution_engine()
    return WIDE if scene.bars * estimated_run_s(scene) < MOST_BAR_SECONDS else COMPILED


def solution_jobs(scene: Scene, engine: str | None = None) -> list[Job]:
    """Runs of the reference for a scene's reference solution.

    Parameters
    ----------
    scene : Scene
    engine : str, optional
        Form of the reference; that of :func:`judging_engine` by default.
    """
    name = engine or judging_engine(scene)

    def job(of: Scene, rtol: float, role: Role, form: str = name, options: tuple[str, ...] = ()) -> Job:
        return Job(of, form, ENGINES[form], Setting(AccuracyParameter.RTOL, rtol), role, options)

    if name == WIDE:
        return [
            job(scene, WIDE_RTOL, Role.SOLUTION, options=("judging",)),
            job(scene, WIDE_CHECK_RTOL, Role.SOLUTION_CHECK, options=("judging",)),
            job(with_perturbed_start(scene), WIDE_CHECK_RTOL, Role.PERTURBED_START, options=("judging",)),
            job(densely_sampled(scene), FINE_RTOL, Role.FINE, COMPILED),
            job(scene, WIDE_RTOL, Role.CLOSE_START, options=("judging", "close_start")),
        ]
    return [
        job(scene, SOLUTION_RTOL, Role.SOLUTION),
        job(scene, SOLUTION_CHECK_RTOL, Role.SOLUTION_CHECK),
        job(with_perturbed_start(scene), SOLUTION_RTOL, Role.PERTURBED_START),
        job(densely_sampled(scene), FINE_RTOL, Role.FINE),
    ]


def solution_of(scene: Scene, runs: Mapping[Role, RunResult], engine: str | None = None) -> ReferenceSolution:
    """Reference solution of a scene from the runs of :func:`solution_jobs`.

    Raises
    ------
    SolutionFailedError
        If one failed.
    """
    wide = (engine or judging_engine(scene)) == WIDE
    seen = completed(runs, (*SOLUTION_ROLES, Role.CLOSE_START) if wide else SOLUTION_ROLES)
    return establish(scene, *seen, close_rad=CLOSE_START_RAD)


def completed(runs: Mapping[Role, RunResult], roles: Sequence[Role]) -> list[Trajectory]:
    """Trajectories of all roles in their order.

    Raises
    ------
    SolutionFailedError
        If one of the runs failed.
    """
    failed = [runs[role].reason for role in roles if runs[role].outcome is not Outcome.PASS]
    if failed:  # usually for the same reason, which is then given once
        raise SolutionFailedError("; ".join(dict.fromkeys(failed)))
    seen = [runs[role].trajectory for role in roles]
    return [t for t in seen if t is not None]
