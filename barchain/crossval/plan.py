"""What a comparison shall do, and what it knows of each scene so far."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from adapters.registry import ENGINES
from barchain.crossval.default_settings import comparison_setting
from barchain.runs.executors import ALL_CORES
from barchain.solutions.reference import SolutionSource

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.registry import Registration
    from barchain.judge.verdict import Verdict
    from barchain.runs.executors import Executor
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene


@dataclass(frozen=True)
class ComparisonPlan:
    """Scenes and engines to compare, and how."""

    scenes: list[Scene]
    engines: dict[str, Registration]
    time_limit_s: float = 120.0
    executor: Executor = ALL_CORES
    """Place of the runs and of long verdicts"""
    settings: dict[str, Setting] = field(default_factory=dict)
    """Setting of an engine other than its default"""
    need_external: bool = False
    """Whether a scene that no engine with independent physics passes is a failure"""
    named: bool = False
    """Whether the engines were requested by name: an engine that was compared on no scene is then a failure"""
    certify: bool = False
    """Whether scenes without a shipped solution are judged by one of heyoka's, where it can make one"""

    def setting(self, name: str, engine: type[Engine], solution: ReferenceSolution | None = None) -> Setting:
        """Setting at which an engine is judged; `solution` is the scene's, where it is known before the runs."""
        given = self.settings.get(name)
        if given is not None:
            return given
        own = name in ENGINES  # declarations of another package's engine are not asked for a choice
        return comparison_setting(engine, solution if own else None)


@dataclass
class SceneProgress:
    """Results of one scene as they come."""

    scene: Scene
    verdicts: dict[str, Verdict] = field(default_factory=dict)
    source: SolutionSource = SolutionSource.REFERENCE
    """Origin of the solution that judges the scene"""
    solution_failed: str = ""
    """Why no solution judges the scene; empty if one does"""
