"""Numbers of a scene's file by their dotted paths: ``orbit.speed_factor``, ``chain.angle_deg[2]``.

Lists and tables of several count from 1, as bars and joints do: ``effects.thrust[1]`` is the first thrust.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenarios.toml.changing import merged
from scenarios.toml.writing import scene_data

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

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
        found = value_in(found, str(step))
    if not isinstance(found, list):
        raise PathError(f"{before}: {scene.name} has no list there, allowed: {before} without [*]")
    return [f"{before}[{k}]{after}" for k in range(1, len(found) + 1)]


def changes_at(tables: Data, values: Mapping[str, float], whole: Callable[[], Data]) -> Data:
    """Changes that :func:`scenarios.toml.changing.merged` gives the tables of a file other numbers at some paths with.

    A number that stands for all bars becomes a list where one of them is changed.

    Parameters
    ----------
    tables : dict
        Tables of the file.
    values : mapping
        Numbers by their paths.
    whole : callable
        The same tables with all lists given; called where the file leaves one out.

    Raises
    ------
    PathError
        If a list has no such value.
    """
    found: Data = {}
    for path, value in values.items():
        try:
            put(found, tables, whole, steps_of(path), value)
        except PathError as error:
            raise PathError(f"{path}: {error}") from None
    return found


def put(changes: Data, tables: Any, whole: Callable[[], Any], steps: list[Step], value: float) -> None:
    """Add one number to `changes` of some tables."""
    key, at, below = str(steps[0]), steps[1] if len(steps) > 1 else None, steps[2:]
    if at is None:
        changes[key] = value
        return
    given = value_in(tables, key)
    if isinstance(at, str):
        put(changes.setdefault(key, {}), given, lambda: value_in(whole(), key), steps[1:], value)
        return
    known = changes.get(key, given)
    known = known if isinstance(known, list) else value_in(whole(), key)
    items = list(known) if isinstance(known, list) else []
    if not 0 <= at < len(items):
        allowed = f"[1] to [{len(items)}]" if items else "a key of the file without [...]"
        raise PathError(f"no such value in this scene, allowed: {allowed}")
    if below and isinstance(items[at], dict):
        inner: Data = {}
        put(inner, items[at], lambda: value_in(whole(), key)[at], below, value)
        items[at] = merged(items[at], inner)
    else:
        items[at] = value
    changes[key] = items


def value_in(tables: Any, key: str) -> Any:
    """Value of a key; None without one."""
    return tables.get(key) if isinstance(tables, dict) else None
