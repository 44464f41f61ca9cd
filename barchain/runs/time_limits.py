"""Time limits of runs, and their defaults; quick to import, as the command line's help reads the defaults."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.runs.job import failure

if TYPE_CHECKING:
    from barchain.runs.job import Job, RunResult

MOST_SECONDS = 172_800.0
"""Largest limit, two days: some runs have ten times a limit, and systems wait at most 2^31 ms (24.8 days) at once."""
TIME_LIMIT_S = 120.0  # the slowest run of the core suite takes a tenth of it on two cores
SOLUTION_PATIENCE = 5.0
"""Limit of a run for the judging solution, relative to an engine's run: a scene without it judges no engine"""
COMPILE_S = 600.0  # in addition to the limit: heyoka compiles 40 s for a set of effects, up to 230 s on a busy machine


@dataclass(frozen=True)
class TimeLimit:
    """Wall time allowed to a run."""

    time_s: float
    compile_s: float = COMPILE_S
    """Additional time for an engine that compiles"""

    def allowed_s(self, job: Job) -> float:
        """Wall time after which a run's process is ended."""
        return self.time_s + (self.compile_s if job.registration.compiles else 0.0)

    def simulate_s(self, job: Job) -> float | None:
        """Wall time after which `simulate` of an engine that compiles ends its process; None for other engines."""
        return self.time_s if job.registration.compiles else None

    def judged(self, job: Job, result: RunResult) -> RunResult:
        """Result of a run; for an engine that compiles, timed out also if `simulate` alone exceeds its limit."""
        from reports.tables.outcome import Outcome  # noqa: PLC0415  # the command line's help imports no tables

        if not job.registration.compiles:
            return result
        if result.seconds.get("simulate", 0.0) > self.time_s:
            return failure(Outcome.TIMED_OUT, f"simulate took longer than {self.time_s:g} s")
        if result.outcome is Outcome.TIMED_OUT and self.compile_s:
            more = f"{self.compile_s:g} s of them for compiling the scene's effects, which is kept for the next run"
            return failure(result.outcome, f"{result.reason}, {more}")
        return result
