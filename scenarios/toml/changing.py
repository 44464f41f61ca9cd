"""Changes of a scene in the keys of its file.

A scene holds seconds and one value for each bar. Its file may give less: a duration in orbits, no inertia, a thrust up
to the end. What the file leaves out follows from the rest, also after a change.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenarios.toml.file import SceneFile
from scenarios.toml.resolve import resolve
from scenarios.toml.writing import scene_data

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenarios.scene import Scene

    Data = dict[str, Any]

SUPERSEDED = {"orbits": "duration_s", "duration_s": "orbits", "angle_deg": "centre_m", "length_m": "centre_m"}
"""Keys that another key of the same table makes void, each beside that other one"""


def merged(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> Data:
    """Tables with some keys changed at any depth; a list is replaced whole, and None removes a key."""
    found = dict(tables)
    for key, value in changes.items():
        if key in SUPERSEDED and SUPERSEDED[key] not in changes:
            found.pop(SUPERSEDED[key], None)
        if value is None:
            found.pop(key, None)
        elif isinstance(value, dict) and isinstance(found.get(key), dict):
            found[key] = merged(found[key], value)
        else:
            found[key] = value
    return found


def difference(before: Data, now: Data) -> Data:
    """Changes that :func:`merged` makes `now` of `before` with."""
    found: Data = dict.fromkeys(key for key in before if key not in now)
    for key, value in now.items():
        old = before.get(key)
        if isinstance(value, dict) and isinstance(old, dict):
            deeper = difference(old, value)
            if deeper:
                found[key] = deeper
        elif type(value) is not type(old) or value != old:
            found[key] = value
    return found


def current_tables(scene: Scene) -> Data:
    """Tables of a scene's file, with what was changed in Python since; all values of a scene that is of no file."""
    now = scene_data(scene)
    if scene.given is None:
        return now
    loaded = resolve(SceneFile.model_validate(scene.given), scene.name)
    return merged(scene.given, difference(scene_data(loaded), now))
