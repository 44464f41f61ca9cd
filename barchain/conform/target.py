"""What is examined: a registered engine by name, or a class by ``module:Class``, and the extent of the examination."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from adapters.registry import ENGINES
from barchain.conform.checks import Group
from barchain.conform.scenes import FOLDER, STAGES, scene_for
from barchain.runs.asking import declarations_of
from barchain.runs.choices import named_engine
from barchain.runs.job import Job
from scenarios import SceneError, nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.engine import Declarations, Setting
    from adapters.registry import Registration
    from barchain.runs.job import Role
    from scenarios import Scene

PHYSICS_RUNS = 60.0
"""Longest time of all scenes of the physics, over the longest time of one run: barchain's slowest engine takes half"""
RUN_S = 10.0
"""Longest time of one run by default: most scenes are a fifth of an orbit of a few bars"""


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
    end: float = math.inf
    """Value of `time.monotonic` from which on no scene of the physics is begun"""

    first_runs_s: list[float] = field(default_factory=list, compare=False)
    """Times of the first runs in their processes, with what they import"""

    @property
    def late(self) -> bool:
        """Whether the time of the physics is over."""
        return time.monotonic() >= self.end

    @property
    def own(self) -> bool:
        """Whether the engine is barchain's own adapter."""
        return self.registration in ENGINES.values()

    def scene(self, name: str) -> Scene:
        """Scene of the examination as the engine is given it; errors as :attr:`declarations`, or of a question."""
        return scene_for(self.declarations, name)

    def job(self, scene: Scene, setting: Setting, role: Role) -> Job:
        """A run of the engine."""
        return Job(scene, self.name, self.registration, setting, role)

    @property
    def declarations(self) -> Declarations:
        """The engine's declarations. Errors as :func:`barchain.runs.asking.declarations_of`."""
        return declarations_of(self.registration)


def examined(given: str) -> Examined:
    """Engine of a name, or of ``module:Class``; errors as :func:`barchain.runs.choices.named_engine`."""
    name, registration = named_engine(given)
    return Examined(name, registration, registered=":" not in given)


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
    name = given.removeprefix(FOLDER).replace(" ", "_")
    if name not in known:
        groups = ", ".join(Group)
        near = nearest(name, [*known, *Group])
        raise SceneError(f"{given} given, allowed: {groups}, or a scene such as {known[0]}{near}")
    return f"{FOLDER}{name}"
