"""The cost study: errors against the certified solution and times, for every setting of every engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.registry import engines
from barchain.runs.facts import engine_facts, external_versions, scene_words
from barchain.runs.selection import chosen_engines, unique_names
from barchain.runs.timing.estimate import need_runnable
from barchain.studies.cost.limits import MINUTES, REPEATS, TIME_LIMIT_S
from barchain.studies.cost.plan import CostPlan, kind_of, shortened
from barchain.studies.cost.run import CostResult, CostRun
from barchain.studies.study import limits_of
from reports.tables.cost import FILES
from scenarios import Scene, load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from barchain.record.study_store import StudyStore
    from barchain.studies.cost.points import BoundedSolution
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles

DEFAULT_SCENES = "paper/"


@dataclass(frozen=True)
class CostOptions:
    """Options of a cost study."""

    scenes: Iterable[Scene | str | Path] | None = None
    """The paper's by default"""
    engines: Iterable[str] | None = None
    """All registered engines by default, also those that only studies run"""
    orbits: float = 1.0
    """Part of each scene that is run, from its start"""
    repeats: int = REPEATS
    """Times that each point is measured, if the budget allows"""
    minutes: float = MINUTES
    """Budget, divided among the scenes; where it runs short, first repeats and then long runs are given up"""
    time_limit_s: float = TIME_LIMIT_S
    """Runs that are expected to take longer are skipped, with the reason in the table"""


@dataclass(frozen=True)
class CostStudy:
    """The cost study."""

    solution_of: Callable[[Scene], BoundedSolution] | None = None
    """Reference solution of a scene; the certified solution by default"""
    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: CostOptions) -> CostPlan:
        """Scenes cut to their first orbits, engines and limits.

        Raises
        ------
        SceneError, UnknownEngineError
            For a scene or an engine that does not exist.
        CertifiedSolutionError
            For a scene whose certified solution can't be had here.
        """
        names = [n for n in scene_names() if n.startswith(DEFAULT_SCENES)] if options.scenes is None else options.scenes
        loaded = unique_names([s if isinstance(s, Scene) else load_scene(s) for s in names])
        chosen = engines() if options.engines is None else chosen_engines(options.engines)
        scenes = [shortened(s, options.orbits) for s in loaded]
        need_runnable(scenes, options.time_limit_s)
        if self.solution_of is None:
            from barchain.solutions.certified import need_certifiable  # noqa: PLC0415  # as in certified_source

            for scene in scenes:
                need_certifiable(scene)
        named = frozenset(() if options.engines is None else chosen)
        return CostPlan(scenes, chosen, options.repeats, options.minutes, options.time_limit_s, named)

    def record(self, plan: CostPlan) -> dict[str, Any]:
        """Engines, scenes and limits."""
        return {
            "packages": external_versions(plan.engines),
            "engines": {name: engine_facts(r) | {"kind": kind_of(r)} for name, r in plan.engines.items()},
            "scenes": {s.name: scene_words(s) for s in plan.scenes},
            "certified_solutions": {},
            "left_out": [],
            "shortened_limits_s": {},
            "limits": limits_of(plan),
        }

    def run(self, plan: CostPlan, store: StudyStore, reporter: Reporter) -> CostResult:
        """Measure every point, round after round."""
        return CostRun(plan, store, self.solution_of or certified_source(), reporter).run()


def certified_source() -> Callable[[Scene], BoundedSolution]:
    """Certified solutions, whose engine is imported only when a study needs them."""
    from barchain.solutions.certified import certified  # noqa: PLC0415  # heyoka is an extra

    found: Callable[[Scene], BoundedSolution] = certified
    return found
