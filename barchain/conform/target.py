"""What is examined: an engine, scenes from one free bar to each effect alone, the setting on each, and the extent.

The engine is a registered one by name, or a class by ``module:Class``. The scenes come in stages that presuppose each
other.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from adapters.registry import ENGINES, RESERVED, TARGET, Registration, UnknownEngineError, find_engine
from barchain.conform.checks import Group
from barchain.judge.error_model import ErrorModel
from barchain.runs.asking import engine_class
from barchain.runs.job import Job
from barchain.solutions.reference import closely_sampled
from barchain.solutions.shipped import shipped_solution
from scenarios import SceneError, load_scene, nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from adapters.engine import Engine, Setting
    from barchain.runs.job import Role
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

RUN_S = 10.0
"""Longest time of one run by default: most scenes are a fifth of an orbit of a few bars"""
MOST_FINER = 10.0
"""Largest ratio of the steps, or of the requested errors, to the default: finer runs take too long"""
FINER = {AccuracyParameter.RTOL: 0.1, AccuracyParameter.STEPS_PER_ORBIT: 2.0}
"""Factor from a setting to the next finer one; `AccuracySweep.finer_rtol` is that of a second run beside the first"""
LASTING = 0.9
"""Least share of a scene in which right runs agree; the rest is judged in restarts"""
FOLDER = "conform/"


def in_folder(names: str) -> tuple[str, ...]:
    """Full names of scenes of the examination."""
    return tuple(f"{FOLDER}{name}" for name in names.split())


STAGES = {
    "without forces": in_folder("one_bar_free two_bars_free three_bars_free"),
    "in gravity": in_folder(
        "one_bar_point one_bar_gradient three_bars_point three_bars_gradient eccentric bar_angles one_bar_eccentric"
    ),
    "with one effect": in_folder(
        "slender_alone quadrupole_alone oblateness_alone third_body_alone drag_alone solar_pressure_alone "
        "solar_shadow_alone joint_springs_alone thrust_body thrust_inertial impulse_alone prescribed_orbital "
        "prescribed_inertial prescribed_orbital_joint prescribed_inertial_external"
    ),
}
"""Scenes from one free bar to each effect alone; those of a stage presuppose the stages before"""
FIRST = in_folder("two_bars_free three_bars_gradient one_bar_free one_bar_point")
"""Scenes of the conventions: the first that the engine supports"""
REPEATED = in_folder("three_bars_gradient three_bars_point three_bars_free one_bar_point")
"""Scenes of accuracy and behaviour: the first that the engine supports"""
PARTICLE = in_folder("one_bar_point one_bar_free")
"""The same for an engine without attitude: on one bar in point gravity it has no difference of model"""


@dataclass(frozen=True)
class Examined:
    """An engine that is examined."""

    name: str
    registration: Registration
    registered: bool = True
    """Whether the engine has an entry point; False of a class that is named directly"""
    run_s: float = RUN_S
    """Longest time of one run, after the start of its process"""
    note: Callable[[str], None] = lambda _: None
    """Called with a sentence before checks that take long"""

    @property
    def own(self) -> bool:
        """Whether the engine is barchain's own adapter."""
        return self.registration in ENGINES.values()

    def job(self, scene: Scene, setting: Setting, role: Role) -> Job:
        """A run of the engine."""
        return Job(scene, self.name, self.registration, setting, role)

    def load(self) -> type[Engine]:
        """Class with the engine's declarations. Errors as :func:`barchain.runs.asking.engine_class`."""
        return engine_class(self.registration)


def examined(given: str) -> Examined:
    """Engine of a name, or of ``module:Class`` on Python's path or in the current folder.

    Raises
    ------
    UnknownEngineError
        If no engine has the name; the message tells how a class or a package is given.
    """
    if re.fullmatch(TARGET, given):
        here = str(Path.cwd())
        if here not in sys.path:
            sys.path.append(here)
        return Examined(short_name(given), Registration(given), registered=False)
    try:
        return Examined(given, find_engine(given))
    except UnknownEngineError as error:
        raise UnknownEngineError(f"{error}; {how_to_give(given)}") from None


def how_to_give(given: str) -> str:
    """How an engine is given that no package registers."""
    module, _, name = given.rpartition(".")
    if module and re.fullmatch(TARGET, f"{module}:{name}"):
        return f"a class is given as MODULE:CLASS (did you mean {module}:{name}?)"
    return "the engine of a package is there after `pip install -e FOLDER`; a class is given as MODULE:CLASS"


