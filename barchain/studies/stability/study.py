"""The stability study: every engine in every hard scene at three settings, judged and compared with the record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from barchain.runs.executors import ALL_CORES
from barchain.runs.facts import engine_facts
from barchain.runs.selection import unique_names
from barchain.runs.timing.estimate import need_runnable
from barchain.studies.stability.left_out import left_to_a_full_study
from barchain.studies.stability.limits import TIME_LIMIT_S
from barchain.studies.stability.plan import StabilityPlan, chosen_engines, hard_scenes
from barchain.studies.stability.run import REFERENCES, StabilityResult, StabilityRun
from reports.tables.stability import FILES
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles
    from scenarios import Scene


@dataclass(frozen=True)
class StabilityOptions:
    """Options of a stability study."""

    scenes: Sequence[str | Path] = ()
    """Names or files; all of ``hard/`` by default, except scenes tagged ``huge``"""
    engines: Sequence[str] = ()
    """The engines of the default set and SciPy's solvers by default"""
    time_limit_s: float = TIME_LIMIT_S
    """Wall time of one run; a form of the reference gets ten times as much"""
    executor: Executor = ALL_CORES
    """Place of the runs; all cores of this machine by default"""
    full: bool = False
    """Pairs that take minutes too, and SciPy's solvers also on rates in NumPy"""


@dataclass(frozen=True)
class StabilityStudy:
    """The stability study."""

    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: StabilityOptions) -> StabilityPlan:
        """Scenes, engines and limits.

        Raises
        ------
        SceneError, UnknownEngineError
            For a scene or an engine that does not exist.
        ClusterError
            For a Dask cluster that can't be used.
        """
        scenes = unique_names([load_scene(s) for s in options.scenes or hard_scenes()])
        need_runnable(scenes, options.time_limit_s)
        chosen = chosen_engines(options.engines, full=options.full)
        whole = options.full or bool(options.engines)
        left = frozenset() if whole else left_to_a_full_study(scenes, chosen)
        options.executor.check()
        return StabilityPlan(tuple(scenes), chosen, options.time_limit_s, options.executor, left)

    def record(self, plan: StabilityPlan) -> dict[str, Any]:
        """Scenes, engines and limits; runs are added as they come."""
        return {
            "time_limit_s": plan.time_limit_s,
            "scenes": {s.name: scene_words(s) for s in plan.scenes},
            "engines": {name: engine_facts(r).get("title", "") for name, r in plan.engines.items()},
            "references": [name for name in REFERENCES if name in plan.engines],
            "left_out": sorted([scene, name] for scene, name in plan.left_out),
            "runs": [],
        }

    def run(self, plan: StabilityPlan, store: StudyStore, reporter: Reporter) -> StabilityResult:
        """Make all runs, and judge each engine in each scene."""
        return StabilityRun(plan, store, reporter).run()


def scene_words(scene: Scene) -> dict[str, Any]:
    """Entry of a scene in the record."""
    return {
        "title": scene.title,
        "description": scene.description.strip(),
        "tags": list(scene.tags),
        "bars": scene.bars,
        "duration_s": scene.run.duration_s,
        "period_s": scene.period_s,
        "samples": scene.run.samples,
    }
