"""Trials: faulty engines run, and judged as in a comparison."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from adapters.common.equal_steps import finer_setting
from adapters.engine import EngineError
from adapters.registry import find_own_engine
from barchain.boundary.declared import engine_class
from barchain.execution.executors import ALL_CORES
from barchain.faults.insertion import engine_with_fault, fault_registration
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.run.job import Job, Role, RunResult
from barchain.run.pool import run_jobs, run_together
from barchain.run.time_limits import TimeLimit
from barchain.run.worker import run_phases
from barchain.solutions.reference_runs import NUMPY, solution_jobs, solution_of
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from adapters.engine import Engine, Setting
    from adapters.trajectory import Trajectory
    from barchain.execution.executors import Executor
    from barchain.faults.fault import Fault
    from barchain.judge.verdict import Verdict
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

TIME_LIMIT_S = 120.0  # a hundred times what the longest unmodified run takes


class SelftestError(EngineError):
    """Raised where a run fails that the self-test can't go on without."""


@dataclass(frozen=True)
class SelftestCase:
    """One scene's reference solution, and the engine that faults are inserted into there."""

    solution: ReferenceSolution
    host: str
    engine: type[Engine]
    settings: dict[Role, Setting]
    unmodified_runs: dict[Setting, Trajectory] = field(default_factory=dict)
    """Runs of the host as it is"""
    controls: dict[str, Trajectory] = field(default_factory=dict)
    """Main runs of all controls"""

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.solution.scene


class FaultTrial(NamedTuple):
    """One fault at one size in one scene."""

    case: SelftestCase
    fault: Fault
    size: float

    @property
    def key(self) -> tuple[str, str, float]:
        """Scene, fault, size."""
        return self.case.scene.name, self.fault.name, self.size

    @property
    def replays(self) -> bool:
        """Whether recorded runs of the unmodified engine serve."""
        return self.fault.replays and bool(self.case.unmodified_runs)

    def jobs(self) -> list[Job]:
        """Jobs at the main and the finer setting."""
        made = fault_registration(self.case.host, self.fault.name, self.size)
        return [Job(self.case.scene, self.fault.name, made, s, role) for role, s in self.case.settings.items()]


@dataclass(frozen=True)
class TrialResult:
    """Result of a trial."""

    trial: FaultTrial
    main: RunResult
    finer: RunResult
    verdict: Verdict


def selftest_cases(
    scenes: Iterable[Scene], host: str, *, executor: Executor = ALL_CORES, done: Callable[[int], None] = lambda _: None
) -> list[SelftestCase]:
    """Reference solutions of scenes that a host supports, established as in a comparison.

    Raises
    ------
    SelftestError
        If a reference solution can't be run.
    """
    engine = engine_class(find_own_engine(host))
    wanted = {s.name: s for s in scenes}
    runs: dict[str, dict[Role, RunResult]] = {name: {} for name in wanted}
    jobs = [(name, job) for name, s in wanted.items() for job in solution_jobs(s, NUMPY)]
    for job, result in run_jobs([job for _, job in jobs], time_limit_s=TIME_LIMIT_S, executor=executor):
        if result.outcome is not Outcome.PASS:
            raise SelftestError(f"{job.scene.name}: the reference solution could not be run ({result.reason})")
        runs[job.scene.name][job.role] = result
        done(1)
    setting = engine.sweep.setting()
    cases = []
    for name, scene in wanted.items():
        solution = solution_of(scene, runs[name], NUMPY)
        assert solution is not None  # all of its runs have come, and none failed
        settings = {Role.MAIN: setting, Role.FINER: finer_setting(scene, engine.sweep, setting)}
        cases.append(SelftestCase(solution, host, engine, settings))
    return cases


def run_trials(trials: Iterable[FaultTrial], *, executor: Executor = ALL_CORES) -> Iterator[TrialResult]:
    """Run each trial at its main and its finer setting, and judge it; results as they come."""
    waiting = {t.key: t for t in trials}
    for trial in [t for t in waiting.values() if t.replays]:
        yield judged(trial, *(replayed(trial, job) for job in trial.jobs()))
    runs: dict[tuple[str, str, float], dict[Role, RunResult]] = {}
    by_job = {job.key: t for t in waiting.values() if not t.replays for job in t.jobs()}
    jobs = [job for t in waiting.values() if not t.replays for job in t.jobs()]
    if not jobs:
        return
    for job, result in run_together(jobs, TimeLimit(TIME_LIMIT_S), executor):
        trial = by_job[job.key]
        by_role = runs.setdefault(trial.key, {})
        by_role[job.role] = result
        if len(by_role) == len(trial.case.settings):
            del runs[trial.key]
            yield judged(trial, by_role[Role.MAIN], by_role[Role.FINER])


def replayed(trial: FaultTrial, job: Job) -> RunResult:
    """Result of a recorded run with the fault in it."""
    case = trial.case
    return run_phases(job, engine_with_fault(trial.fault, trial.size, case.engine, case.unmodified_runs))


def judged(trial: FaultTrial, main: RunResult, finer: RunResult) -> TrialResult:
    """Trial with its verdict."""
    case = trial.case
    setting = case.settings[Role.MAIN]
    verdict = judge(trial.fault.name, case.engine, setting, Evidence(main, finer), case.solution)
    return TrialResult(trial, main, finer, verdict)
