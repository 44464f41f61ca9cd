"""Changes of a scene in the keys of its file.

A scene holds seconds and one value for each bar. Its file may give less: a duration in orbits, no inertia, a thrust up
to the end. What the file leaves out follows from the rest, also after a change.
"""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any

from scenarios.toml.file import SceneFile
from scenarios.toml.orbit_keys import ANOMALIES, ELEMENTS, FORMS, STATE
from scenarios.toml.reading import tables_of
from scenarios.toml.resolve import resolve
from scenarios.toml.scene_tables import ANGLE_KEYS, RATE_KEYS
from scenarios.toml.writing import scene_data, scene_toml, toml

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenarios.scene import Scene

    Data = dict[str, Any]

ALTERNATIVES = (("orbits", "duration_s"), ANGLE_KEYS, RATE_KEYS, ANOMALIES)
"""Keys of one table of which a file holds one"""
OTHER_FORMS = {
    "orbit": {*STATE, *ELEMENTS},
    "chain": {"angle_rad", "rate_rad_s", "rate_deg_s", "end_body", "joint_mass"},
}
"""Keys from which several fields of a scene follow"""


def superseded() -> dict[str, set[str]]:
    """Keys that another key of the same table makes void, by that other one."""
    found = {key: set(keys) for keys in ALTERNATIVES for key in keys}
    for form in FORMS:
        for key in form:
            found.setdefault(key, set()).update(*(other for other in FORMS if other is not form))
    for key in ("length_m", "com_share", *ANGLE_KEYS):
        found.setdefault(key, set()).add("centre_m")
    return found


SUPERSEDED = superseded()


def merged(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> Data:
    """Tables with some keys changed at any depth; a list is replaced whole, and None removes a key."""
    found = dict(tables)
    for key, value in changes.items():
        for void in SUPERSEDED.get(key, set()) - set(changes) if value is not None else ():
            found.pop(void, None)
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
    changes = difference(scene_data(loaded), now)
    for part, keys in OTHER_FORMS.items():
        if part in changes and keys & set(scene.given[part]):  # a field alone would not say what the others are
            changes[part] = dict.fromkeys(keys) | now[part]
    if "effects" in changes and scene.given["run"].get("start_s"):  # changed ones count from the start of the scene
        changes["effects"] = dict.fromkeys(scene.given.get("effects", {})) | now["effects"]
        changes["run"] = {"start_s": None} | changes.get("run", {})
    return merged(scene.given, changes)


def scene_file(scene: Scene) -> str:
    """Text of a scene's file in the keys of its own file: what these leave out follows again, also after a change.

    A scene of no file, or one that was changed in Python to what those keys can't say, is written with all values.

    Raises
    ------
    UnwrittenError
        If no file gives it back digit for digit.
    """
    text = "\n".join(toml(current_tables(scene))) + "\n"
    with contextlib.suppress(ValueError):
        if resolve(SceneFile.model_validate(tables_of(text)), scene.name).digest == scene.digest:
            return text
    return scene_toml(scene)


def clock_at_start(scene: Scene) -> float:
    """Time that the clock of the effects' instants shows at the start of a scene, s."""
    if scene.given is None or not scene.given["run"].get("start_s"):
        return 0.0
    return float(current_tables(scene)["run"].get("start_s") or 0.0)  # none where effects were changed in Python
