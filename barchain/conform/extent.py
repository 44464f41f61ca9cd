"""Extent of an examination: everything, or some groups of checks or scenes while an author mends an engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.conform.checks import Group
from barchain.conform.scenes import STAGES, SceneStage
from barchain.conform.target import RUN_S
from scenarios import SceneError, nearest

if TYPE_CHECKING:
    from collections.abc import Iterable

FOLDER = "conform/"


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
    def stages(self) -> tuple[SceneStage, ...]:
        """Stages of the physics with their scenes."""
        if not self.scenes:
            return STAGES
        kept = (SceneStage(stage.name, tuple(s for s in stage.scenes if s in self.scenes)) for stage in STAGES)
        return tuple(stage for stage in kept if stage.scenes)


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
    known = [scene.removeprefix(FOLDER) for stage in STAGES for scene in stage.scenes]
    name = given.removeprefix(FOLDER)
    if name not in known:
        groups = ", ".join(Group)
        near = nearest(name, [*known, *Group])
        raise SceneError(f"{given} given, allowed: {groups}, or a scene such as {known[0]}{near}")
    return f"{FOLDER}{name}"
