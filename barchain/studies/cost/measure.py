"""A cost study from start to tables: what the command line and notebooks call."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from adapters.registry import engines
from barchain.record.environment import provenance
from barchain.record.facts import engine_facts, external_versions, scene_words
from barchain.run.selection import chosen_engines, unique_names
from barchain.studies.cost.plan import MINUTES, REPEATS, TIME_LIMIT_S, CostPlan, shortened
from barchain.studies.cost.store import CostStore
from barchain.studies.cost.study import CostStudy
from reports.tables.cost import FOLDER
from scenarios import Scene, load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from barchain.studies.cost.points import SolutionSource

DEFAULT_SCENES = "paper/"


def make_plan(
    scenes: Iterable[Scene | str | Path] | None = None,
    engine_names: Iterable[str] | None = None,
    *,
    orbits: float = 1.0,
    repeats: int = REPEATS,
    minutes: float = MINUTES,
    time_limit_s: float = TIME_LIMIT_S,
) -> CostPlan:
    """Plan of a study.

    Parameters
    ----------
    scenes : iterable of Scene, str or Path, optional
        The paper's by default.
    engine_names : iterable of str, optional
        All registered engines by default, those that only studies need among them.
    orbits : float
        How much of each scene is run, from its start.
    repeats : int
        Times that each point is measured, if there is time.
    minutes : float
        Divided among the scenes; where it runs short, repeats and then long runs are given up.
    time_limit_s : float
        Runs expected to take longer are left out, and said so.

    Raises
    ------
    SceneError, UnknownEngineError
        For a scene or an engine that does not exist.
    """
    names = [n for n in scene_names() if n.startswith(DEFAULT_SCENES)] if scenes is None else scenes
    loaded = unique_names([s if isinstance(s, Scene) else load_scene(s) for s in names])
    chosen = engines() if engine_names is None else chosen_engines(engine_names)
    return CostPlan([shortened(s, orbits) for s in loaded], chosen, repeats, minutes, time_limit_s)


def measure(
    plan: CostPlan,
    out: Path,
    *,
    resume: bool = False,
    command: str = "",
    progress: Callable[[str, str, str], None] | None = None,
    solution_of: Callable[[Scene], SolutionSource] | None = None,
) -> CostStudy:
    """Measure what accuracy costs, and write the tables into ``out/cost``.

    Parameters
    ----------
    plan : Plan
    out : Path
        Result folder; a comparison that is there already is left alone.
    resume : bool
        Go on from what a cut-off study left in `out`.
    command : str
        What was typed, for the record.
    progress : callable, optional
        Told (scene, engine and setting, outcome) after each first run, and after each round.
    truth_of : callable, optional
        Truth of a scene; the oracle's by default.
    """
    store = CostStore(out / FOLDER, new_record(plan, command), resume=resume)
    study = CostStudy(plan, store, solution_of or certified_of(), progress or (lambda *_: None))
    study.run()
    return study


def certified_of() -> Callable[[Scene], SolutionSource]:
    """Return the oracle, imported only where a study asks for it."""
    from barchain.solutions.certified import certified  # noqa: PLC0415  # heyoka is an extra

    found: Callable[[Scene], SolutionSource] = certified
    return found


def new_record(plan: CostPlan, command: str) -> dict[str, Any]:
    """run.json before the first run."""
    return provenance(command, external_versions(plan.engines)) | {
        "engines": {name: engine_facts(r) for name, r in plan.engines.items()},
        "scenes": {s.name: scene_words(s) for s in plan.scenes},
        "certified_solutions": {},
        "left_out": [],
        "limits": {"repeats": plan.repeats, "minutes": plan.minutes, "time_limit_s": plan.time_limit_s},
    }
