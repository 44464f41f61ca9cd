"""Scenes and engines of a stability study, pairs left to a full one, and each engine's settings in a scene."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from adapters.common.equal_steps import finer_setting, steps_between_samples
from adapters.engine import AccuracyParameter, Setting
from adapters.ode_solvers.adapter import ScipyEngine
from adapters.registry import COMPILED, ENGINES, engines, find_engine
from barchain.runs.job import Job, Role
from barchain.studies.stability.expected import SLOW, recorded
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from adapters.engine import Engine
    from adapters.registry import Registration
    from scenarios import Scene

HARD = "hard/"
HUGE = "huge"  # tag of scenes that take hours, and are run where they are named
LONG = "long"  # tag of scenes whose drifts are followed over time

SOLUTION_LIMIT_S = (
    600.0  # a reference solution is run four times, at its tightest and at close samples; without it nothing is judged
)
COARSER_RTOL, COARSER_STEPS = 100.0, 0.25  # two decades of a request; two halvings of a step
PLAIN_RTOL = 1e-3  # SciPy's default; its default absolute tolerance of 1e-6 is a thousandth of it, as the adapter takes
EXACT_RTOL = 1e-14  # of the compiled reference: its sums are compensated from here on
SCIPY = re.compile("scipy-.*")
"""SciPy's solvers, on compiled rates and on rates in NumPy"""

NUMPY_RATES = frozenset({"reference", "reference-absolute"})
"""Engines that evaluate rates in NumPy: hundreds of orbits take them minutes a run"""
MOST_BARS_COMPILED = 200  # heyoka compiles 1000 bars for minutes, at each setting


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


def left_to_a_full_study(scenes: Iterable[Scene], names: Iterable[str]) -> frozenset[tuple[str, str]]:
    """Pairs that take long and are known: recorded time-outs, and :func:`takes_minutes`."""
    own, known = frozenset(names), recorded()
    found = {(scene.name, name) for scene in scenes for name in own if takes_minutes(scene, name, own)}
    return frozenset(found | {pair for pair, word in known.items() if word == SLOW and pair[1] in own})


def takes_minutes(scene: Scene, name: str, engines: Collection[str]) -> bool:
    """Whether each run takes minutes: rates in NumPy in a long scene, if the compiled reference is there; compiling."""
    if LONG in scene.tags and COMPILED in engines and name in NUMPY_RATES:
        return True
    solver = name != COMPILED and name in ENGINES and ENGINES[name].needs_kernel
    return scene.bars > MOST_BARS_COMPILED and (solver or (name in ENGINES and ENGINES[name].compiles))


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
