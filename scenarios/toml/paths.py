"""Numbers of a scene's file by their dotted paths: ``orbit.speed_factor``, ``chain.angle_deg[2]``.

Lists and tables of several count from 1, as bars and joints do: ``effects.thrust[1]`` is the first thrust.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenarios.toml.changing import current_tables, merged
from scenarios.toml.writing import scene_data

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenarios.scene import Scene

    Data = dict[str, Any]
    Step = str | int

KEY = r"[A-Za-z_]\w*(?:\[(?:\d{1,9}|\*)\])?"
PATH = rf"{KEY}(?:\.{KEY})*"
"""Pattern of a path"""
EVERY = "[*]"
"""Each value of a list by itself"""


class PathError(ValueError):
    """A path that leads to no value of a list; one line."""


def steps_of(path: str) -> list[Step]:
    """Keys of a path, and indices from 0."""
    return [int(part) - 1 if part.isdigit() else part for part in re.findall(r"[^.\[\]]+", path)]


def each_path(scene: Scene, path: str) -> list[str]:
    """Paths of all values of a list, of one with :data:`EVERY`; any other path as it is.

    Raises
    ------
    PathError
        If there is no list.
    """
    before, every, after = path.partition(EVERY)
    if not every:
        return [path]
    found: Any = scene_data(scene)
    for step in steps_of(before):
        found = found.get(step) if isinstance(found, dict) else None
    if not isinstance(found, list):
        raise PathError(f"{before}: {scene.name} has no list there, allowed: {before} without [*]")
    return [f"{before}[{k}]{after}" for k in range(1, len(found) + 1)]


def changes_at(scene: Scene, values: Mapping[str, float]) -> Data:
    """Changes, as :func:`scenarios.load.change_scene` takes them, that give a scene numbers at some paths.

    A number that stands for all bars becomes a list where one of them is changed.

    Raises
    ------
    PathError
        If a list has no such value.
    """
    found: Data = {}
    tables, whole = current_tables(scene), scene_data(scene)
    for path, value in values.items():
        put(found, tables, whole, steps_of(path), value, path)
    return found


def put(changes: Data, tables: Any, whole: Any, steps: list[Step], value: float, path: str) -> None:
    """Add one number to `changes` of some tables; `whole` has the same tables with all values given."""
    key, at, below = str(steps[0]), steps[1] if len(steps) > 1 else None, steps[2:]
    if at is None:
        changes[key] = value
        return
    given, full = (found.get(key) if isinstance(found, dict) else None for found in (tables, whole))
    if isinstance(at, str):
        put(changes.setdefault(key, {}), given, full, steps[1:], value, path)
        return
    known = changes.get(key, given)
    items = list(known if isinstance(known, list) else full if isinstance(full, list) else ())
    if not 0 <= at < len(items):
        allowed = f"[1] to [{len(items)}]" if items else "keys of the scene's file"
        raise PathError(f"{path}: no such value in this scene, allowed: {allowed}")
    if below and isinstance(items[at], dict):
        inner: Data = {}
        put(inner, items[at], full[at] if isinstance(full, list) else None, below, value, path)
        items[at] = merged(items[at], inner)
    else:
        items[at] = value
    changes[key] = items
