"""The harness of the self-test: one engine on one scene, as it is or with a fault in it, run and judged as a case.

The kill matrix and `benchmarks/random_scenes.py` differ in where scenes and faults come from, and in what they make of
a verdict.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from adapters.common.equal_steps import finer_setting
from adapters.registry import find_engine
from barchain.judge.compare import judge
from barchain.judge.evidence import gathered
from barchain.runs.asking import declarations_of
from barchain.runs.cases import Case, Shared, Task, alone
from barchain.runs.job import TIME_LIMIT_S, Job, Role, TimeLimit
from barchain.runs.run import checked_result
from barchain.runs.tasks import PoolGroup, limit_of, run_task
from barchain.solutions.judging import SolutionFailedError, solution_case
from barchain.studies.selftest.faults.catalogue import FaultRegistration, fault_registration, find
from barchain.studies.verdict_tasks import verdict_task

if TYPE_CHECKING:
    from adapters.engine import Declarations, Setting
    from adapters.registry import Registration
    from adapters.trajectory import Trajectory
    from barchain.judge.verdict import Verdict
    from barchain.runs.call import CallFailedError
    from barchain.runs.job import RunResult
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import Fault
    from scenarios import Scene

FIRST = (Role.MAIN, Role.FINER)
"""Runs that every verdict rests on"""


@dataclass(frozen=True)
class Trial:
    """One engine on one scene; of the fault only the name, so that worker processes can take it."""

    scene: Scene
    engine: str
    fault: str = ""
    """Empty: the engine as it is"""
    size: float | None = None
    """Of the fault; None: its natural size"""

    @property
    def host(self) -> Declarations:
        """Declarations of the engine as it is."""
        return declarations_of(find_engine(self.engine))

    @property
    def inserted_fault(self) -> Fault | None:
        """The fault; None of an unmodified engine."""
        return find(self.fault) if self.fault else None

    @property
    def inserted_size(self) -> float:
        """Size of the fault."""
        fault = self.inserted_fault
        return self.size if self.size is not None else fault.natural if fault else 0.0

    @property
    def replays(self) -> bool:
        """Whether the runs of the unmodified engine suffice."""
        return self.inserted_fault is None or self.inserted_fault.replays

    @property
    def registration(self) -> Registration:
        """Engine that is run: the unmodified one where the fault changes only samples or declarations."""
        return find_engine(self.engine) if self.replays else fault_registration(self.engine, self.fault, self.size)

    @property
    def setting(self) -> Setting:
        """Setting at which it is judged."""
        return self.host.sweep.setting()

    def jobs(self) -> list[Job]:
        """First runs."""
        settings = self.setting, finer_setting(self.scene, self.host.sweep, self.setting)
        return [
            Job(self.scene, self.engine, self.registration, setting, role)
            for role, setting in zip(FIRST, settings, strict=True)
        ]

    def left_out(self, solution: ReferenceSolution) -> str:
        """Why the fault can't be inserted; empty if it can."""
        fault = self.inserted_fault
        if fault is None:
            return ""
        reason = fault.foreign_to(self.host) or fault.nothing(solution)
        return reason or self.host.unsupported(fault.staged(self.scene, self.inserted_size)) or ""

    def declarations(self, main: Trajectory | None) -> Declarations:
        """Declarations with the fault in them; the unmodified engine's `main` run shows what to declare wrongly."""
        fault = self.inserted_fault
        return fault.declares(self.host, main) if fault and fault.declares and main is not None else self.host

    def with_fault(self, job: Job, made: RunResult) -> RunResult:
        """Result of a run with the fault in it; where the fault is in the samples, they are changed here.

        A replay has no durations: a kept verdict is known by what it judges, which has to be the same in every process.
        """
        fault = self.inserted_fault
        if fault is None or not fault.replays or not fault.acts_in(job.role) or made.trajectory is None:
            return made
        seen = fault.output_of(made.trajectory, job.scene, job.setting, self.inserted_size)
        return checked_result(job.scene, self.host, seen, {})


@dataclass(frozen=True)
class TrialRuns:
    """A trial with its runs: all that a verdict takes."""

    trial: Trial
    solution: ReferenceSolution
    results: dict[Role, RunResult]
    """Runs with the fault in them"""
    unmodified: dict[Role, RunResult] = field(default_factory=dict)
    """First runs of the unmodified engine; empty where the trial is of that engine"""

    def unmodified_trajectory(self, role: Role) -> Trajectory | None:
        """Trajectory of the unmodified engine."""
        return self.unmodified[role].trajectory if role in self.unmodified else None


class SceneRuns:
    """Runs on one scene: those of unmodified engines are made once, however many trials need them."""

    def __init__(self, scene: Scene, form: str | None = None, limit_s: float = TIME_LIMIT_S) -> None:
        """Prepare.

        Parameters
        ----------
        scene : Scene
        form : str, optional
            Form of the reference that judges; that of a comparison by default.
        limit_s : float
            Wall time of a run, s.
        """
        self.scene, self.limit_s = scene, limit_s
        self.solution = Shared(self.established(form))
        """The reference solution, or why there is none"""
        self.shared: dict[str, Shared] = {}

    def established(self, form: str | None) -> Case[ReferenceSolution | str]:
        """Find the reference solution."""
        try:
            return (
                yield from solution_case(
                    self.scene, lambda job: run_task(job, limit_of(job, self.limit_s)), engine=form
                )
            )
        except SolutionFailedError as error:
            return f"the reference solution could not be run ({error})"

    def run_of(self, job: Job) -> Task | Shared:
        """Run; engines with a fault share processes, as they are barchain's."""
        if isinstance(job.registration, FaultRegistration):
            return run_task(job, TimeLimit(self.limit_s), PoolGroup.REGISTERED)
        if job.key not in self.shared:
            self.shared[job.key] = Shared(alone(run_task(job, limit_of(job, self.limit_s))))
        return self.shared[job.key]

    def runs_of(self, trial: Trial, solution: ReferenceSolution) -> Case[TrialRuns]:
        """First runs of a trial; of a fault, those of the unmodified engine too."""
        jobs = trial.jobs()
        unmodified = Trial(trial.scene, trial.engine).jobs() if trial.fault else []
        made = yield [self.run_of(job) for job in (*jobs, *unmodified)]
        known = {job.role: result for job, result in zip(unmodified, made[len(jobs) :], strict=True)}
        return with_runs(TrialRuns(trial, solution, {}, known), jobs, made[: len(jobs)])


def with_runs(runs: TrialRuns, jobs: list[Job], made: list[RunResult]) -> TrialRuns:
    """A trial with more of its runs."""
    trial = runs.trial
    results = {job.role: trial.with_fault(job, result) for job, result in zip(jobs, made, strict=True)}
    return replace(runs, results=runs.results | results)


def judged(runs: TrialRuns) -> Case[Verdict | CallFailedError]:
    """Verdict of the production comparison, made in another process; or why there is none."""
    main = runs.unmodified_trajectory(Role.MAIN)
    (found,) = yield [verdict_task(verdict_of, runs.trial, runs.results, runs.solution, main)]
    verdict: Verdict | CallFailedError = found
    return verdict


def verdict_of(
    trial: Trial, results: dict[Role, RunResult], solution: ReferenceSolution, main: Trajectory | None
) -> Verdict:
    """Verdict on results of a trial; `main` is the unmodified engine's main run."""
    found = judge(trial.engine, trial.declarations(main), trial.setting, gathered(results), solution)
    return replace(found, series=None)
