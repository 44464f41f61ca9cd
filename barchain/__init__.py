"""barchain: a chain of rigid bars in orbit, simulated by many engines and compared honestly.

Names are imported when they are first used, so that ``import barchain`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adapters.engine import Engine as Engine
    from adapters.engine import EngineError as EngineError
    from adapters.engine import Setting as Setting
    from adapters.engine import SettingError as SettingError
    from adapters.registry import Registration as Registration
    from adapters.registry import UnknownEngineError as UnknownEngineError
    from adapters.trajectory import Trajectory as Trajectory
    from barchain.api import compare as compare
    from barchain.api import engines as engines
    from barchain.api import render as render
    from barchain.api import rows as rows
    from barchain.api import scenes as scenes
    from barchain.api import simulate as simulate
    from barchain.arguments import ArgumentError as ArgumentError
    from barchain.latching import latched as latched
    from barchain.measuring import cost as cost
    from barchain.measuring import effects as effects
    from barchain.measuring import sweep as sweep
    from barchain.studies.comparison.run import ComparisonResult as ComparisonResult
    from barchain.studies.ensemble.study import EnsembleResult as EnsembleResult
    from barchain.studies.ensemble.study import ensemble as ensemble
    from barchain.studies.own import asked_run as asked_run
    from barchain.studies.own import measure as measure
    from barchain.studies.sweep.study import SweepResult as SweepResult
    from reports.results.files import StudyTables as StudyTables
    from reports.results.schema import SchemaVersionError as SchemaVersionError
    from scenarios.load import SceneError as SceneError
    from scenarios.load import change_scene as change_scene
    from scenarios.load import go_on as go_on
    from scenarios.load import load_scene as load_scene
    from scenarios.load import make_scene as make_scene
    from scenarios.scene import Scene as Scene

    __version__: str

MODULES = {
    "ArgumentError": "barchain.arguments",
    "Engine": "adapters.engine",
    "EngineError": "adapters.engine",
    "Setting": "adapters.engine",
    "Registration": "adapters.registry",
    "UnknownEngineError": "adapters.registry",
    "Trajectory": "adapters.trajectory",
    "compare": "barchain.api",
    "engines": "barchain.api",
    "render": "barchain.api",
    "rows": "barchain.api",
    "scenes": "barchain.api",
    "simulate": "barchain.api",
    "latched": "barchain.latching",
    "cost": "barchain.measuring",
    "effects": "barchain.measuring",
    "sweep": "barchain.measuring",
    "SweepResult": "barchain.studies.sweep.study",
    "ensemble": "barchain.studies.ensemble.study",
    "EnsembleResult": "barchain.studies.ensemble.study",
    "StudyTables": "reports.results.files",
    "asked_run": "barchain.studies.own",
    "measure": "barchain.studies.own",
    "ComparisonResult": "barchain.studies.comparison.run",
    "SettingError": "adapters.engine",
    "SchemaVersionError": "reports.results.schema",
    "SceneError": "scenarios.load",
    "change_scene": "scenarios.load",
    "go_on": "scenarios.load",
    "load_scene": "scenarios.load",
    "make_scene": "scenarios.load",
    "Scene": "scenarios.scene",
}
"""Module that each public name is imported from"""

RENDERERS = {
    "derived": "barchain.metrics.derived:with_derived",
    "scene": "reports.notebook.scene:html",
    "trajectory": "reports.notebook.trajectory:html",
    "plot": "barchain.drawing:plot",
    "animation": "barchain.drawing:animate",
    "comparison": "reports.notebook.card:comparison_html",
}
"""Functions that add derived channels to tables, and draw scenes, trajectories and comparisons"""

__all__ = [*sorted({"__version__", *MODULES})]  # noqa: PLE0604  # names, as text


def __getattr__(name: str) -> object:
    """Import a public name on its first use, and keep it (PEP 562)."""
    if name == "__version__":
        found: object = import_module("importlib.metadata").version("barchain")
    elif name in MODULES:
        found = getattr(import_module(MODULES[name]), name)
        import_module("scenarios.hooks").register(RENDERERS)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """All public names, imported or not."""
    return sorted({*globals(), *__all__})
