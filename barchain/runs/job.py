"""One run of one engine: the job, its time limit and its result; quick to import for the command line's help."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adapters.engine import Setting
    from adapters.registry import Registration
    from adapters.trajectory import Trajectory
    from reports.results.outcome import Outcome
    from scenarios import Scene

MOST_SECONDS = 172_800.0
"""Largest limit, two days: some runs have ten times a limit, and systems wait at most 2^31 ms (24.8 days) at once."""
TIME_LIMIT_S = 120.0  # the slowest run of the core suite takes a tenth of it on two cores
SOLUTION_PATIENCE = 5.0
"""Limit of a run for the judging solution, relative to an engine's run: a scene without it judges no engine"""
COMPILE_S = 600.0  # in addition to the limit: heyoka compiles 40 s for a set of effects, up to 230 s on a busy machine


class Role(StrEnum):
    """Purpose of a run."""

    MAIN = "main"
    """An engine at the setting at which it is judged."""
    FINER = "finer"
    """The engine one setting finer: the difference from the main run estimates its error."""
    FINEST = "finest"
    """The engine two settings finer, where two runs do not show how the error falls."""
    ROUNDOFF_1 = "roundoff-1"
    """The main setting in a slightly turned frame, from a start that differs in its last digits: shows round-off."""
    ROUNDOFF_2 = "roundoff-2"
    """As the first, with another angle of the frame."""
    ROUNDOFF_3 = "roundoff-3"
    """As the first, with a third angle of the frame."""
    SOLUTION = "solution"
    """The reference at its tightest tolerance."""
    SOLUTION_CHECK = "solution-check"
    """The reference at a ten times looser tolerance: error bar of the reference solution."""
    FINE = "solution-dense"
    """The reference at dense samples, for derivatives of the motion."""
    PERTURBED_START = "perturbed-start"
    """The reference from a slightly perturbed start: shows the scene's error amplification."""
    CLOSE_START = "close-start"
    """From a start perturbed below double precision: amplification beyond that of the perturbed start."""
    COARSE = "coarse"
    """An engine at a much coarser setting: shows how its error falls with the setting."""
    PLAIN = "plain"
    """A library's solver at its own default tolerances."""
    EXACT = "exact"
    """The compiled reference at the accuracy at which it sums with compensation of round-off."""


ROUNDOFF_ROLES = (Role.ROUNDOFF_1, Role.ROUNDOFF_2, Role.ROUNDOFF_3)
"""Runs that show a run's round-off: one difference may be small by chance, three hardly"""
SOLUTION_ROLES = (Role.SOLUTION, Role.SOLUTION_CHECK, Role.PERTURBED_START, Role.FINE)
"""Runs of a scene's reference solution, in the order that `barchain.solutions.reference.establish` takes them; in
extended precision from the close start too"""
CERTIFIED_ROLES = (Role.FINE, Role.SOLUTION_CHECK, Role.PERTURBED_START, Role.CLOSE_START)
"""Runs of a scene's certified solution, in the order that `barchain.solutions.judging.establish_certified`
takes them"""
JUDGING_ROLES = frozenset({*SOLUTION_ROLES, *CERTIFIED_ROLES})
"""Runs of the solution that judges a scene, of either kind"""


@dataclass(frozen=True)
class Job:
    """One run that is asked for."""

    scene: Scene
    engine: str
    registration: Registration
    setting: Setting
    role: Role
    options: tuple[str, ...] = ()
    """Extra outputs of the engine, see `Engine.options`; in an order, as a call is known by its bytes"""

    @property
    def file_stem(self) -> str:
        """Name of its trajectory's file inside the scene's folder."""
        if self.role is Role.MAIN:
            return self.engine
        return str(self.role) if self.role in JUDGING_ROLES else f"{self.engine}.{self.role}"

    @cached_property
    def key(self) -> str:
        """Key that is equal for runs of one scene and engine at one setting, for one purpose."""
        return "|".join([self.scene.digest, self.registration.target, str(self.setting), self.role, *self.options])


@dataclass(frozen=True)
class RunResult:
    """Result of a run. The outcome is PASS for a complete, finite trajectory, whatever its accuracy."""

    outcome: Outcome
    reason: str = ""
    trajectory: Trajectory | None = None
    seconds: dict[str, float] = field(default_factory=dict)
    """Wall time of `build`, `simulate` and `read`, s"""
    rejected: bool = False
    """Whether the engine rejected the scene before its first step"""
    phase: str = ""
    """Phase in which a run of an engine of another package failed or was ended, if it is known"""


def failure(outcome: Outcome, reason: str, *, rejected: bool = False, phase: str = "") -> RunResult:
    """Result of a run without a trajectory; the reason is cut to one line."""
    return RunResult(outcome, " ".join(reason.split())[:500], rejected=rejected, phase=phase)


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
        from reports.results.outcome import Outcome  # noqa: PLC0415  # the command line's help imports no tables

        if not job.registration.compiles:
            return result
        if result.seconds.get("simulate", 0.0) > self.time_s:
            return failure(Outcome.TIMED_OUT, f"simulate took longer than {self.time_s:g} s")
        if result.outcome is Outcome.TIMED_OUT and self.compile_s:
            more = f"{self.compile_s:g} s of them for compiling the scene's effects, which is kept for the next run"
            return failure(result.outcome, f"{result.reason}, {more}")
        return result
