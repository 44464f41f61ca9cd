"""Scenes with their reference solutions, and trials on them as soon as their runs are there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.solutions.reference_runs import SolutionFailedError, solution_jobs, solution_of
from barchain.studies.selftest.trial import FIRST, TrialCase

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from barchain.runs.job import Role
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.runs import RunCache
    from barchain.studies.selftest.trial import Trial
    from scenarios import Scene


def untold(done: int) -> None:
    """Report no progress."""
    del done


class TrialRunner:
    """Scenes on which engines are tried, with all runs that were made."""

    def __init__(self, runs: RunCache) -> None:
        self.runs = runs
        self.solutions: dict[str, ReferenceSolution] = {}
        """Reference solutions by scene"""
        self.failed: dict[str, str] = {}
        """Scenes without one, and why"""

    def solve(self, scenes: Sequence[Scene], form: str | None = None, done: Callable[[int], None] = untold) -> None:
        """Find the reference solutions of scenes, by a form of the reference; by that of a comparison by default."""
        jobs = {scene.name: solution_jobs(scene, form) for scene in scenes}
        for _ in self.runs.made(job for each in jobs.values() for job in each):
            done(1)
        for scene in scenes:
            try:
                solution = solution_of(scene, {job.role: self.runs[job] for job in jobs[scene.name]}, form)
            except SolutionFailedError as error:
                self.failed[scene.name] = f"the reference solution could not be run ({error})"
                continue
            assert solution is not None  # all of its runs are there
            self.solutions[scene.name] = solution

    def ready(self, trials: Iterable[Trial]) -> Iterator[Trial]:
        """Make the first runs of trials; each trial as soon as its runs are there."""
        jobs = [(trial, trial.jobs()) for trial in trials]
        waiting = [(trial, {job.key for job in own if job not in self.runs}) for trial, own in jobs]
        yield from (trial for trial, keys in waiting if not keys)
        waiting = [(trial, keys) for trial, keys in waiting if keys]
        for job in self.runs.made(job for _, own in jobs for job in own):
            for trial, keys in waiting:
                if job.key in keys:
                    keys.remove(job.key)
                    if not keys:
                        yield trial

    def forget(self, trial: Trial) -> None:
        """Drop the runs that no other trial needs."""
        if not trial.replays:
            self.runs.forget(trial.jobs())

    def case(self, trial: Trial, further_runs: tuple[Role, ...] = ()) -> TrialCase:
        """A trial with its runs."""
        made = {job.role: (job, self.runs[job]) for job in trial.jobs((*FIRST, *further_runs))}
        return TrialCase(trial, self.solutions[trial.scene.name], made)
