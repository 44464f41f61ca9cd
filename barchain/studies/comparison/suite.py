"""Scenes × engines: cases that make the runs and judge them, everything kept as it comes."""

from __future__ import annotations

import contextlib
import dataclasses
import time
from collections import defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.common.equal_steps import finer_setting
from adapters.engine import EngineError
from adapters.trajectory import Observable
from barchain.judge.checks.more_judged import beyond_any_setting
from barchain.judge.diagnosis.own_motion import MadeRuns, densely
from barchain.judge.diagnosis.verdicts import diagnosed_verdict, needs_diagnosis, thinned
from barchain.judge.evidence import follow_up_jobs, gathered
from barchain.judge.verdict import Row, Verdict, no_verdict
from barchain.metrics.model_difference import com_displacement
from barchain.record.scene_description import gradient_defect
from barchain.runs.asking import ask_about, declarations_of
from barchain.runs.call import CallLateError
from barchain.runs.cases import Case, Known, Shared, Task, run_cases
from barchain.runs.job import JUDGING_ROLES, Job, Role, RunResult, failure
from barchain.runs.left_out import cannot
from barchain.runs.message import plain_text
from barchain.runs.other_settings import finer_words, setting_advice
from barchain.runs.run import keep_run
from barchain.runs.tasks import expected_work, limit_of, run_task
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.judging import (
    CERTIFIER,
    WORDS,
    SolutionFailedError,
    judging_engine,
    judging_jobs,
    shares_equations,
    solution_case,
    why_not_certified,
)
from barchain.solutions.reference import ReferenceSolution, SolutionSource, closely_sampled
from barchain.studies.comparison.plan import ANY_INDEPENDENT, SEVERAL, SceneProgress, required_verdicts
from barchain.studies.verdict_tasks import verdict_case, verdict_task
from reports.results.comparison import ALL_SCENES, JUDGING_SOLUTION
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.engine import Declarations, Setting
    from barchain.record.study_store import StudyStore
    from barchain.studies.comparison.plan import ComparisonPlan
    from barchain.studies.study import Reporter


