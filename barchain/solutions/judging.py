"""Solution that judges a scene: shipped, else the reference's, or on request one that heyoka makes here."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.registry import ENGINES
from barchain.runs.job import CERTIFIED_ROLES, Role, RunResult
from barchain.solutions.certified_judge import (
    CERTIFIER,
    MOST_BARS,
    MOST_RADIANS,
    affordable,
    certified_jobs,
    establish_certified,
)
from barchain.solutions.reference import SolutionSource
from barchain.solutions.reference_runs import completed, solution_jobs, solution_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.registry import Registration
    from barchain.runs.job import Job
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

WORDS = {
    SolutionSource.SHIPPED: "certified solution that comes with barchain",
    SolutionSource.HEYOKA: "certified solution, run for this comparison",
    SolutionSource.REFERENCE: "reference solution, run for this comparison",
}
"""Origin of a judging solution in words"""
HEYOKA = "adapters.heyoka."


def why_not_certified(scene: Scene) -> str:
    """Reason why no certified solution of a scene can be made here; empty if it can."""
    certifier = ENGINES[CERTIFIER]
    if certifier.missing:
        return certifier.missing
    if not affordable(scene):
        return f"{CERTIFIER} would take too long, allowed: {MOST_BARS} bars, {MOST_RADIANS:g} rad of the fastest rate"
    return certifier.load().unsupported(scene) or ""


def judging_jobs(scene: Scene, source: SolutionSource) -> list[Job]:
    """Runs for a solution of this kind; none for a shipped one."""
    if source is SolutionSource.SHIPPED:
        return []
    return certified_jobs(scene) if source is SolutionSource.HEYOKA else solution_jobs(scene)


def judging_solution(scene: Scene, source: SolutionSource, runs: Mapping[Role, RunResult]) -> ReferenceSolution:
    """Solution of this kind from its runs.

    Raises
    ------
    SolutionFailedError
        If one failed.
    """
    if source is SolutionSource.REFERENCE:
        return solution_of(scene, runs)
    return establish_certified(scene, *completed(runs, CERTIFIED_ROLES))


def engine_of(source: SolutionSource, reference: str) -> str:
    """Engine that made a solution; `reference` is the form of the reference in use."""
    return CERTIFIER if source.certified else reference


def shares_equations(registration: Registration, source: SolutionSource) -> bool:
    """Whether an engine steps the equations that the judging solution was made with: agreement shows its arithmetic."""
    return registration.target.startswith(HEYOKA) if source.certified else registration.ours
