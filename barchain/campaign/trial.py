"""One engine on one scene, as it is or with a fault in it, and the runs that its verdict takes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from adapters.registry import find_engine
from adapters.steps import finer_setting
from barchain.campaign.faults import find
from barchain.campaign.runs import planted
from barchain.comparison import judge
from barchain.evidence import follow_up_jobs, gathered
from barchain.job import Job, Role
from barchain.selftest.engine import spoilt
from barchain.worker import run_phases

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.engine import Engine, Setting, Trajectory
    from adapters.registry import Registration
    from barchain.comparison import Verdict
    from barchain.job import RunResult
    from barchain.selftest.fault import Fault
    from barchain.truth import Truth
    from scenarios import Scene

FIRST = (Role.MAIN, Role.FINER)


@dataclass(frozen=True)
class Trial:
    """One engine on one scene; of the fault only the name, so that worker processes can take it."""

    scene: Scene
    engine: str
    fault: str = ""
    """Empty: the engine as it is"""

    @property
    def host(self) -> type[Engine]:
        """The engine as it is."""
        return find_engine(self.engine).load()

    @property
    def planted(self) -> Fault | None:
        """The fault; None of a sound engine."""
        return find(self.fault) if self.fault else None

    @property
    def replays(self) -> bool:
        """Whether it takes no runs besides those of the sound engine."""
        return self.planted is None or self.planted.replays

    @property
    def registration(self) -> Registration:
        """What is run: the engine as it is where only what is read out or declared is spoilt."""
        return find_engine(self.engine) if self.replays else planted(self.engine, self.fault)

    @property
    def setting(self) -> Setting:
        """Setting at which it is judged."""
        return self.host.ladder.setting()

    def jobs(self, roles: Iterable[Role] = FIRST) -> list[Job]:
        """Runs of some roles."""
        wanted, host, setting = tuple(roles), self.host, self.setting
        first = {Role.MAIN: setting, Role.FINER: finer_setting(self.scene, host.ladder, setting)}
        jobs = [Job(self.scene, self.engine, self.registration, first[r], r) for r in wanted if r in first]
        further = [r for r in wanted if r not in first]
        return jobs + follow_up_jobs(self.scene, self.engine, self.registration, host, setting, further)

    def left_out(self, truth: Truth) -> str:
        """Why the fault can't be put in; empty if it can."""
        fault = self.planted
        if fault is None:
            return ""
        staged = fault.staged(self.scene, fault.natural) if not fault.nothing(truth) else self.scene
        return fault.foreign(self.host) or fault.nothing(truth) or self.host.unsupported(staged) or ""


@dataclass(frozen=True)
class Limit:
    """Smallest error that a verdict says it would have called."""

    share: float
    """Of the quantity's scale"""
    until_s: float
    """Where the comparison with the reference solution ends, s"""


@dataclass(frozen=True)
class Case:
    """A trial with its runs: all that a verdict takes."""

    trial: Trial
    truth: Truth
    made: dict[Role, tuple[Job, RunResult]]
    """Runs by role, with what was asked: of the sound engine where the trial replays them"""
    sound: dict[Role, RunResult] = field(default_factory=dict)
    """Runs of the sound engine; empty where the trial is that"""
    limits: dict[str, Limit] = field(default_factory=dict)
    """What the sound engine's verdict says that it would detect"""
    passes: bool = False
    """Whether the sound engine passes: then a fault that is limited by round-off is told, and with its size"""

    @property
    def results(self) -> dict[Role, RunResult]:
        """Runs by role, spoilt."""
        return {role: self.with_fault(job, result) for role, (job, result) in self.made.items()}

    def with_fault(self, job: Job, result: RunResult) -> RunResult:
        """Result of a run with the fault in it."""
        fault = self.trial.planted
        if fault is None or not fault.replays or not fault.spoils(job.role) or result.trajectory is None:
            return result
        return run_phases(job, spoilt(fault, fault.natural, self.trial.host, {job.setting: result.trajectory}))

    @property
    def judged_as(self) -> type[Engine]:
        """Class that is judged, with what it declares."""
        fault = self.trial.planted
        if fault is None:
            return self.trial.host
        return spoilt(fault, fault.natural, self.trial.host, main=self.sound_trajectory(Role.MAIN))

    def sound_trajectory(self, role: Role) -> Trajectory | None:
        """What the sound engine saw."""
        return self.sound[role].trajectory if role in self.sound else None


def verdict_of(case: Case, results: dict[Role, RunResult]) -> Verdict:
    """Verdict of the production comparison."""
    evidence = gathered(results)
    assert evidence is not None  # the two first runs are always made
    return judge(case.trial.engine, case.judged_as, case.trial.setting, evidence, case.truth)
