"""The effects study: size, influence and cost of each effect of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from barchain.runs.executors import ALL_CORES
from barchain.runs.facts import scene_words
from barchain.runs.timing.estimate import need_runnable
from barchain.studies.effects.budget import EffectsBudget, EffectsResult
from barchain.studies.effects.default_options import MATTERS, REPEATS, RTOL, SECONDS
from barchain.studies.effects.effect_toggles import switches
from barchain.studies.effects.plan import EffectsPlan
from barchain.studies.effects.sensitivity import LOOSER
from reports.tables.crossval import PARTED_RAD
from reports.tables.effects import FILES

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles
    from scenarios import Scene


@dataclass(frozen=True)
class EffectsOptions:
    """Options of an effects study."""

    scene: Scene
    rtol: float = RTOL
    """Accuracy of a step of the tighter run"""
    matters: float = MATTERS
    """Change from which an effect is relevant: see :mod:`reports.chapters.effects.advice`"""
    repeats: int = REPEATS
    """Rounds of timing"""
    seconds: float = SECONDS
    """Time after which no further round of timing is begun"""
    executor: Executor = ALL_CORES
    """Place of the runs that are not timed; all cores of this machine by default"""
    engine: str | None = None
    """Form of the reference for all runs; by default the compiled one where it supports them"""
    width_m: float | None = None
    """Of every bar, for drag and sunlight that the scene does not have; by default the scene's own, if it has one"""


@dataclass(frozen=True)
class EffectsStudy:
    """The effects study."""

    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: EffectsOptions) -> EffectsPlan:
        """All effects of a scene, present or absent there.

        Raises
        ------
        ClusterError
            For a Dask cluster that can't be used.
        ValueError
            For a width beyond a bar's length, which no scene allows.
        """
        need_runnable([options.scene])
        shortest_m = min(options.scene.chain.length_m)
        if options.width_m is not None and options.width_m > shortest_m:
            raise ValueError(
                f"{options.width_m:g} m given, allowed: at most the shortest bar's length, {shortest_m:g} m"
            )
        plan = EffectsPlan(switches=switches(options.scene, width_m=options.width_m), **vars(options))
        options.executor.check()
        return plan

    def record(self, plan: EffectsPlan) -> dict[str, Any]:
        """Scene, and the limits of the advice."""
        return {
            "scene": scene_words(plan.scene) | facts(plan.scene),
            "rtol": plan.rtol,
            "looser": LOOSER,
            "parted_rad": PARTED_RAD,
            "matters": plan.matters,
            "width_m": plan.width_m,
        }

    def run(self, plan: EffectsPlan, store: StudyStore, reporter: Reporter) -> EffectsResult:
        """Run the scene with each effect switched, then time the runs."""
        return EffectsBudget(plan, store, reporter).run()


def facts(scene: Scene) -> dict[str, Any]:
    """Units in which the advice measures changes."""
    return {
        "name": scene.name,
        "gravity": str(scene.effects.gravity),
        "bound": scene.bound,
        "period_s": scene.period_s,
        "radius0_m": scene.radius0_m,
    }
