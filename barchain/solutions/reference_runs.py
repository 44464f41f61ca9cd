"""Runs of the reference for a scene's reference solution, and the reference solution from their results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import COMPILED, ENGINES
from barchain.run.job import SOLUTION_ROLES, Job, Role, RunResult
from barchain.solutions.reference import (
    FINE_RTOL,
    SOLUTION_CHECK_RTOL,
    SOLUTION_RTOL,
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


class SolutionFailedError(RuntimeError):
    """A run for a scene's reference solution failed; the message gives the reason in one line."""


def solution_engine() -> str:
    """Engine of reference solutions: the compiled reference if it is installed, for its speed, else the NumPy form."""
    return NUMPY if ENGINES[COMPILED].missing else COMPILED


def solution_jobs(scene: Scene, engine: str | None = None) -> list[Job]:
    """Runs of the reference for a scene's reference solution.

    Parameters
    ----------
    scene : Scene
    engine : str, optional
        Form of the reference; that of :func:`solution_engine` by default.
    """
    name = engine or solution_engine()

    def job(of: Scene, rtol: float, role: Role) -> Job:
        return Job(of, name, ENGINES[name], Setting(AccuracyParameter.RTOL, rtol), role)

    return [
        job(scene, SOLUTION_RTOL, Role.SOLUTION),
        job(scene, SOLUTION_CHECK_RTOL, Role.SOLUTION_CHECK),
        job(with_perturbed_start(scene), SOLUTION_RTOL, Role.PERTURBED_START),
        job(densely_sampled(scene), FINE_RTOL, Role.FINE),
    ]


def solution_of(scene: Scene, runs: Mapping[Role, RunResult]) -> ReferenceSolution | None:
    """Reference solution of a scene, or None before all its runs have returned.

    Raises
    ------
    SolutionFailedError
        If all runs have returned and one failed.
    """
    seen = completed(runs, SOLUTION_ROLES)
    return None if seen is None else establish(scene, *seen)


def completed(runs: Mapping[Role, RunResult], roles: Sequence[Role]) -> list[Trajectory] | None:
    """Trajectories of all roles in their order; None before all have returned.

    Raises
    ------
    SolutionFailedError
        If all runs have returned and one failed.
    """
    if any(role not in runs for role in roles):
        return None
    failed = [runs[role].reason for role in roles if runs[role].outcome is not Outcome.PASS]
    if failed:  # usually for the same reason, which is then given once
        raise SolutionFailedError("; ".join(dict.fromkeys(failed)))
    seen = [runs[role].trajectory for role in roles]
    return [t for t in seen if t is not None]
