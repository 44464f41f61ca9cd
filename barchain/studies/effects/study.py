"""The effects study: size, influence and cost of each effect of a scene.

The scene and the scenes with an effect switched run side by side, each at two tolerances. The runs of the scene as it
is come first: they tell the heights for which default effects are taken. Then the good runs are timed in turn.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.record.scene_description import scene_words
from barchain.runs.cases import run_cases
from barchain.runs.estimate import need_runnable
from barchain.runs.executors import ALL_CORES, KeptAnswers
from barchain.runs.job import Job, Role
from barchain.runs.other_settings import compiled_can
from barchain.runs.tasks import limit_of, run_task
from barchain.studies.defaults import EFFECTS, FAST, MATTERS, RTOL, SLOW
from barchain.studies.effects.default_air import heights_of
from barchain.studies.effects.sizes import LOOSER, RunPair, change, scales, sizes_over
from barchain.studies.effects.switches import Switch, switches
from barchain.studies.effects.timing import (
    LEAST_ROUNDS,
    Timed,
    price_columns,
    shortened,
    timed_rounds,
    timed_span_s,
)
from barchain.studies.study import StudyEnd
from reports.results.comparison import PARTED_RAD
from reports.results.effects import CHANGED, FILES
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.runs.cases import Case, Task
    from barchain.runs.executors import Executor
    from barchain.runs.job import RunResult
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles
    from scenarios import Scene


@dataclass(frozen=True)
class EffectsStudy:
    """A scene, the effects that are switched in it, and the runs that follow."""

    scene: Scene
    rtol: float = RTOL
    """Accuracy of a step of the tighter run"""
    matters: float = MATTERS
    """Change from which an effect is relevant: see :mod:`reports.chapters.effects`"""
    repeats: int = EFFECTS.repeats
    """Rounds of timing"""
    seconds: float = 60.0 * EFFECTS.minutes
    """Time after which no further round of timing is begun"""
    executor: Executor = ALL_CORES
    """Place of the runs that are not timed; all cores of this machine by default"""
    engine: str | None = None
    """Form of the reference for all runs; by default the compiled one where it supports them"""
    width_m: float | None = None
    """Of every bar, for drag and sunlight that the scene does not have; by default the scene's own, if it has one"""
    switches: tuple[Switch, ...] = ()
    files: ClassVar[StudyFiles] = FILES

    @property
    def turns(self) -> int:
        """Number of steps to be reported."""
        return len(self.runs) + self.repeats

    @property
    def runs(self) -> tuple[Job, ...]:
        """All runs, each once: every pair of scenes in the engine that can do both, at both tolerances."""
        return tuple({job.key: job for job in (*self.tight, *map(self.looser, self.tight))}.values())

    @property
    def whole(self) -> tuple[Job, ...]:
        """Runs of the scene as it is, the tighter first."""
        own = self.job(self.scene, self.engine_for(self.scene))
        return own, self.looser(own)

    @property
    def tight(self) -> tuple[Job, ...]:
        """Runs at the tolerance asked for, each once; the scene as it is comes first."""
        pairs = [self.pair(s) for s in self.switches if s.scene]
        return tuple({job.key: job for job in (self.whole[0], *(j for pair in pairs for j in pair))}.values())

    def pair(self, switch: Switch) -> tuple[Job, Job]:
        """Runs of the scene and of the switched one, in one engine."""
        assert switch.scene is not None
        engine = self.engine_for(self.scene, switch.scene)
        return self.job(self.scene, engine), self.job(switch.scene, engine)

    def engine_for(self, *scenes: Scene) -> str:
        """Name of the reference that supports all of these scenes."""
        return self.engine or (FAST if compiled_can(scenes) else SLOW)

    def job(self, scene: Scene, engine: str) -> Job:
        """Run at the tolerance asked for."""
        return Job(scene, engine, ENGINES[engine], Setting(AccuracyParameter.RTOL, self.rtol), Role.MAIN)

    def looser(self, job: Job) -> Job:
        """Repeat a run at the looser tolerance, for its numerical error."""
        return dataclasses.replace(job, setting=Setting(AccuracyParameter.RTOL, LOOSER * self.rtol))

    def record(self) -> dict[str, Any]:
        """Scene with the units in which the advice measures changes, and the limits of the advice."""
        scene = self.scene
        units = {
            "name": scene.name,
            "gravity": str(scene.effects.gravity),
            "bound": scene.bound,
            "period_s": scene.period_s,
            "radius0_m": scene.radius0_m,
        }
        return {
            "scene": scene_words(scene) | units,
            "rtol": self.rtol,
            "looser": LOOSER,
            "parted_rad": PARTED_RAD,
            "matters": self.matters,
            "width_m": self.width_m,
        }

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Run the scene with each effect switched, then time the runs; the table is written after both."""
        budget = Budget(self, reporter)
        assert isinstance(self.executor, KeptAnswers)
        try:
            for case, place in ((budget.runs(), self.executor), (budget.timed(store), self.executor.one_by_one())):
                list(run_cases([(self.scene.name, case)], place))
                budget.write(store)
        finally:
            budget.write(store)
        return StudyEnd(budget.failures())


class WidthError(ValueError):
    """Raised for a width that no scene allows; the message gives the widths that it does."""


def effects_study(scene: Scene, **options: Any) -> EffectsStudy:
    """Study of all effects of a scene, present or absent there; options are the fields of the study.

    Raises
    ------
    ClusterError
        For a Dask cluster that can't be used.
    WidthError
        For a width beyond a bar's length, which no scene allows.
    """
    study = EffectsStudy(scene, **options)
    need_runnable([scene])
    shortest_m = min(scene.chain.length_m)
    if study.width_m is not None and study.width_m > shortest_m:
        raise WidthError(f"{study.width_m:g} m given, allowed: at most the shortest bar's length, {shortest_m:g} m")
    study.executor.check()
    return dataclasses.replace(study, switches=switches(scene, width_m=study.width_m))


@dataclass
class Budget:
    """Runs and times of the effects of a scene, as they come, and the rows that follow from them."""

    study: EffectsStudy
    reporter: Reporter
    results: dict[str, RunResult] = field(default_factory=dict)
    """By the key of the job"""
    times: dict[str, Timed] = field(default_factory=dict)

    def runs(self) -> Case[None]:
        """All runs: of the scene as it is, and of those that follow from the heights that it came to."""
        whole, _ = yield list(map(self.run_of, self.study.whole))
        if whole.outcome is Outcome.PASS and whole.trajectory is not None:
            heights = heights_of(self.study.scene, whole.trajectory)
            found = switches(self.study.scene, heights, self.study.width_m)
            self.study = dataclasses.replace(self.study, switches=found)
        yield [self.run_of(job) for job in self.study.runs if job.key not in self.results]

    def run_of(self, job: Job) -> Task:
        """Run to be made; it is reported as soon as it is there."""

        def kept(result: RunResult) -> None:
            self.results[job.key] = result
            self.reporter.step(self.study.scene.name, self.said(job), str(result.outcome))

        return run_task(job, limit_of(job, EFFECTS.time_limit_s), kept=kept)

    def timed(self, store: StudyStore) -> Case[None]:
        """Time the good runs, shortened where three rounds would take too long, and single evaluations."""
        study, note = self.study, self.reporter.note
        good = [j for j in study.tight if self.results[j.key].outcome is Outcome.PASS]
        pass_s = sum(self.results[j.key].seconds["simulate"] for j in good)
        span_s = timed_span_s(study.scene, pass_s, study.seconds, min(LEAST_ROUNDS, study.repeats))
        part = "" if span_s >= study.scene.run.duration_s else f", the first {span_s:.4g} s of each"
        note(
            f"timing {len(good)} runs in turn{part}: each once to get warm, then in rounds, then one evaluation of each"
        )
        timed = yield from timed_rounds(
            [shortened(j, span_s) for j in good], repeats=study.repeats, seconds=study.seconds,
            time_limit_s=EFFECTS.time_limit_s,
            told=lambda turn: self.reporter.step(study.scene.name, f"round {turn}", "pass"),
        )  # fmt: skip
        self.times = {job.key: found for job, found in zip(good, timed, strict=True)}
        rounds = max((len(t.seconds) for t in timed), default=0)
        store.record |= {"rounds": rounds, "repeats": study.repeats, "timed_s": span_s}
        if rounds < study.repeats:
            note(
                f"{rounds} of {study.repeats} rounds of timing: the budget of {study.seconds:g} s is used up, "
                "--minutes allows more"
            )

    def write(self, store: StudyStore) -> None:
        """Write table and record as they stand."""
        whole = self.run_pair(self.study.tight[0])
        if whole:
            store.record["scene"] |= {
                "limit_s": whole.limit_s,
                "ended": whole.tight.ended,
                "end_s": float(whole.tight.t_s[-1]),
                "largest_reaction_N": scales(whole.tight, whole.limit_s).get("reaction"),
            }
        store.write("effects", map(self.row, self.study.switches))

    def failures(self) -> tuple[str, ...]:
        """Runs that failed, one line each; nothing is measured without the run of the scene as it is."""
        needed = {job.key for job in self.study.whole}
        runs = {job.key: job for job in (*self.study.whole, *self.study.runs)}
        ends = [(job, self.results[key]) for key, job in runs.items()]
        return tuple(
            f"{self.said(job)}: {end.outcome}: {end.reason}"
            for job, end in ends
            if not (end.outcome is Outcome.PASS or (end.outcome.ok and job.key not in needed))
        )

    def said(self, job: Job) -> str:
        """Run in words."""
        titles = (s.title for s in self.study.switches if s.scene and s.scene.digest == job.scene.digest)
        what = "as it is" if job.scene is self.study.scene else next(titles)
        return f"{what}, {job.engine} {job.setting}"

    def run_pair(self, job: Job) -> RunPair | None:
        """Trajectories of a run and of its looser run; None if either failed or is still to come."""
        found = [self.results.get(j.key) for j in (job, self.study.looser(job))]
        tight, loose = (r.trajectory if r and r.outcome is Outcome.PASS else None for r in found)
        return RunPair(tight, loose) if tight is not None and loose is not None else None

    def row(self, switch: Switch) -> dict[str, Any]:
        """One effect's row."""
        found: dict[str, Any] = {
            "effect": switch.effect, "title": switch.title, "kind": str(switch.kind), "on": switch.on,
            "said": switch.said, "reason": switch.reason, "caveat": switch.caveat,
            "width_least_m": min(switch.width_m, default=None), "width_largest_m": max(switch.width_m, default=None),
        }  # fmt: skip
        if switch.scene is None:
            return found
        own, other = self.study.pair(switch)
        found["engine"] = own.engine
        scene, switched = self.run_pair(own), self.run_pair(other)
        if scene is None or switched is None:
            reason = self.why_not(own, other)
            return found | ({"reason": reason} if reason else {"said": NOT_RUN})
        sizes = sizes_over(self.study.scene, switch, scene.tight)
        for when, of_all in zip(("start", "largest"), sizes or (), strict=bool(sizes)):
            found |= {f"{name}_{when}": value for name, value in of_all._asdict().items()}
        response = change(scene, switched)
        found |= {"compared_s": response.compared_s, "ended": switched.tight.ended}
        for channel in (c for c in CHANGED if c.name in response.largest):
            found[channel.column_of()] = response.largest[channel.name]
            found[channel.column_of("noise")] = response.noise[channel.name]
        present, absent = (own, other) if switch.on else (other, own)
        if {own.key, other.key} <= self.times.keys():
            found |= price_columns(self.times[present.key], self.times[absent.key])
        return found

    def why_not(self, *jobs: Job) -> str:
        """Outcomes and reasons of failed runs; empty while runs are still to come."""
        results = [(j, self.results.get(r.key)) for j in jobs for r in (j, self.study.looser(j))]
        said = [f"{self.said(j)}: {r.outcome}, {r.reason}" for j, r in results if r and r.outcome is not Outcome.PASS]
        return "; ".join(dict.fromkeys(said))
