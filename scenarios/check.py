"""Check of scenes made in Python, by the rules of scene files."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from scenarios.limits import LimitError
from scenarios.load import SceneError
from scenarios.scene_file import scene_data
from scenarios.text import shorten
from scenarios.toml.faults import fault_lines
from scenarios.toml.file import SceneFile
from scenarios.toml.resolve import IncompleteError, resolve

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenarios.scene import Scene


def check_scene(scene: Scene) -> Scene:
    """Check a scene that was made or changed in Python; a scene from a file is valid already.

    Faults are named as in a file: ``effects.thrust[0].bar`` is the bar of the first thrust, and angles are in degrees.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Scene
        The same scene.

    Raises
    ------
    SceneError
        If a file with these values would be rejected; the message has one line for each fault.
    """
    try:
        found = resolve(SceneFile.model_validate(scene_data(scene)), scene.name)
    except ValidationError as error:
        raise SceneError("\n".join(f"{scene.name}: {line}" for line in fault_lines(error))) from None
    except (IncompleteError, LimitError) as error:
        raise SceneError(f"{scene.name}: {error}") from None
    except (TypeError, AttributeError, OverflowError) as error:
        raise SceneError(f"{scene.name}: a field of the scene is not of its type: {error}") from None
    faults = list(type_faults(scene, found))
    if faults:
        raise SceneError("\n".join(f"{scene.name}: {line}" for line in faults))
    return scene


def type_faults(given: Any, found: Any, where: str = "") -> Iterator[str]:
    """Fields that are not of the type that a file gives them, one line each: a list or a text works in part only."""
    if isinstance(found, int | float) and isinstance(given, int | float):
        return
    if type(given) is not type(found):
        yield f"{where}: {shorten(given)} given, allowed: of type {type(found).__name__}"
    elif dataclasses.is_dataclass(found):
        for field in dataclasses.fields(found):
            name = f"{where}.{field.name}" if where else field.name
            yield from type_faults(getattr(given, field.name), getattr(found, field.name), name)
    elif isinstance(found, tuple):
        for number, (one, other) in enumerate(zip(given, found, strict=True)):
            yield from type_faults(one, other, f"{where}[{number}]")
