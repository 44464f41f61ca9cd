"""Plan of a stability study: scenes, engines, and each engine's three settings in a scene."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.common.equal_steps import finer_setting, steps_between_samples
from adapters.engine import AccuracyParameter, Setting
from adapters.ode_solvers.scipy_engines import ScipyEngine
from adapters.registry import COMPILED, ENGINES, engines, find_engine
from barchain.runs.declared import engine_class
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import Job, Role
from barchain.runs.timing.left_out import cannot
from barchain.solutions.reference_runs import solution_jobs
from barchain.studies.stability.limits import TIME_LIMIT_S
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.engine import Engine
    from adapters.registry import Registration
    from barchain.runs.executors import Executor
    from scenarios import Scene

HARD = "hard/"
HUGE = "huge"  # tag of scenes that take hours, and are run where they are named
LONG = "long"  # tag of scenes whose drifts are followed over time

SOLUTION_LIMIT_S = (
    600.0  # a reference solution is run four times, at its tightest and at close samples; without it nothing is judged
)
LEVELS = (Role.COARSE, Role.MAIN, Role.FINER)
COARSER_RTOL, COARSER_STEPS = 100.0, 0.25  # two decades of a request; two halvings of a step
PLAIN_RTOL = 1e-3  # SciPy's default; its default absolute tolerance of 1e-6 is a thousandth of it, as the adapter takes
EXACT_RTOL = 1e-14  # of the compiled reference: its sums are compensated from here on
SCIPY = re.compile("scipy-.*")
"""SciPy's solvers, on compiled rates and on rates in NumPy"""


@dataclass(frozen=True)
class StabilityPlan:
    """Scenes, engines and limits of a study."""

    scenes: tuple[Scene, ...]
    engines: dict[str, Registration]
    time_limit_s: float = TIME_LIMIT_S
    executor: Executor = ALL_CORES
    left_out: frozenset[tuple[str, str]] = frozenset()
    """Scenes and engines that the default study leaves to a full one"""

    def engines_of(self, scene: Scene) -> dict[str, Registration]:
        """Engines that take part in a scene."""
        return {name: r for name, r in self.engines.items() if (scene.name, name) not in self.left_out}

    @property
    def turns(self) -> int:
        """Number of runs, for the progress."""
        able = [
            (s, engine_class(r))
            for s in self.scenes
            for name, r in self.engines_of(s).items()
            if cannot(s, name, r) is None
        ]
        solutions = sum(len(solution_jobs(s)) + len(exact_jobs(s)) for s in self.scenes)
        return solutions + sum(len(settings(s, e)) for s, e in able)


def hard_scenes() -> list[str]:
    """Names of the hard scenes that are run where none is named."""
    return [name for name in scene_names() if name.startswith(HARD) and HUGE not in load_scene(name).tags]


def default_engines(*, full: bool = False) -> dict[str, Registration]:
    """Engines that take part where none is named: those of the default set, and SciPy's solvers.

    The solvers run on compiled rates; on rates in NumPy in a full study, and where the kernel is missing.
    """
    found = {name: r for name, r in engines().items() if not r.missing and (r.by_default or SCIPY.fullmatch(name))}
    compiled = set() if full else {f"{name}-numpy" for name in found}
    return {name: r for name, r in found.items() if name not in compiled}


def chosen_engines(names: Iterable[str] | None, *, full: bool = False) -> dict[str, Registration]:
    """Engines by name, or the default ones."""
    return {name: find_engine(name) for name in dict.fromkeys(names)} if names else default_engines(full=full)


def settings(scene: Scene, engine: type[Engine]) -> dict[Role, Setting]:
    """Settings of an engine in a scene, by role; samples may lie too close for a coarser one."""
    main = engine.sweep.setting()
    found = {Role.MAIN: main, Role.FINER: finer_setting(scene, engine.sweep, main)}
    coarse = coarser(scene, main)
    if coarse is not None:
        found[Role.COARSE] = coarse
    if issubclass(engine, ScipyEngine):
        found[Role.PLAIN] = Setting(AccuracyParameter.RTOL, PLAIN_RTOL)
    return found


def coarser(scene: Scene, main: Setting) -> Setting | None:
    """A hundred times the request, or a quarter of the steps; None where that makes the same steps."""
    if main.parameter is AccuracyParameter.RTOL:
        return Setting(AccuracyParameter.RTOL, COARSER_RTOL * main.value)
    found = Setting(main.parameter, COARSER_STEPS * main.value)
    same = steps_between_samples(scene, found.value) == steps_between_samples(scene, main.value)
    return None if same else found


def exact_jobs(scene: Scene) -> list[Job]:
    """The compiled reference with compensated sums, in a scene whose drifts are followed over time."""
    if LONG not in scene.tags or ENGINES[COMPILED].missing:
        return []
    return [Job(scene, COMPILED, ENGINES[COMPILED], Setting(AccuracyParameter.RTOL, EXACT_RTOL), Role.EXACT)]
