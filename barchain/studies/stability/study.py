"""The stability study: every engine in every hard scene at three settings, judged and compared with the record.

Cases make the runs: each result leads to the next setting, and the last one to an outcome.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.engine import EngineError
from barchain.record.scene_description import scene_words
from barchain.runs.asking import declarations_of
from barchain.runs.cases import Case, Known, Shared, Task, run_cases
from barchain.runs.choices import engine_facts, unique_names
from barchain.runs.estimate import need_runnable
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import JUDGING_ROLES, Job, Role, RunResult, TimeLimit, failure
from barchain.runs.left_out import cannot
from barchain.runs.run import keep_run
from barchain.runs.tasks import run_task
from barchain.solutions.judging import SolutionFailedError, judging_engine, solution_case, solution_jobs
from barchain.solutions.reference import SOLUTION_RTOL, ReferenceSolution
from barchain.studies.defaults import STABILITY_LIMIT_S
from barchain.studies.stability.evidence import condition_range, evidence, laws, plain_row
from barchain.studies.stability.plan import (
    LONG,
    SOLUTION_LIMIT_S,
    OutcomeChange,
    change,
    chosen_engines,
    exact_jobs,
    hard_scenes,
    left_to_a_full_study,
    recorded,
    settings,
)
from barchain.studies.stability.rules import (
    ILL_POSED,
    LEVEL_WORDS,
    LEVELS,
    WITH_TRAJECTORY,
    EngineRuns,
    Finding,
    finding,
    judged_evidence,
    linear_rate,
)
from barchain.studies.verdict_tasks import verdict_case
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN
from reports.results.stability import FILES, Stability
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from adapters.registry import Registration
    from adapters.trajectory import Trajectory
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles
    from scenarios import Scene

REFERENCES = ("reference", "reference-fast")
"""Engines that must be stable in all scenes that are well-posed"""
REFERENCE_PATIENCE = 10.0
"""Times the time limit that these are given: they are to be judged, and NumPy takes minutes for a thousand orbits"""
MOST_BARS_KEPT = 2000  # a table has six columns a bar, and takes minutes to write beyond
OF_SCENE = ""
"""In place of an engine: the case of the scene itself"""

Pair = tuple[str, str]
CaseRows = dict[str, list[dict[str, Any]]]
"""Rows by table"""
CaseEnd = tuple[Finding | None, CaseRows]


@dataclass(frozen=True)
class StabilityResult:
    """Result of a study."""

    findings: dict[Pair, Finding]
    changes: tuple[OutcomeChange, ...]
    ours: tuple[Pair, ...]
    """Scenes that are well-posed, and in which a form of the reference is not stable"""
    failures: tuple[str, ...] = ()
    """Engines that do not load, one line each"""

    @property
    def passed(self) -> bool:
        """Whether every engine loads, the reference is stable and no outcome changed."""
        return not self.ours and not self.changes and not self.failures


@dataclass(frozen=True)
class StabilityStudy:
    """Scenes, engines and limits."""

    scenes: tuple[Scene, ...]
    engines: dict[str, Registration]
    time_limit_s: float = STABILITY_LIMIT_S
    """Wall time of one run; a form of the reference gets ten times as much"""
    executor: Executor = ALL_CORES
    left_out: frozenset[Pair] = frozenset()
    """Scenes and engines that the default study leaves to a full one"""
    files: ClassVar[StudyFiles] = FILES

    def engines_of(self, scene: Scene) -> dict[str, Registration]:
        """Engines that take part in a scene."""
        return {name: r for name, r in self.engines.items() if (scene.name, name) not in self.left_out}

    @property
    def turns(self) -> int:
        """Number of runs, for the progress."""
        able = [(s, name, r) for s in self.scenes for name, r in self.engines_of(s).items() if not cannot(s, name, r)]
        solutions = sum(len(solution_jobs(s)) + len(exact_jobs(s)) for s in self.scenes)
        return solutions + sum(len(settings(s, name, declarations_of(r))) for s, name, r in able)

    def record(self) -> dict[str, Any]:
        """Scenes, engines and limits; runs are added as they come."""
        return {
            "time_limit_s": self.time_limit_s,
            "scenes": {s.name: scene_facts(s) for s in self.scenes},
            "engines": {name: engine_facts(r).get("title", "") for name, r in self.engines.items()},
            "references": [name for name in REFERENCES if name in self.engines],
            "left_out": sorted([scene, name] for scene, name in self.left_out),
            "runs": [],
        }

    def run(self, store: StudyStore, reporter: Reporter) -> StabilityResult:
        """Make all runs, and judge each engine in each scene."""
        return StabilityRun(self, store, reporter).run()


def stability_study(
    scenes: Sequence[str | Path] = (), engines: Sequence[str] = (), *, full: bool = False, **how: Any
) -> StabilityStudy:
    """Stability study of scenes by name or file, those of ``hard/`` by default, but none tagged ``huge``.

    By default the engines are those of the default set and SciPy's solvers; a full study takes pairs that take minutes
    too, and SciPy's solvers also on rates in NumPy. Further arguments are fields of the study.

    Raises
    ------
    SceneError, UnknownEngineError
        For a scene or an engine that does not exist.
    ClusterError
        For a Dask cluster that can't be used.
    """
    loaded = unique_names([load_scene(s) for s in scenes or hard_scenes()])
    chosen = chosen_engines(engines, full=full)
    left = frozenset() if full or engines else left_to_a_full_study(loaded, chosen)
    study = StabilityStudy(tuple(loaded), chosen, left_out=left, **how)
    need_runnable(loaded, study.time_limit_s)
    study.executor.check()
    return study


class StabilityRun:
    """One study: a case for each pair of scene and engine, one for each scene, and one for its reference solution."""

    def __init__(self, study: StabilityStudy, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets scene, engine and outcome after each run."""
        self.study, self.store, self.report, self.note = study, store, reporter.step, reporter.note
        self.rows: dict[Pair, CaseRows] = {
            (scene.name, name): {} for scene in study.scenes for name in (*study.engines, OF_SCENE)
        }
        """Rows of each case, in the order of the tables"""
        self.faults: dict[str, str] = {}
        self.recorded = recorded()
        self.findings: dict[Pair, Finding] = {}
        self.changes: list[OutcomeChange] = []

    def run(self) -> StabilityResult:
        """Make all runs, and judge each engine in each scene as soon as its last one is there."""
        cases = [case for scene in self.study.scenes for case in self.cases(scene)]
        for pair, (found, rows) in run_cases(cases, self.study.executor):
            self.keep(pair, found, rows)
        failures = tuple(f"{name}: {fault}" for name, fault in self.faults.items())
        return StabilityResult(self.findings, tuple(self.changes), self.unstable_references(), failures)

    def cases(self, scene: Scene) -> Iterator[tuple[Pair, Case[CaseEnd]]]:
        """Cases of a scene; an engine that does not support it, or does not load, is settled at once."""
        solution = Shared(self.solution(scene))
        yield (scene.name, OF_SCENE), self.of_scene(scene, solution)
        for name, registration in self.study.engines_of(scene).items():
            out = cannot(scene, name, registration)
            if out is None:
                yield (scene.name, name), self.pair(scene, name, solution)
                continue
            supported = out.outcome is not Outcome.UNSUPPORTED
            if supported:
                self.faults[name] = out.reason
            found = Finding(Stability.FAILED if supported else Stability.UNSUPPORTED, out.reason)
            self.keep((scene.name, name), found, {})

    def solution(self, scene: Scene) -> Case[ReferenceSolution | None]:
        """Reference solution of a scene; None where it can't be had."""
        facts = self.store.record["scenes"][scene.name]
        try:
            solution = yield from solution_case(scene, self.run_of)
        except SolutionFailedError as error:
            facts["solution_failed"] = str(error)
            self.note(f"{scene.name} has no reference solution: {error}")
            return None
        facts |= solution_facts(solution)
        self.store.write_record()
        return solution

    def of_scene(self, scene: Scene, solution: Shared) -> Case[CaseEnd]:
        """Laws of the reference solution and of the run with compensated sums."""
        exact = exact_jobs(scene)
        known, *made = yield [solution, *map(self.run_of, exact)]
        rows: CaseRows = {}
        if known is not None:
            job = next(j for j in solution_jobs(scene) if j.role is Role.SOLUTION)
            add_laws(rows, job, known.trajectory, known)
        for job, result in zip(exact, made, strict=True):
            add_laws(rows, job, with_samples(result), known)
        return None, rows

    def pair(self, scene: Scene, engine: str, solution: Shared) -> Case[CaseEnd]:
        """Runs of an engine in a scene, the coarsest setting first, and the outcome."""
        registration = self.study.engines[engine]
        own = declarations_of(registration)
        wanted = settings(scene, engine, own)
        jobs = {role: Job(scene, engine, registration, each, role) for role, each in wanted.items()}
        coarsest, *finer = (role for role in LEVELS if role in jobs)
        runs: dict[Role, RunResult] = {}
        skipped: set[Role] = set()
        for roles in ([coarsest, *jobs.keys() - set(LEVELS)], *([role] for role in finer)):
            timed_out = (r for r, result in runs.items() if r in LEVELS and result.outcome is Outcome.TIMED_OUT)
            late = next(timed_out, None)
            skipped |= set(roles) if late is not None else set()
            made = yield [self.run_of(jobs[role]) if late is None else self.not_run(jobs[role], late) for role in roles]
            runs |= dict(zip(roles, made, strict=True))
        (known,) = yield [solution]
        engine_runs = EngineRuns(scene, engine, own, wanted, runs, known, frozenset(skipped))
        try:
            verdicts = {}
            for role, runs_of_level in judged_evidence(runs).items() if known is not None else ():
                verdicts[role] = yield from verdict_case(engine, own, wanted[role], runs_of_level, known)
            engine_runs = replace(engine_runs, verdicts=verdicts)
            reason = None if known is None else own.unsupported_motion(known.scene, known.fine)
            found = finding(engine_runs) if reason is None else Finding(Stability.UNSUPPORTED, reason)
        except EngineError as error:  # an engine of another package without an answer, or no verdict
            found = Finding(Stability.FAILED, str(error))
        plain = plain_row(engine_runs)
        rows: CaseRows = {"evidence": evidence(engine_runs), "plain": [] if plain is None else [plain]}
        for role in (Role.MAIN, Role.FINER):
            add_laws(rows, jobs[role], with_samples(runs[role]), known)
        return found, rows

    def run_of(self, job: Job) -> Task:
        """Run to be made; it is noted as soon as it is there."""
        return run_task(job, TimeLimit(self.limit_s(job)), kept=lambda result: self.noted(job, result))

    def not_run(self, job: Job, late: Role) -> Known:
        """Result of a run that is not made: a coarser one was late."""
        said = f"{NOT_RUN}: the {LEVEL_WORDS[late]} setting already took longer than {self.limit_s(job):g} s"
        result = failure(Outcome.TIMED_OUT, said)
        self.noted(job, result)
        return Known(result)

    def limit_s(self, job: Job) -> float:
        """Wall time allowed to a run."""
        if job.role in JUDGING_ROLES:
            return SOLUTION_LIMIT_S
        return self.study.time_limit_s * (REFERENCE_PATIENCE if job.engine in REFERENCES else 1.0)

    def noted(self, job: Job, result: RunResult) -> None:
        """Write a run's samples, but none of very many bars, note it in the record, and tell of it."""
        said = "pass" if result.outcome is Outcome.PASS else f"{job.setting} {result.outcome}: {result.reason}"
        if job.scene.bars > MOST_BARS_KEPT:
            result = replace(result, trajectory=None)
        keep_run(self.store, job, result)
        self.report(job.scene.name, job.engine, said)

    def keep(self, pair: Pair, found: Finding | None, rows: CaseRows) -> None:
        """Write the rows of a case, and see whether its outcome is the one recorded."""
        if found is not None:
            before = self.recorded.get(pair)
            changed = change(*pair, before, found)
            self.findings[pair] = found
            if changed:
                self.changes.append(changed)
            law = found.law
            rows["outcomes"] = [{
                "scene": pair[0],
                "engine": pair[1],
                "stability": str(found.stability),
                "slow": found.slow,
                "reason": found.reason,
                "quantity": found.quantity,
                "exponent": law and law.exponent,
                "low": law and law.low,
                "high": law and law.high,
                "at_end": law and law.at_end,
                "expected": before or "",
                "change": changed.direction if changed else "",
            }]  # fmt: skip
        self.rows[pair] = rows
        for table in (name for name, own in rows.items() if own):
            self.store.write(table, [row for case in self.rows.values() for row in case.get(table, ())])

    def unstable_references(self) -> tuple[Pair, ...]:
        """Well-posed scenes in which the reference is not stable; time-outs of a slow machine are left out."""
        posed = {s.name for s in self.study.scenes if ILL_POSED not in s.tags}
        return tuple(
            (scene, engine)
            for (scene, engine), found in self.findings.items()
            if engine in REFERENCES and scene in posed and not found.slow and found.stability is not Stability.STABLE
        )


def with_samples(result: RunResult) -> Trajectory | None:
    """Finite samples of a run, if there are any."""
    return result.trajectory if result.outcome in WITH_TRAJECTORY else None


def add_laws(rows: CaseRows, job: Job, trajectory: Trajectory | None, solution: ReferenceSolution | None) -> None:
    """Add how a run's drifts grow, in a scene that is followed over time."""
    if LONG not in job.scene.tags or trajectory is None:
        return
    fitted, series = laws(job.scene, job.engine, LEVEL_WORDS[job.role], job.setting, trajectory, solution)
    rows["laws"] = rows.get("laws", []) + fitted
    rows["long"] = rows.get("long", []) + [{str(k): v for k, v in row.items()} for row in series.to_dict("records")]


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


def scene_facts(scene: Scene) -> dict[str, Any]:
    """Entry of a scene in the record."""
    more = {"description": scene.description.strip(), "tags": list(scene.tags), "period_s": scene.period_s}
    return scene_words(scene) | more
