"""From a scene's name or file to a :class:`~scenarios.scene.Scene`, with errors people can act on."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from scenarios.complete import IncompleteError, resolve
from scenarios.effect_tables import LIST, NUMBER
from scenarios.schema import SceneFile

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from pydantic_core import ErrorDetails

    from scenarios.scene import Scene

SHIPPED = Path(__file__).parent
LIKE_ENOUGH = 0.6  # difflib's own default: below it a suggestion is a guess


class SceneError(ValueError):
    """A scene that can't be used: names the file, the key, what was given and what is allowed."""


def scene_names(folders: Sequence[Path] = (SHIPPED,)) -> list[str]:
    """Names of all scenes below `folders`, e.g. ``paper/fig05``, sorted."""
    return sorted(
        {p.relative_to(folder).with_suffix("").as_posix() for folder in folders for p in folder.rglob("*.toml")}
    )


def load_scene(scene: str | Path, folders: Sequence[Path] = (SHIPPED,)) -> Scene:
    """Load and validate a scene.

    Parameters
    ----------
    scene : str or Path
        The name of a scene below `folders` (``paper/fig05``), or the path of a TOML file.
    folders : sequence of Path, optional
        Where names are looked up, first match wins; the shipped scenes by default.

    Returns
    -------
    Scene
        Complete and frozen, in SI units and radians.

    Raises
    ------
    SceneError
        If there is no such scene, or its file is not valid; the message is one line for each fault.
    """
    for folder in folders:
        named = folder / f"{scene}.toml"
        if not Path(scene).suffix and named.is_file():
            return parse_scene(read_text(named), name=str(scene), file=f"{scene}.toml")
    path = Path(scene)
    if path.is_file():
        return parse_scene(read_text(path), name=path.stem, file=str(path))
    names = scene_names(folders)
    if path.suffix == ".toml":
        raise SceneError(f"{scene}: no such file")
    raise SceneError(
        f"{scene}: no such scene{nearest(str(scene), names)}; there are: {', '.join(names)}, or a file's path"
    )


def read_text(path: Path) -> str:
    """Text of a scene file; a file that can't be read is a :class:`SceneError`."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: can't be read: {error}") from error


def parse_scene(text: str, *, name: str, file: str) -> Scene:
    """Validate the TOML `text` of a scene; `file` is how errors call it.

    Raises
    ------
    SceneError
        As :func:`load_scene`.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{file}: not valid TOML: {error}") from error
    try:
        return resolve(SceneFile.model_validate(data), name)
    except IncompleteError as error:
        raise SceneError(f"{file}: {error}") from None
    except ValidationError as error:
        raise SceneError("\n".join(f"{file}: {explain(e)}" for e in without_echoes(error.errors()))) from None


def nearest(given: str, allowed: Iterable[str]) -> str:
    """`` (did you mean X?)`` for the allowed name nearest to `given`; empty if none is near."""
    match = nearest_name(given, allowed)
    return f" (did you mean {match}?)" if match else ""


def nearest_name(given: str, allowed: Iterable[str]) -> str | None:
    """Allowed name nearest to `given`, the first of equals, or None if none is near."""

    def likeness(name: str) -> float:
        return difflib.SequenceMatcher(None, given.lower(), name.lower()).ratio()

    best = max(sorted(allowed), key=likeness, default=None)
    return best if best is not None and likeness(best) >= LIKE_ENOUGH else None


def without_echoes(errors: list[ErrorDetails]) -> list[ErrorDetails]:
    """Faults without the "missing" that a misspelt key brings along: it is the same fault."""
    meant = {
        (*e["loc"][:-1], nearest_name(str(e["loc"][-1]), keys_of_table(keys_only(e["loc"][:-1]))))
        for e in errors
        if e["type"] == "extra_forbidden"
    }
    return [e for e in errors if not (e["type"] == "missing" and e["loc"] in meant)]


def explain(error: ErrorDetails) -> str:
    """One line for one fault: the key, what was given, what is allowed, the nearest match."""
    loc = keys_only(error["loc"])
    key, given, kind = key_path(loc), error["input"], error["type"]
    if kind == "extra_forbidden":
        allowed = keys_of_table(loc[:-1])
        return f"{key}: unknown key{nearest(str(loc[-1]), allowed)}; allowed here: {', '.join(allowed)}"
    if kind == "missing":
        return f"{key}: missing"
    message = error["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    if kind == "value_error":
        if not loc:
            return message
        return f"{key}: {shorten(given)} given, {message}" if not isinstance(given, dict) else f"{key}: {message}"
    if kind == "literal_error":
        options = [option.strip("' ") for option in message.replace(" or ", ",").split(",")]
        return f"{key}: {shorten(given)} given, allowed: {message}{nearest(str(given), options)}"
    return f"{key}: {shorten(given)} given, allowed: {message}"


def keys_only(loc: Sequence[int | str]) -> list[int | str]:
    """Pydantic's location without the tag that says whether a number or a list was given."""
    return [part for i, part in enumerate(loc) if i == 0 or part not in (NUMBER, LIST)]


def key_path(loc: Sequence[int | str]) -> str:
    """``chain.mass_kg[2]`` from pydantic's location; lists count from 0 as in the file."""
    text = ""
    for part in loc:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.lstrip(".") or "scene"


def keys_of_table(loc: Sequence[int | str]) -> list[str]:
    """Keys that the table at `loc` may hold."""
    model: type[BaseModel] = SceneFile
    for part in loc:
        if isinstance(part, str):
            annotation: Any = model.model_fields[part].annotation
            inner = getattr(annotation, "__args__", (annotation,))
            model = next(a for a in inner if isinstance(a, type) and issubclass(a, BaseModel))
    return list(model.model_fields)


def shorten(value: object, most: int = 60) -> str:
    """Text of a given value, cut where it would fill the screen."""
    text = repr(value)
    return text if len(text) <= most else text[: most - 3] + "..."