class Suite:
    """One comparison of many scenes and engines: a case for each pair, and one for each scene's judging solution."""

    def __init__(self, comparison: ComparisonPlan, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets scene, engine and outcome after each verdict, and notes on what goes on before."""
        self.comparison, self.store, self.report, self.note = comparison, store, reporter.step, reporter.note
        self.progress = {scene.name: SceneProgress(closely_sampled(scene)) for scene in comparison.scenes}
        self.declared: dict[str, Declarations] = {}
        self.idle: dict[str, Verdict] = {}
        """Verdicts on engines that were compared on no scene, though they should have been"""
        self.rows: dict[tuple[str, str], list[Row]] = {}
        """Rows of each scene and engine"""
        self.judging: list[Job] = []
        """Runs of judging solutions that are to be made"""
        self.judged_runs = 0
        self.lightest: dict[str, tuple[float, str]] = {}
        """Least work of each engine in a scene, and the scene"""
        self.finished: set[str] = set()
        """Engines of which a run has ended in time"""
        self.late: dict[str, dict[str, None]] = defaultdict(dict)
        """Scenes in which a run of an engine was ended at the time limit"""
        self.start = time.perf_counter()

    def run(self) -> dict[tuple[str, str], Verdict]:
        """Make all runs and judge them; verdicts by (scene, engine)."""
        self.store.write("metrics", self.metrics())  # from here on the folder holds this comparison
        self.ask_outside_engines()
        cases = [case for progress in self.progress.values() for case in self.cases(progress)]
        for text in beforehand(self.judging):
            self.note(text)
        for (scene, engine), verdict in run_cases(cases, self.comparison.executor):
            if verdict is not None:
                self.settle(scene, engine, verdict)
        self.settle_required()
        found = {(name, e): v for name, p in self.progress.items() for e, v in p.verdicts.items()}
        return found | {(ALL_SCENES, e): v for e, v in self.idle.items()}

    def ask_outside_engines(self) -> None:
        """Ask engines of other packages about all scenes at once; a failure is told with each scene."""
        for registration in self.comparison.engines.values():
            with contextlib.suppress(EngineError):
                if not registration.missing:
                    ask_about(declarations_of(registration), (p.scene for p in self.progress.values()))

    def cases(self, progress: SceneProgress) -> Iterator[tuple[tuple[str, str], Case[Verdict | None]]]:
        """Cases of a scene; engines that do not support it get their verdict at once.

        A scene that no engine supports needs no solution.
        """
        name, supporting = progress.scene.name, []
        for engine, registration in self.comparison.engines.items():
            out = cannot(progress.scene, engine, registration)
            if out is None:
                self.declared[engine] = declarations_of(registration)
                supporting.append(engine)
            else:
                self.settle(name, engine, no_verdict(name, engine, None, out.outcome, out.reason))
        if not supporting:
            return
        shipped = self.shipped(progress)
        solution = Shared(self.solution(progress)) if shipped is None else Known(shipped)
        for engine in supporting:
            setting = self.comparison.setting(engine, self.declared[engine], progress.scene, shipped)
            job = Job(progress.scene, engine, self.comparison.engines[engine], setting, Role.MAIN)
            least = expected_work(job), name
            self.lightest[engine] = min(self.lightest.get(engine, least), least)
            yield (name, engine), self.pair(progress, engine, setting, solution)

    def shipped(self, progress: SceneProgress) -> ReferenceSolution | None:
        """Certified solution that comes with barchain; None where a solution has to be made, of a chosen kind."""
        found = shipped_solution(progress.scene)
        if found is not None:
            progress.source = SolutionSource.SHIPPED
            self.establish(progress, found)
            return found
        if self.comparison.certify:
            reason = why_not_certified(progress.scene)
            progress.source = SolutionSource.REFERENCE if reason else SolutionSource.HEYOKA
            if reason:
                self.note(f"{progress.scene.name}: no certified solution ({reason}); the reference judges")
        self.judging += judging_jobs(progress.scene, progress.source)
        return None

    def solution(self, progress: SceneProgress) -> Case[ReferenceSolution | None]:
        """Solution that judges a scene; None where it can't be had, which the scene's own row tells."""
        scene = progress.scene
        try:
            solution = yield from solution_case(scene, self.run_of, progress.source)
        except SolutionFailedError as error:
            if progress.source is SolutionSource.HEYOKA:
                self.note(f"{scene.name}: no certified solution ({error}); the reference judges")
                progress.source = SolutionSource.REFERENCE
                return (yield from self.solution(progress))
            progress.solution_failed = f"the judging solution could not be run ({error})"
            verdict = no_verdict(scene.name, JUDGING_SOLUTION, None, Outcome.FAILED, progress.solution_failed)
            self.settle(scene.name, JUDGING_SOLUTION, verdict)
            return None
        self.establish(progress, solution)
        return solution

    def establish(self, progress: SceneProgress, solution: ReferenceSolution) -> None:
        """Store the solution that judges a scene, with its error amplification."""
        name = progress.scene.name
        progress.unpredictable = beyond_any_setting(solution)
        if progress.unpredictable:
            self.note(f"{name}: {progress.unpredictable}")
        shared = [e for e, r in self.comparison.engines.items() if shares_equations(r, solution.source)]
        self.store.record["scenes"][name] |= solution_facts(solution) | {"same_equations": shared}
        t = solution.trajectory.t_s[: len(solution.amplification)]
        grown = pd.DataFrame({"t_s": t, "amplification": solution.amplification})
        self.store.write_series(f"differences/{name}/amplification", grown)
        if solution.source.certified:  # no run of its own has these samples
            samples = solution.trajectory.of_run(solution.scene).to_frame()
            self.store.write_series(f"trajectories/{name}/{Role.SOLUTION}", samples)

    def run_of(self, job: Job) -> Task:
        """Run to be made; it is kept as soon as it is there.

        An engine's run in its lightest scene comes first: if that one is late, the others will be.
        """
        first = job.role is Role.MAIN and self.lightest.get(job.engine, (0.0, ""))[1] == job.scene.name
        return run_task(
            job, limit_of(job, self.comparison.time_limit_s), kept=lambda result: self.kept(job, result),
            first=first, instead=lambda: self.given_up(job),
        )  # fmt: skip

    def given_up(self, job: Job) -> RunResult | None:
        """Result of a run that is not made, as the engine hangs: late in several scenes, and in time in none."""
        late = [scene for scene in self.late[job.engine] if scene != job.scene.name]
        if job.role in JUDGING_ROLES or job.engine in self.finished or len(late) < SEVERAL:
            return None
        said = f"not tried: it was late in {' and in '.join(late[:SEVERAL])}, and in time in no scene"
        return failure(Outcome.TIMED_OUT, said)

    def kept(self, job: Job, result: RunResult) -> None:
        """Keep a run, and tell of the progress before the first verdict."""
        keep_run(self.store, job, result)
        if job.role not in JUDGING_ROLES:
            if result.outcome is Outcome.TIMED_OUT:
                self.late[job.engine][job.scene.name] = None
            else:
                self.finished.add(job.engine)
        self.store.record["seconds"] = time.perf_counter() - self.start
        if job in self.judging:
            self.judged_runs += 1
            self.note(f"run {self.judged_runs} of {len(self.judging)} of judging solutions: {job.scene.name}")

    def pair(
        self, progress: SceneProgress, engine: str, setting: Setting, solution: Shared | Known
    ) -> Case[Verdict | None]:
        """Verdict on an engine in a scene; None where no solution judges the scene."""
        scene, loaded = progress.scene, self.declared[engine]
        if isinstance(solution, Known):
            with contextlib.suppress(Exception):  # of the engine: told after the runs
                if refused := self.refused(progress, engine, setting, solution.value):
                    return refused
        finer = finer_setting(scene, loaded.sweep, setting)
        wanted = {Role.MAIN: setting, Role.FINER: finer}
        jobs = [Job(scene, engine, self.comparison.engines[engine], each, role) for role, each in wanted.items()]
        *found, known = yield [*map(self.run_of, jobs), solution]
        made = [advised(job, run) for job, run in zip(jobs, found, strict=True)]
        if known is None:
            return None
        try:
            verdict: Verdict | None = self.refused(progress, engine, setting, known)
            if verdict is None:
                verdict = yield from self.verdict(engine, setting, dict(zip(wanted, made, strict=True)), known)
        except Exception as error:  # values or claims of the engine that no check foresees, or late judging
            said = f"no verdict: {error if isinstance(error, EngineError) else f'{type(error).__name__}: {error}'}"
            outcome = Outcome.NOTHING_COMPARED if isinstance(error, CallLateError) else Outcome.FAILED
            return no_verdict(scene.name, engine, setting, outcome, plain_text(said))
        main = made[0].trajectory
        if main is None or not needs_diagnosis(verdict):
            return verdict
        registration = self.comparison.engines[engine]
        dense = densely(scene, main) if thinned(len(main.t_s)) == 1 else ()
        again = [Job(d, engine, registration, s, role) for d, (role, s) in zip(dense, wanted.items(), strict=False)]
        own = yield [run_task(job, limit_of(job, self.comparison.time_limit_s)) for job in again]
        runs = MadeRuns(*(run.trajectory for run in own)) if own else None
        (diagnosed,) = yield [verdict_task(diagnosed_verdict, verdict, main, known, runs)]
        return diagnosed if isinstance(diagnosed, Verdict) else verdict  # which stands without its diagnosis

    def refused(
        self, progress: SceneProgress, engine: str, setting: Setting, solution: ReferenceSolution
    ) -> Verdict | None:
        """Verdict that needs no run, where the motion is unsupported or no setting predicts a sample; None else."""
        name, loaded = progress.scene.name, self.declared[engine]
        reason = loaded.unsupported_motion(progress.scene, solution.fine)
        if reason is not None:
            return no_verdict(name, engine, setting, Outcome.UNSUPPORTED, reason)
        if progress.unpredictable and Observable.ATTITUDE in loaded.observables:
            return no_verdict(name, engine, setting, Outcome.TOO_COARSE, progress.unpredictable)
        return None

    def verdict(
        self, engine: str, setting: Setting, runs: dict[Role, RunResult], solution: ReferenceSolution
    ) -> Case[Verdict]:
        """Verdict on an engine's runs, and on the further runs that it requests."""
        scene, loaded = solution.scene, self.declared[engine]
        found: Verdict = yield from verdict_case(engine, loaded, setting, gathered(runs), solution)
        if found.further_runs:
            registration = self.comparison.engines[engine]
            jobs = follow_up_jobs(scene, engine, registration, loaded, setting, found.further_runs)
            self.note(f"{scene.name}, {engine}: further runs tell round-off and slow convergence from wrong physics")
            more = yield list(map(self.run_of, jobs))
            runs |= dict(zip((job.role for job in jobs), more, strict=True))
            found = yield from verdict_case(engine, loaded, setting, gathered(runs), solution)
        if finer := finer_words(scene, setting):  # an error above the bound, as unstable steps leave, is told with it
            far = Outcome.EXCEEDS_BOUND
            rows = [r | {"reason": f"{r['reason']}; {finer}"} if r["outcome"] == far else r for r in found.rows]
            found = dataclasses.replace(found, rows=rows)
        return found

    def settle(self, scene: str, engine: str, verdict: Verdict) -> None:
        """Store a verdict and report it."""
        self.progress[scene].verdicts[engine] = verdict
        if verdict.series is not None:
            self.store.write_series(f"differences/{scene}/{engine}", verdict.series)
        self.keep_rows(scene, engine, verdict)

    def keep_rows(self, scene: str, engine: str, verdict: Verdict) -> None:
        """Write the table of all rows so far, and report the verdict."""
        self.rows[scene, engine] = verdict.rows
        self.store.write("metrics", self.metrics())
        self.report(scene, engine, verdict.outcome)

    def metrics(self) -> list[dict[str, Any]]:
        """All rows so far, in the order of the scenes and engines; those of all scenes come last."""
        names = (JUDGING_SOLUTION, *self.comparison.engines, ANY_INDEPENDENT)
        order = [(scene, engine) for scene in self.progress for engine in names]
        pairs = [*(pair for pair in order if pair in self.rows), *(pair for pair in self.rows if pair not in order)]
        return [row for pair in pairs for row in self.rows[pair]]

    def settle_required(self) -> None:
        """Settle pairs, scenes and engines that lack a required verdict."""
        for name, engine, verdict in required_verdicts(self.comparison, self.progress):
            if name == ALL_SCENES:
                self.idle[engine] = verdict
                self.keep_rows(name, engine, verdict)
            else:
                self.settle(name, engine, verdict)


def beforehand(jobs: list[Job]) -> list[str]:
    """Announcement of the runs that give no verdict yet; none without such runs."""
    first = [job for job in jobs if job.role in JUDGING_ROLES]
    scenes = len({job.scene.name for job in first})
    of = "a scene" if scenes == 1 else f"{scenes} scenes"
    return [f"solution that judges {of} first: {len(first)} runs"] if first else []


def solution_facts(solution: ReferenceSolution) -> dict[str, Any]:
    """Entry of the record on the solution that judges a scene."""
    displacement = com_displacement(solution.scene, solution.trajectory)
    inside = solution.trajectory.t_s[: len(solution.amplification)] <= solution.limit_s
    return {
        "solution_source": WORDS[solution.source],
        "solution_engine": CERTIFIER if solution.source.certified else judging_engine(solution.scene),
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


def advised(job: Job, run: RunResult) -> RunResult:
    """Run whose reason, where it failed, tells the setting with which it may not."""
    advice = setting_advice(job.scene, job.setting, run.outcome)
    return dataclasses.replace(run, reason=f"{run.reason or run.outcome.advice}; {advice}") if advice else run
