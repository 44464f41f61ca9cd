"""One engine on one scene, as it is or with a fault in it, and the runs that its verdict takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from adapters.common.equal_steps import finer_setting
from adapters.registry import find_engine
from barchain.faults.catalogue import find
from barchain.faults.insertion import engine_with_fault, fault_registration
from barchain.judge.compare import judge
from barchain.judge.evidence import follow_up_jobs, gathered
from barchain.runs.declared import engine_class
from barchain.runs.job import Job, Role
from barchain.runs.run import run_phases

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.engine import Engine, Setting
    from adapters.registry import Registration
    from adapters.trajectory import Trajectory
    from barchain.faults.fault import Fault
    from barchain.judge.verdict import Verdict
    from barchain.runs.job import RunResult
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

FIRST = (Role.MAIN, Role.FINER)


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
    def host(self) -> type[Engine]:
        """The engine as it is."""
        return engine_class(find_engine(self.engine))

    @property
    def inserted_fault(self) -> Fault | None:
        """The fault; None of an unmodified engine."""
        return find(self.fault) if self.fault else None

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

    def jobs(self, roles: Iterable[Role] = FIRST) -> list[Job]:
        """Runs of some roles."""
        wanted, host, setting = tuple(roles), self.host, self.setting
        first = {Role.MAIN: setting, Role.FINER: finer_setting(self.scene, host.sweep, setting)}
        jobs = [Job(self.scene, self.engine, self.registration, first[r], r) for r in wanted if r in first]
        further = [r for r in wanted if r not in first]
        return jobs + follow_up_jobs(self.scene, self.engine, self.registration, host, setting, further)

    def left_out(self, solution: ReferenceSolution) -> str:
        """Why the fault can't be inserted; empty if it can."""
        fault = self.inserted_fault
        if fault is None:
            return ""
        reason = fault.foreign_to(self.host) or fault.nothing(solution)
        return reason or self.host.unsupported(fault.staged(self.scene, self.inserted_size)) or ""

    @property
    def inserted_size(self) -> float:
        """Size of the fault."""
        fault = self.inserted_fault
        return self.size if self.size is not None else fault.natural if fault else 0.0

    def engine_with_fault(self, runs: dict[Setting, Trajectory], main: Trajectory | None = None) -> type[Engine]:
        """Class of the engine with the fault in it, which replays runs; `main` shows it what to declare wrongly."""
        fault = self.inserted_fault
        return engine_with_fault(fault, self.inserted_size, self.host, runs, main) if fault else self.host


@dataclass(frozen=True)
class DetectionLimit:
    """Smallest error that a verdict states it would detect."""

    share: float
    """Of the quantity's scale"""
    until_s: float
    """End of the comparison with the reference solution, s"""


@dataclass(frozen=True)
class TrialCase:
    """A trial with its runs: all that a verdict takes."""

    trial: Trial
    solution: ReferenceSolution
    made: dict[Role, tuple[Job, RunResult]]
    """Runs by role, with their settings: of the unmodified engine where the trial replays them"""
    unmodified_runs: dict[Role, RunResult] = field(default_factory=dict)
    """Runs of the unmodified engine, where the rating needs them"""
    limits: dict[str, DetectionLimit] = field(default_factory=dict)
    """Detection limits from the unmodified engine's verdict"""
    passes: bool = False
    """Whether the unmodified engine passes; a fault that is then limited by round-off is detected"""

    @property
    def results(self) -> dict[Role, RunResult]:
        """Runs by role, with the fault in them."""
        return {role: self.with_fault(job, result) for role, (job, result) in self.made.items()}

    def with_fault(self, job: Job, result: RunResult) -> RunResult:
        """Result of a run with the fault in it."""
        fault = self.trial.inserted_fault
        if fault is None or not fault.replays or not fault.acts_in(job.role) or result.trajectory is None:
            return result
        return run_phases(job, self.trial.engine_with_fault({job.setting: result.trajectory}))

    def unmodified_trajectory(self, role: Role) -> Trajectory | None:
        """Trajectory of the unmodified engine."""
        return self.unmodified_runs[role].trajectory if role in self.unmodified_runs else None

    def verdict(self, results: dict[Role, RunResult]) -> Verdict:
        """Verdict of the production comparison on results of its runs."""
        evidence = gathered(results)
        assert evidence is not None  # the two first runs are always made
        judged_as = self.trial.engine_with_fault({}, self.unmodified_trajectory(Role.MAIN))
        return judge(self.trial.engine, judged_as, self.trial.setting, evidence, self.solution)
