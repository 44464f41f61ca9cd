"""The scaling study: time of an evaluation and of an orbit, and memory, against the number of bars."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.registry import engines
from barchain.runs.facts import engine_facts, external_versions, scene_words
from barchain.runs.selection import chosen_engines
from barchain.runs.timing.divided_chain import SCENE
from barchain.studies.scaling.limits import BARS, MINUTES, REPEATS, TIME_LIMIT_S
from barchain.studies.scaling.plan import ScalingPlan
from barchain.studies.scaling.run import ScalingResult, ScalingRun
from barchain.studies.study import limits_of
from reports.tables.scaling import FILES
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.record.study_store import StudyStore
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles


@dataclass(frozen=True)
class ScalingOptions:
    """Options of a scaling study."""

    engines: Iterable[str] | None = None
    """All registered engines by default, also those that only studies run"""
    bars: Iterable[int] = BARS
    """Numbers of bars, at least 2; each engine goes as far as the limits allow"""
    repeats: int = REPEATS
    """Times that each point is measured"""
    minutes: float = MINUTES
    """Budget, after which no point is begun"""
    time_limit_s: float = TIME_LIMIT_S
    """Of one simulation: orbits that are expected to take longer are run in part, or not at all"""


@dataclass(frozen=True)
class ScalingStudy:
    """The scaling study."""

    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: ScalingOptions) -> ScalingPlan:
        """Engines, numbers of bars and limits.

        Raises
        ------
        UnknownEngineError
            For an engine that does not exist.
        ValueError
            For a number of bars below 2.
        """
        wanted = tuple(sorted(set(options.bars)))
        if not wanted or wanted[0] < 2:
            raise ValueError(f"bars {', '.join(map(str, wanted))}: allowed: 2 or more")
        chosen = engines() if options.engines is None else chosen_engines(options.engines)
        named = frozenset(() if options.engines is None else chosen)
        limits = options.repeats, options.minutes, options.time_limit_s
        return ScalingPlan(load_scene(SCENE), chosen, wanted, *limits, named=named)

    def record(self, plan: ScalingPlan) -> dict[str, Any]:
        """Engines, chain, limits, and the targets, which follow at the end."""
        return {
            "packages": external_versions(plan.engines),
            "engines": {name: engine_facts(r) for name, r in plan.engines.items()},
            "bars": list(plan.bars),
            "scene": scene_words(plan.scene) | {"name": plan.scene.name, "size_m": plan.scene.size_m},
            "targets": [],
            "limits": limits_of(plan),
        }

    def run(self, plan: ScalingPlan, store: StudyStore, reporter: Reporter) -> ScalingResult:
        """Measure points in the order of their expected time."""
        return ScalingRun(plan, store, reporter).run()