def short_name(target: str) -> str:
    """Name of a class that has no entry point yet: ``MyEngine`` becomes ``my-engine``."""
    words = re.findall(r"[A-Z]*[^A-Z]+|[A-Z]+", target.partition(":")[2])
    name = "-".join(w.lower().strip("_") for w in words if w.strip("_")) or "engine"
    return f"{name}-engine" if name in {*ENGINES, *RESERVED} else name


@cache
def scene_of(name: str) -> Scene:
    """Scene of a name, at the samples of a comparison."""
    return closely_sampled(load_scene(name))


@cache
def solved(name: str) -> ReferenceSolution:
    """Certified solution of a scene.

    Raises
    ------
    FileNotFoundError
        If barchain comes without the solution.
    """
    found = shipped_solution(scene_of(name))
    if found is None:
        raise FileNotFoundError(f"{name}: this installation lacks the certified solution; install barchain again")
    return found


def setting_of(engine: type[Engine], name: str) -> Setting:
    """Setting at which an engine is examined on a scene.

    The default, or the first of the next finer settings at which two right runs agree in most of the scene. Beyond
    the predictability limit only restarts, the track and invariants are judged, and a weak force that is missing may
    pass. Where no setting up to :data:`MOST_FINER` agrees so long, the finest of these.

    Parameters
    ----------
    engine : type
        Subclass of `Engine`.
    name : str
        Scene of conformance.
    """
    tried = list(from_default_on(engine))
    return next((setting for setting in tried if lasts(engine, setting, name)), tried[-1])


def from_default_on(engine: type[Engine]) -> Iterator[Setting]:
    """The default, and settings of twice the steps or a tenth of the requested error each, up to `MOST_FINER`."""
    setting = engine.sweep.setting()
    factor, finer = FINER[setting.parameter], 1.0
    while finer <= MOST_FINER * (1.0 + 1e-9):
        yield setting
        setting, finer = replace(setting, value=setting.value * factor), finer * max(factor, 1.0 / factor)


def lasts(engine: type[Engine], setting: Setting, name: str) -> bool:
    """Whether two right runs at a setting agree for :data:`LASTING` of a scene."""
    solution = solved(name)
    errors = ErrorModel(engine, setting, solution, solution.trajectory)
    return bool(errors.limit_s >= LASTING * errors.t_s[-1])


@dataclass(frozen=True)
class Extent:
    """Groups and scenes that are examined, and the time limit."""

    groups: frozenset[Group] = frozenset(Group)
    scenes: tuple[str, ...] = ()
    """Scenes of the physics; empty for all"""
    time_limit_s: float = RUN_S
    """Longest time of one run after the start of its process"""

    @property
    def whole(self) -> bool:
        """Whether everything is examined."""
        return self.groups == frozenset(Group) and not self.scenes

    @property
    def stages(self) -> dict[str, tuple[str, ...]]:
        """Stages of the physics with their scenes."""
        kept = {
            name: tuple(s for s in scenes if not self.scenes or s in self.scenes) for name, scenes in STAGES.items()
        }
        return {name: scenes for name, scenes in kept.items() if scenes}


WHOLE = Extent()


def extent_of(names: Iterable[str], time_limit_s: float = RUN_S) -> Extent:
    """Extent of named groups and scenes; loading always belongs to it, and the physics to a scene.

    Parameters
    ----------
    names : iterable of str
        Groups, and scenes of the physics as ``impulse_alone`` or ``conform/impulse_alone``; everything without any.
    time_limit_s : float, optional

    Raises
    ------
    SceneError
        If a name is neither a group nor a scene of the examination; the message gives the nearest name.
    """
    every = list(names)
    if not every:
        return Extent(time_limit_s=time_limit_s)
    groups = {Group(name) for name in every if name in set(Group)}
    scenes = tuple(scene_name(name) for name in every if name not in set(Group))
    own = {Group.PHYSICS} if scenes else set[Group]()
    return Extent(frozenset(groups | own | {Group.LOADING}), scenes, time_limit_s)


def scene_name(given: str) -> str:
    """Full name of a scene of the physics."""
    known = [scene.removeprefix(FOLDER) for scenes in STAGES.values() for scene in scenes]
    name = given.removeprefix(FOLDER)
    if name not in known:
        groups = ", ".join(Group)
        near = nearest(name, [*known, *Group])
        raise SceneError(f"{given} given, allowed: {groups}, or a scene such as {known[0]}{near}")
    return f"{FOLDER}{name}"
