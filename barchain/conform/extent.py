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


def extent_of(groups: Iterable[str], scenes: Iterable[str], time_limit_s: float = RUN_S) -> Extent:
    """Extent of named groups and scenes; loading always belongs to it, and scenes alone to the physics.

    Parameters
    ----------
    groups : iterable of str
        Names of groups; all without any.
    scenes : iterable of str
        Scenes of the physics, ``impulse_alone`` or ``conform/impulse_alone``; all without any.
    time_limit_s : float, optional

    Raises
    ------
    SceneError
        If a scene is none of the examination; the message gives the nearest one.
    """
    chosen = tuple(scene_name(given) for given in scenes)
    named = frozenset(map(Group, groups)) or (frozenset({Group.PHYSICS}) if chosen else frozenset(Group))
    return Extent(named | {Group.LOADING}, chosen, time_limit_s)


def scene_name(given: str) -> str:
    """Full name of a scene of the physics."""
    known = [scene for stage in STAGES for scene in stage.scenes]
    name = given if given.startswith(FOLDER) else f"{FOLDER}{given}"
    if name not in known:
        short = [scene.removeprefix(FOLDER) for scene in known]
        raise SceneError(f"{given}: no scene of the examination{nearest(name.removeprefix(FOLDER), short)}")
    return name
