"""Scenes × engines: plan the runs, judge each as soon as it can be, keep everything as it comes."""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.common.equal_steps import finer_setting
from adapters.engine import EngineError
from barchain.boundary.declared import OutsideEngine, engine_class, engine_fault
from barchain.boundary.message import plain_text
from barchain.crossval.plan import SceneProgress
from barchain.crossval.required import required_verdicts
from barchain.execution.call import CallLateError
from barchain.judge.compare import judge
from barchain.judge.diagnosis.verdicts import diagnosed_verdict, needs_diagnosis
from barchain.judge.error_model import ErrorModel
from barchain.judge.evidence import follow_up_jobs, gathered
from barchain.judge.verdict import VERDICTS, Verdict, no_verdict
from barchain.metrics.model_difference import com_displacement
from barchain.record.scene_description import gradient_defect
from barchain.run.job import JUDGING_ROLES, Job, Role, RunResult
from barchain.run.order import longest_first
from barchain.run.pool import run_jobs
from barchain.run.verdict_workers import Judges
from barchain.solutions.judging import (
    WORDS,
    engine_of,
    judging_jobs,
    judging_solution,
    shares_equations,
    why_not_certified,
)
from barchain.solutions.reference import ReferenceSolution, SolutionSource
from barchain.solutions.reference_runs import SolutionFailedError, judging_engine
from barchain.solutions.sampling import closely_sampled
from barchain.solutions.shipped import shipped_solution
from reports.tables.crossval import ALL_SCENES, JUDGING_SOLUTION
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Engine, Setting
    from adapters.registry import Registration
    from barchain.crossval.plan import ComparisonPlan
    from barchain.judge.evidence import Evidence
    from barchain.run.store import RunStore
    from scenarios import Scene


