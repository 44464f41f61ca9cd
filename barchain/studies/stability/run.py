"""Runs of a stability study: each result leads to the next setting, each engine is judged once its runs are there."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from adapters.engine import EngineError
from barchain.runs.declared import engine_class
from barchain.runs.job import JUDGING_ROLES, Job, Role, RunResult, failure
from barchain.runs.order import longest_first
from barchain.runs.pool import RunQueue
from barchain.runs.time_limits import TimeLimit
from barchain.runs.timing.left_out import cannot
from barchain.solutions.reference import SOLUTION_RTOL, ReferenceSolution
from barchain.solutions.reference_runs import SolutionFailedError, judging_engine, solution_jobs, solution_of
from barchain.studies.stability import expected
from barchain.studies.stability.engine_runs import LEVEL_WORDS, WITH_TRAJECTORY, EngineRuns
from barchain.studies.stability.evidence import condition_range, laws
from barchain.studies.stability.growth import linear_rate
from barchain.studies.stability.plan import LEVELS, LONG, SOLUTION_LIMIT_S, exact_jobs, settings
from barchain.studies.stability.rules import ILL_POSED, Finding, finding
from barchain.studies.stability.store import StabilityStore
from reports.tables.outcome import Outcome
from reports.tables.stability import Stability

if TYPE_CHECKING:
    from adapters.engine import Setting
    from barchain.record.study_store import StudyStore
    from barchain.studies.stability.plan import StabilityPlan
    from barchain.studies.study import Reporter
    from scenarios import Scene

REFERENCES = ("reference", "reference-fast")
"""Engines that must be stable in all scenes that are well-posed"""
REFERENCE_PATIENCE = 10.0
"""Times the time limit that these are given: they are to be judged, and NumPy takes minutes for a thousand orbits"""
FIRST_ROLES = (Role.COARSE, Role.PLAIN)
"""Runs that do not wait for a coarser one"""

Pair = tuple[str, str]


@dataclass
class HardSceneRuns:
    """One scene as its results come."""

    scene: Scene
    solution_runs: dict[Role, RunResult] = field(default_factory=dict)
    runs: dict[str, dict[Role, RunResult]] = field(default_factory=dict)
    solution: ReferenceSolution | None = None
    solution_failed: str = ""
    exact: RunResult | None = None
    """Run with compensated sums that waits for the reference solution"""

    @property
    def solution_settled(self) -> bool:
        """Whether it is known that there is a reference solution, or none."""
        return self.solution is not None or bool(self.solution_failed)


@dataclass(frozen=True)
class StabilityResult:
    """Result of a study."""

    findings: dict[Pair, Finding]
    changes: tuple[expected.OutcomeChange, ...]
    ours: tuple[Pair, ...]
    """Scenes that are well-posed, and in which a form of the reference is not stable"""
    failures: tuple[str, ...] = ()
    """Engines that do not load, one line each"""

    @property
    def passed(self) -> bool:
        """Whether every engine loads, the reference is stable and no outcome changed."""
        return not self.ours and not self.changes and not self.failures


class StabilityRun:
    """One study of many scenes and engines."""

    def __init__(self, plan: StabilityPlan, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets scene, engine and outcome after each run."""
        order = [(s.name, name) for s in plan.scenes for name in plan.engines]
        self.plan, self.report, self.note = plan, reporter.step, reporter.note
        self.store = StabilityStore(store, plan.time_limit_s, order)
        self.scenes = {scene.name: HardSceneRuns(scene) for scene in plan.scenes}
        self.faults: dict[str, str] = {}
        self.recorded = expected.recorded()
        self.findings: dict[Pair, Finding] = {}
        self.changes: list[expected.OutcomeChange] = []
        self.store.note = self.note
        self.earlier = self.store.earlier_runs()

    def run(self) -> StabilityResult:
        """Make all runs, and judge each engine in each scene as soon as its last one is there."""
        self.leave_out()
        with self.plan.executor.session() as session:
            self.queue = RunQueue(session)
            for job in (*(j for s in self.plan.scenes for j in solution_jobs(s)), *longest_first(self.first_jobs())):
                self.ask(job)
            for job, result in self.queue.results():
                self.take(job, result)
        failures = tuple(f"{name}: {fault}" for name, fault in self.faults.items())
        return StabilityResult(self.findings, tuple(self.changes), self.unstable_references(), failures)

    def first_jobs(self) -> list[Job]:
        """Runs of engines that wait for no other."""
        found = []
        for scene in self.plan.scenes:
            found += exact_jobs(scene)
            for name in self.plan.engines_of(scene):
                if (scene.name, name) not in self.findings:
                    own = self.settings_of(scene, name)
                    first = [r for r in FIRST_ROLES if r in own]
                    if Role.COARSE not in own:
                        first.append(Role.MAIN)
                    found += [self.job(scene, name, role) for role in first]
        return found

    def settings_of(self, scene: Scene, engine: str) -> dict[Role, Setting]:
        """Settings of an engine in a scene."""
        return settings(scene, engine_class(self.plan.engines[engine]))

    def job(self, scene: Scene, engine: str, role: Role) -> Job:
        """Run of an engine at one of its settings."""
        return Job(scene, engine, self.plan.engines[engine], self.settings_of(scene, engine)[role], role)

    def leave_out(self) -> None:
        """Settle the engines that do not support a scene, and those that do not load."""
        for scene in self.plan.scenes:
            for name, registration in self.plan.engines_of(scene).items():
                out = cannot(scene, name, registration)
                if out is None:
                    continue
                if out.outcome is Outcome.UNSUPPORTED:
                    self.settle(scene.name, name, Finding(Stability.UNSUPPORTED, out.reason))
                else:
                    self.faults[name] = out.reason
                    self.settle(scene.name, name, Finding(Stability.FAILED, out.reason))

    def ask(self, job: Job) -> None:
        """Queue a run, or take its result where it is known: an earlier study's, or late as a coarser run was."""
        recalled = self.store.recall(job, self.earlier)
        late = self.late_before(job)
        if recalled is not None:
            self.take(job, recalled)
        elif late is not None:
            said = f"not run: the {LEVEL_WORDS[late]} setting already took longer than {self.limit_s(job):g} s"
            self.take(job, failure(Outcome.TIMED_OUT, said))
        else:
            self.queue.add(job, TimeLimit(self.limit_s(job)))

    def limit_s(self, job: Job) -> float:
        """Wall time allowed to a run."""
        if job.role in JUDGING_ROLES:
            return SOLUTION_LIMIT_S
        return self.plan.time_limit_s * (REFERENCE_PATIENCE if job.engine in REFERENCES else 1.0)

    def late_before(self, job: Job) -> Role | None:
        """Coarser level of a job's engine that timed out, if there is one."""
        before = LEVELS[: LEVELS.index(job.role)] if job.role in LEVELS else ()
        runs = self.scenes[job.scene.name].runs.get(job.engine, {})
        return next((r for r in before if r in runs and runs[r].outcome is Outcome.TIMED_OUT), None)

    def take(self, job: Job, result: RunResult) -> None:
        """Note a result, ask for the run that it leads to, and judge what it completes."""
        self.store.keep_run(job, result)
        said = "pass" if result.outcome is Outcome.PASS else f"{result.outcome}: {result.reason}"
        self.report(job.scene.name, job.engine, f"{job.setting} {said}" if said != "pass" else said)
        progress = self.scenes[job.scene.name]
        if job.role in JUDGING_ROLES:
            progress.solution_runs[job.role] = result
            self.found_solution(progress)
        elif job.role is Role.EXACT:
            progress.exact = result
        else:
            progress.runs.setdefault(job.engine, {})[job.role] = result
            if job.role in LEVELS[:-1]:
                self.ask(self.job(job.scene, job.engine, LEVELS[LEVELS.index(job.role) + 1]))
        self.judge_complete(progress)

    def judge_complete(self, progress: HardSceneRuns) -> None:
        """Judge each engine whose runs are all there, once the reference solution is settled."""
        if not progress.solution_settled:
            return
        scene, exact = progress.scene, progress.exact
        if exact is not None:
            progress.exact = None
            self.follow(progress, exact_jobs(scene)[0], exact)
        for engine, runs in progress.runs.items():
            if (scene.name, engine) not in self.findings and runs.keys() == self.settings_of(scene, engine).keys():
                self.judge(progress, engine)

    def found_solution(self, progress: HardSceneRuns) -> None:
        """Establish the reference solution once its runs are made."""
        scene, facts = progress.scene, self.store.record["scenes"][progress.scene.name]
        if any(job.role not in progress.solution_runs for job in solution_jobs(scene)):
            return
        try:
            progress.solution = solution_of(scene, progress.solution_runs)
        except SolutionFailedError as error:
            progress.solution_failed = facts["solution_failed"] = str(error)
            self.note(f"{scene.name} has no reference solution: {error}")
            return
        facts |= solution_facts(progress.solution)
        job = next(j for j in solution_jobs(scene) if j.role is Role.SOLUTION)
        self.follow(progress, job, progress.solution_runs[Role.SOLUTION])
        self.store.write_record()

    def follow(self, progress: HardSceneRuns, job: Job, result: RunResult) -> None:
        """Fit how a run's drifts grow, in a scene that is followed over time."""
        if LONG not in progress.scene.tags or result.trajectory is None or result.outcome not in WITH_TRAJECTORY:
            return
        level = LEVEL_WORDS[job.role]
        self.store.keep_laws(
            *laws(progress.scene, job.engine, level, job.setting, result.trajectory, progress.solution)
        )

    def judge(self, progress: HardSceneRuns, engine: str) -> None:
        """Judge an engine whose runs are all there."""
        scene, runs = progress.scene, progress.runs[engine]
        own = engine_class(self.plan.engines[engine])
        engine_runs = EngineRuns(scene, engine, own, settings(scene, own), runs, progress.solution)
        try:
            solution = progress.solution
            reason = None if solution is None else own.unsupported_motion(solution.scene, solution.fine)
            found = finding(engine_runs) if reason is None else Finding(Stability.UNSUPPORTED, reason)
        except EngineError as error:  # an engine of another package that gives no answer on the motion
            found = Finding(Stability.FAILED, str(error))
        self.settle(scene.name, engine, found, engine_runs)
        for role in (Role.MAIN, Role.FINER):
            job = Job(scene, engine, self.plan.engines[engine], engine_runs.settings[role], role)
            self.follow(progress, job, runs[role])

    def settle(self, scene: str, engine: str, found: Finding, engine_runs: EngineRuns | None = None) -> None:
        """Keep an outcome, and see whether it is the one recorded."""
        before = self.recorded.get((scene, engine))
        changed = expected.change(scene, engine, before, found)
        self.findings[scene, engine] = found
        if changed:
            self.changes.append(changed)
        if engine_runs is None:
            self.store.keep_left_out(scene, engine, found, before, changed)
        else:
            self.store.keep_finding(engine_runs, found, before, changed)

    def unstable_references(self) -> tuple[Pair, ...]:
        """Well-posed scenes in which the reference is not stable; time-outs of a slow machine are left out."""
        posed = {s.name for s in self.plan.scenes if ILL_POSED not in s.tags}
        return tuple(
            (scene, engine)
            for (scene, engine), found in self.findings.items()
            if engine in REFERENCES and scene in posed and not found.slow and found.stability is not Stability.STABLE
        )


def solution_facts(solution: ReferenceSolution) -> dict[str, Any]:
    """Entries of a scene's reference solution in the record."""
    condition, rate = condition_range(solution.scene, solution), linear_rate(solution)
    inside = solution.trajectory.t_s[: len(solution.amplification)] <= solution.limit_s
    return {
        "solution_setting": f"rtol={SOLUTION_RTOL:g}",
        "solution_engine": judging_engine(solution.scene),
        "solution_method": str(solution.trajectory.info.get("method", "")),
        "solution_steps": solution.trajectory.info.get("steps"),
        "solution_error_rad": float(solution.error["attitude"][: len(inside)][inside].max()),
        "solution_limit_s": solution.limit_s,
        "growth_total": float(solution.amplification[-1]),
        "growth_rate_per_s": None if rate is None else rate[0],
        "condition": None if condition is None else list(condition),
        "ended": solution.trajectory.ended,
    }
