"""A scaling study from start to tables: what the command line and notebooks call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from adapters.registry import engines
from barchain.record.environment import provenance
from barchain.record.facts import engine_facts, external_versions, scene_words
from barchain.run.selection import chosen_engines
from barchain.studies.scaling.plan import BARS, MINUTES, REPEATS, TIME_LIMIT_S, ScalingPlan
from barchain.studies.scaling.store import ScalingStore
from barchain.studies.scaling.study import ScalingStudy
from barchain.timing.divided_chain import SCENE
from reports.tables.scaling import FOLDER
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path


def make_plan(
    engine_names: Iterable[str] | None = None,
    bars: Iterable[int] = BARS,
    *,
    repeats: int = REPEATS,
    minutes: float = MINUTES,
    time_limit_s: float = TIME_LIMIT_S,
) -> ScalingPlan:
    """Plan of a study.

    Parameters
    ----------
    engine_names : iterable of str, optional
        All registered engines by default, those that only studies need among them.
    bars : iterable of int
        Numbers of bars, at least 2; each engine goes as far as the limits let it.
    repeats : int
        Times that each point is measured.
    minutes : float
        After which nothing more is begun.
    time_limit_s : float
        Of one simulation: orbits expected to take longer are run in part, or not at all.

    Raises
    ------
    UnknownEngineError
        For an engine that does not exist.
    ValueError
        For a number of bars below 2.
    """
    wanted = tuple(sorted(set(bars)))
    if not wanted or wanted[0] < 2:
        raise ValueError(f"bars {', '.join(map(str, wanted))}: allowed: 2 or more")
    chosen = engines() if engine_names is None else chosen_engines(engine_names)
    return ScalingPlan(load_scene(SCENE), chosen, wanted, repeats, minutes, time_limit_s)


def measure(
    plan: ScalingPlan,
    out: Path,
    *,
    resume: bool = False,
    command: str = "",
    progress: Callable[[str, str, str], None] | None = None,
) -> ScalingStudy:
    """Measure how costs grow with the number of bars, and write the tables into ``out/scaling``.

    Parameters
    ----------
    plan : Plan
    out : Path
        Result folder; a comparison or a cost study that is there already is left alone.
    resume : bool
        Go on from what a cut-off study of the same bars left in `out`.
    command : str
        What was typed, for the record.
    progress : callable, optional
        Told (scene, engine and bars, outcome) after each point.
    """
    store = ScalingStore(out / FOLDER, new_record(plan, command), resume=resume)
    study = ScalingStudy(plan, store, progress or (lambda *_: None))
    study.run()
    return study


def new_record(plan: ScalingPlan, command: str) -> dict[str, Any]:
    """record.json before the first point."""
    return provenance(command, external_versions(plan.engines)) | {
        "engines": {name: engine_facts(r) for name, r in plan.engines.items()},
        "scene": scene_words(plan.scene) | {"name": plan.scene.name, "size_m": plan.scene.size_m},
        "targets": [],
        "limits": {"repeats": plan.repeats, "minutes": plan.minutes, "time_limit_s": plan.time_limit_s},
    }