class Suite:
    """One comparison of many scenes and engines."""

    def __init__(
        self,
        plan: ComparisonPlan,
        store: RunStore,
        report: Callable[[str, str, str], None],
        note: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Prepare; `report` is told (scene, engine, outcome) after each verdict, `note` what goes on before."""
        self.plan, self.store, self.report, self.note = plan, store, report, note
        store.note = note
        self.progress = {scene.name: SceneProgress(closely_sampled(scene)) for scene in plan.scenes}
        self.classes: dict[str, type[Engine]] = {}
        self.settings: dict[tuple[str, str], Setting] = {}
        """Setting of each engine on each scene, chosen before the first run"""
        self.idle: dict[str, Verdict] = {}
        """Verdicts on engines that were compared on no scene, though they should have been"""
        self.doubted: dict[tuple[str, str], Verdict] = {}
        """Verdicts that wait for the further runs that they request"""
        self.undiagnosed: dict[tuple[str, str], Verdict] = {}
        """Inconsistent verdicts whose diagnosis was requested"""
        self.judges: Judges[tuple[str, str], Verdict] = Judges(VERDICTS, plan.executor)

    def run(self) -> dict[tuple[str, str], Verdict]:
        """Make all runs and judge them; verdicts by (scene, engine)."""
        try:
            return self.judged_runs()
        finally:
            self.judges.close()

    def judged_runs(self) -> dict[tuple[str, str], Verdict]:
        """Verdicts by (scene, engine), of runs as they come."""
        start = time.perf_counter()
        earlier = self.store.earlier_runs()
        self.store.begin()
        waiting = self.recalled(self.jobs(), earlier)
        for text in beforehand(waiting):
            self.note(text)
        self.make(waiting, start)
        self.make(self.recalled(self.fall_back(), earlier), start)
        self.make(self.recalled(self.follow_ups(), earlier), start)
        for (scene, engine), verdict in self.doubted.items():  # the further runs failed: what was found stands
            self.diagnose_and_settle(scene, engine, verdict)
        self.collect(wait=True)
        self.settle_required()
        found = {(name, e): v for name, p in self.progress.items() for e, v in p.verdicts.items()}
        return found | {(ALL_SCENES, e): v for e, v in self.idle.items()}

    def recalled(self, jobs: list[Job], earlier: dict[str, dict[str, Any]]) -> list[Job]:
        """Jobs that are left to do after the results of an earlier comparison are taken."""
        waiting = []
        for job in jobs:
            result = self.store.recall(job, earlier)
            if result is None:
                waiting.append(job)
            else:
                self.take(job, result)
        return waiting

    def make(self, jobs: list[Job], start: float) -> None:
        """Make runs, and take their results as they come."""
        judging, judged = sum(job.role in JUDGING_ROLES for job in jobs), 0
        for job, result in run_jobs(
            longest_first(jobs), time_limit_s=self.plan.time_limit_s, executor=self.plan.executor
        ):
            self.take(job, result)
            if job.role in JUDGING_ROLES:
                judged += 1
                self.note(f"run {judged} of {judging} of judging solutions: {job.scene.name}")
            self.collect(wait=False)
            self.store.record["seconds"] = time.perf_counter() - start
        self.collect(wait=True)

    def follow_ups(self) -> list[Job]:
        """Further runs that doubted verdicts request."""
        jobs = []
        for (name, engine), verdict in self.doubted.items():
            scene, loaded, setting = self.progress[name].scene, self.classes[engine], self.settings[name, engine]
            jobs += follow_up_jobs(scene, engine, self.plan.engines[engine], loaded, setting, verdict.further_runs)
        if jobs:
            self.note(f"{len(jobs)} further runs, to tell round-off and slow convergence from wrong physics")
        return jobs

    def jobs(self) -> list[Job]:
        """All runs to make; engines that do not support a scene get their verdict at once.

        A scene that no engine supports needs no solution.
        """
        jobs = []
        self.prepare()
        for name, progress in self.progress.items():
            of_solution, of_engines = self.jobs_of_solution(progress), []
            for engine, registration in self.plan.engines.items():
                reason = self.cannot(engine, registration, progress.scene)
                if reason is not None:
                    self.settle(name, engine, no_verdict(name, engine, None, *reason))
                else:
                    of_engines += self.engine_jobs(progress, engine, registration)
            jobs += [*of_solution, *of_engines] if of_engines else []
        return jobs

    def jobs_of_solution(self, progress: SceneProgress) -> list[Job]:
        """Runs of the solution that judges a scene: none where a certified solution comes with barchain."""
        shipped = shipped_solution(progress.scene)
        if shipped is not None:
            progress.source = SolutionSource.SHIPPED
            self.establish(progress, shipped)
            return []
        if self.plan.certify:
            reason = why_not_certified(progress.scene)
            progress.source = SolutionSource.REFERENCE if reason else SolutionSource.HEYOKA
            if reason:
                self.note(f"{progress.scene.name}: no certified solution ({reason}); the reference judges")
        return judging_jobs(progress.scene, progress.source)

    def fall_back(self) -> list[Job]:
        """Runs of the reference for scenes whose certified solution could not be run."""
        jobs = []
        for name, progress in self.progress.items():
            if progress.source is SolutionSource.HEYOKA and progress.solution_failed:
                self.note(f"{name}: no certified solution ({progress.solution_failed}); the reference judges")
                progress.source, progress.solution_failed = SolutionSource.REFERENCE, ""
                progress.solution_runs.clear()
                jobs += judging_jobs(progress.scene, progress.source)
        return jobs

    def prepare(self) -> None:
        """Ask engines of other packages about all scenes at once; a failure is told with each scene."""
        for registration in self.plan.engines.values():
            with contextlib.suppress(EngineError):
                asked = None if registration.missing else engine_class(registration)
                if asked is not None and issubclass(asked, OutsideEngine):
                    asked.prepare(p.scene for p in self.progress.values())

    def cannot(self, engine: str, registration: Registration, scene: Scene) -> tuple[Outcome, str] | None:
        """Outcome and reason if an engine is not run on a scene, or None."""
        if registration.missing:
            return Outcome.MISSING, registration.missing
        try:
            self.classes[engine] = engine_class(registration)
            reason = self.classes[engine].unsupported(scene)
        except Exception as error:
            return Outcome.FAILED, engine_fault(error)
        return None if reason is None else (Outcome.UNSUPPORTED, reason)

    def engine_jobs(self, progress: SceneProgress, engine: str, registration: Registration) -> list[Job]:
        """The two runs of one engine on one scene."""
        scene = progress.scene
        setting = self.plan.setting(engine, self.classes[engine], progress.solution)
        self.settings[scene.name, engine] = setting
        finer = finer_setting(scene, self.classes[engine].sweep, setting)
        return [
            Job(scene, engine, registration, setting, Role.MAIN),
            Job(scene, engine, registration, finer, Role.FINER),
        ]

    def take(self, job: Job, result: RunResult) -> None:
        """Store a result, and judge the engines whose runs it completes."""
        self.store.keep_run(job, result)
        progress = self.progress[job.scene.name]
        if job.role in JUDGING_ROLES:
            progress.solution_runs[job.role] = result
            self.found_solution(progress)
            ready = list(progress.runs)
        else:
            progress.runs.setdefault(job.engine, {})[job.role] = result
            ready = [job.engine]
        for engine in ready:
            self.judge_if_ready(progress, engine)

    def found_solution(self, progress: SceneProgress) -> None:
        """Establish the judging solution once its runs are there."""
        try:
            solution = judging_solution(progress.scene, progress.source, progress.solution_runs)
        except SolutionFailedError as error:
            if progress.source is SolutionSource.HEYOKA:
                progress.solution_failed = str(error)  # for the time being, see :meth:`fall_back`
            else:
                self.give_up(progress, str(error))
            return
        if solution is not None:
            self.establish(progress, solution)

    def establish(self, progress: SceneProgress, solution: ReferenceSolution) -> None:
        """Take the solution that judges a scene, and store it with its error amplification."""
        name, progress.solution = progress.scene.name, solution
        shared = [e for e, r in self.plan.engines.items() if shares_equations(r, solution.source)]
        self.store.record["scenes"][name] |= solution_facts(solution) | {"same_equations": shared}
        t = solution.trajectory.t_s[: len(solution.amplification)]
        self.store.keep_amplification(name, pd.DataFrame({"t_s": t, "amplification": solution.amplification}))
        if solution.source.certified:  # no run of its own has these samples
            self.store.keep_solution(name, solution.trajectory.of_run(solution.scene))

    def give_up(self, progress: SceneProgress, reason: str) -> None:
        """Settle a scene that has no judging solution by one verdict; its engines get none."""
        progress.solution_failed, name = f"the judging solution could not be run ({reason})", progress.scene.name
        verdict = no_verdict(name, JUDGING_SOLUTION, None, Outcome.FAILED, progress.solution_failed)
        self.settle(name, JUDGING_SOLUTION, verdict)

    def judge_if_ready(self, progress: SceneProgress, engine: str) -> None:
        """Judge an engine once its two runs and the judging solution exist, if it supports the motion."""
        runs, name = progress.runs[engine], progress.scene.name
        evidence = gathered(runs)
        given = engine in progress.verdicts or (name, engine) in self.judges.waiting
        if evidence is None or progress.solution is None or given:
            return
        setting = self.settings[name, engine]
        try:
            reason = self.classes[engine].unsupported_motion(progress.solution.scene, progress.solution.fine)
        except Exception as error:  # an engine of another package gives no answer on the motion
            self.fail(name, engine, error)
            return
        if reason is not None:
            self.settle(name, engine, no_verdict(name, engine, setting, Outcome.UNSUPPORTED, reason))
            return
        earlier = self.doubted.get((name, engine))
        if earlier is not None and not all(role in runs for role in earlier.further_runs):
            return
        self.submit(progress, engine, setting, evidence)

    def submit(self, progress: SceneProgress, engine: str, setting: Setting, evidence: Evidence) -> None:
        """Judge at once, or in another process where the verdict goes beyond the predictability limit."""
        assert progress.solution is not None
        loaded, name, solution = self.classes[engine], progress.scene.name, progress.solution
        run = evidence.main.trajectory
        errors = None if run is None else ErrorModel(loaded, setting, solution, run)
        try:
            if errors is None or not goes_beyond(errors):
                self.judged(name, engine, judge(engine, loaded, setting, evidence, solution, errors))
                return
            finer = finer_setting(progress.scene, loaded.sweep, setting)
            loaded.noise(progress.scene, finer, errors.t_s)  # an engine of another package is asked here alone
        except Exception as error:
            self.fail(name, engine, error)
            return
        self.judges.submit((name, engine), judge_loaded, engine, loaded, setting, evidence, solution, errors)

    def collect(self, *, wait: bool) -> None:
        """Take verdicts from other processes; a verdict that fails becomes the reason of its engine's row."""
        for (name, engine), verdict in self.judges.collected(wait=wait):
            if isinstance(verdict, Verdict):
                self.judged(name, engine, verdict)
            elif (name, engine) in self.undiagnosed:  # the verdict stands without its diagnosis
                self.settle(name, engine, self.undiagnosed[name, engine])
            else:
                self.fail(name, engine, verdict)

    def fail(self, name: str, engine: str, error: BaseException) -> None:
        """Settle a pair without a verdict: values or claims of the engine that no check foresees, or late judging."""
        said = f"no verdict: {error if isinstance(error, EngineError) else f'{type(error).__name__}: {error}'}"
        outcome = Outcome.NOTHING_COMPARED if isinstance(error, CallLateError) else Outcome.FAILED
        setting = self.settings[name, engine]
        self.settle(name, engine, no_verdict(name, engine, setting, outcome, plain_text(said)))

    def judged(self, name: str, engine: str, verdict: Verdict) -> None:
        """Settle a verdict, or wait for the further runs that it requests."""
        if verdict.further_runs and (name, engine) not in self.doubted:
            self.doubted[name, engine] = verdict
            return
        self.doubted.pop((name, engine), None)
        self.diagnose_and_settle(name, engine, verdict)

    def diagnose_and_settle(self, name: str, engine: str, verdict: Verdict) -> None:
        """Settle a verdict; an inconsistent one after its diagnosis in another process."""
        progress = self.progress[name]
        main = progress.runs[engine][Role.MAIN].trajectory
        if not needs_diagnosis(verdict) or main is None or (name, engine) in self.undiagnosed:
            self.settle(name, engine, verdict)
            return
        self.undiagnosed[name, engine] = verdict
        self.judges.submit((name, engine), diagnosed_verdict, verdict, main, progress.solution)

    def settle(self, scene: str, engine: str, verdict: Verdict) -> None:
        """Store a verdict and report it."""
        self.progress[scene].verdicts[engine] = verdict
        self.store.keep_rows(scene, engine, verdict.rows, verdict.series)
        self.report(scene, engine, verdict.outcome)

    def settle_required(self) -> None:
        """Settle pairs, scenes and engines that lack a verdict that the plan requires."""
        for name, engine, verdict in required_verdicts(self.plan, self.progress):
            if name == ALL_SCENES:
                self.idle[engine] = verdict
                self.store.keep_rows(ALL_SCENES, engine, verdict.rows)
                self.report(ALL_SCENES, engine, verdict.outcome)
            else:
                self.settle(name, engine, verdict)


def judge_loaded(
    name: str,
    engine: type[Engine],
    setting: Setting,
    evidence: Evidence,
    solution: ReferenceSolution,
    errors: ErrorModel,
) -> Verdict:
    """Verdict in another process, to which an error model comes without the engine's class; arguments as of `judge`."""
    return judge(name, engine, setting, evidence, solution, errors.of_engine(engine))


def goes_beyond(errors: ErrorModel) -> bool:
    """Whether a verdict compares beyond the predictability limit, which takes long."""
    try:
        return bool(errors.limit_s < errors.solution.trajectory.t_s[-1])
    except Exception:  # of samples that arithmetic fails on, or an adapter's own: the verdict says so
        return False


def beforehand(jobs: list[Job]) -> list[str]:
    """Announcement of the runs that give no verdict yet; none without such runs."""
    first = [job for job in jobs if job.role in JUDGING_ROLES]
    scenes = len({job.scene.name for job in first})
    of = "a scene" if scenes == 1 else f"{scenes} scenes"
    return [f"solution that judges {of} first: {len(first)} runs"] if first else []


def solution_facts(solution: ReferenceSolution) -> dict[str, Any]:
    """Entry of record.json on the solution that judges a scene."""
    displacement = com_displacement(solution.scene, solution.trajectory)
    inside = solution.trajectory.t_s[: len(solution.amplification)] <= solution.limit_s
    return {
        "solution_source": WORDS[solution.source],
        "solution_engine": engine_of(solution.source, judging_engine(solution.scene)),
        "solution_method": str(solution.trajectory.info.get("method", "")),
        "solution_setting": solution.setting,
        "solution_error_rad": float(solution.error["attitude"][: len(inside)][inside].max()),
        "solution_limit_s": solution.limit_s,
        "amplification_per_orbit": solution.growth_per_orbit,
        "amplification_total": float(solution.amplification[-1]),
        "model_difference": {
            "com_m": float(np.linalg.norm(displacement.vector_m, axis=-1).max()),
            "note": "departure of the chain's centre of mass from a particle's track, O((L/r)²), "
            "predicted along the judging solution's attitude and subtracted for engines without attitude",
        },
        **gradient_defect(solution.scene, solution.trajectory, solution.limit_s),
    }
