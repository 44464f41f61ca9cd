"""Scenes, faults and seeds of a part on a night: patterns, rotation from night to night, what was left goes first."""

from __future__ import annotations

import fnmatch
import random
from typing import TYPE_CHECKING

from barchain.nightly.plan.loading import PlanError
from scenarios import load_scene, scene_names
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from barchain.nightly.plan.tables import CampaignTable, ScenesTable, SelftestTable

HUGE = "huge"
"""Tag of scenes that take hours, and are run only where they are named"""
SCENE_FILE = ".toml"


def part_scenes(part: ScenesTable, folder: Path) -> tuple[str, ...]:
    """All scenes of a part, in the order of the plan.

    Raises
    ------
    PlanError
        If a name is no scene or no file, or a pattern fits none.
    """
    found = [scene for given in part.scenes or part.scenes_of_study for scene in scenes_of(given, folder)]
    return tuple(dict.fromkeys(found))


def scenes_of(given: str, folder: Path) -> list[str]:
    """Scenes of one entry: a file, a name, or a pattern."""
    if given.endswith(SCENE_FILE):
        path = (folder / given).resolve()
        if not path.is_file():
            raise PlanError(f"scenes: {given!r} given, and there is no such file beside the plan")
        return [str(path)]
    known = scene_names()
    if given in known:
        return [given]
    fitting = fnmatch.filter(known, given)
    if not fitting:
        raise PlanError(f"scenes: {given!r} given, which is no scene and fits none{nearest(given, known)}")
    return [name for name in fitting if HUGE not in load_scene(name).tags]


def tonights(scenes: Sequence[str], nights: int, turn: int) -> tuple[str, ...]:
    """Scenes of one night, where they are divided among several: all are done once in `nights` nights."""
    return tuple(scenes[turn % nights :: nights])


def tonights_faults(part: SelftestTable, known: Iterable[str], turn: int) -> tuple[str, ...]:
    """Faults of one night: the next ones in an order that the seed draws, from the beginning again at its end."""
    order = sorted(known)
    random.Random(part.seed).shuffle(order)
    count = min(part.faults, len(order))
    begin = turn * count
    return tuple(order[(begin + k) % len(order)] for k in range(count))


def tonights_seed(part: CampaignTable, turn: int) -> int:
    """Number of the first random scene of one night: the next one after those of the night before."""
    return part.seed + turn * part.scenes
