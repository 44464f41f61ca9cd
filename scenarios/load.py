"""Loading of a :class:`~scenarios.scene.Scene` by name or file, with errors that name the remedy."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_origin

from pydantic import BaseModel, ValidationError

from scenarios.toml.effect_tables import LIST, NUMBER
from scenarios.toml.file import SceneFile
from scenarios.toml.resolve import IncompleteError, resolve

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from pydantic_core import ErrorDetails

    from scenarios.scene import Scene

SHIPPED = Path(__file__).parent
LIKE_ENOUGH = 0.6  # difflib's default: a less similar suggestion would be a guess


class SceneError(ValueError):
    """Invalid or missing scene; the message names the file, the key, the given and the allowed values."""


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
        Folders that names are looked up in, first match wins; the shipped scenes by default.

    Returns
    -------
    Scene
        Complete and frozen, in SI units and radians.

    Raises
    ------
    SceneError
        If there is no such scene, or its file is not valid; the message has one line for each fault.
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
    match = nearest_scene(str(scene), names)
    meant = f" (did you mean {match}?)" if match else ""
    raise SceneError(f"{scene}: no such scene{meant}; `barchain scenes` lists all scenes, or give a file's path")


def read_text(path: Path) -> str:
    """Text of a scene file.

    Raises
    ------
    SceneError
        If the file can't be read.
    """
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: can't be read: {error}") from error


def parse_scene(text: str, *, name: str, file: str) -> Scene:
    """Validate the TOML `text` of a scene; error messages begin with `file`.

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


def nearest_scene(given: str, names: Iterable[str]) -> str | None:
    """Scene whose name without folder is nearest to `given`; among equals the scene with the nearest folder."""

    def base(name: str) -> str:
        return name.rpartition("/")[2]

    known = list(names)
    match = nearest_name(base(given), map(base, known))
    return None if match is None else nearest_of(given, [name for name in known if base(name) == match])


def nearest_name(given: str, allowed: Iterable[str]) -> str | None:
    """Allowed name nearest to `given`, the first of equals; None if no name is similar."""
    best = nearest_of(given, allowed)
    return best if best is not None and likeness(given, best) >= LIKE_ENOUGH else None


def nearest_of(given: str, allowed: Iterable[str]) -> str | None:
    """Allowed name nearest to `given`, however far, the first of equals; None if there is none."""
    return max(sorted(allowed), key=lambda name: likeness(given, name), default=None)


def likeness(a: str, b: str) -> float:
    """Similarity of two names, 0 to 1, ignoring case."""
    return difflib.SequenceMatcher(None, a.lower(), b.lower()).ratio()


def without_echoes(errors: list[ErrorDetails]) -> list[ErrorDetails]:
    """Faults without the "missing" of a key that was misspelt: the two are the same fault."""
    meant = {
        (*e["loc"][:-1], nearest_name(str(e["loc"][-1]), keys_of_table(keys_only(e["loc"][:-1]))))
        for e in errors
        if e["type"] == "extra_forbidden"
    }
    return [e for e in errors if not (e["type"] == "missing" and e["loc"] in meant)]


def explain(error: ErrorDetails) -> str:
    """One line for one fault: key, given value, allowed values, nearest match."""
    loc = keys_only(error["loc"])
    key, given, kind = key_path(loc), error["input"], error["type"]
    if kind == "extra_forbidden":
        allowed, there = keys_of_table(loc[:-1]), elsewhere(str(loc[-1]), table=is_table(given))
        meant = f" (did you mean {there}?)" if there else nearest(str(loc[-1]), allowed)
        return f"{key}: unknown key{meant}; allowed here: {', '.join(allowed)}"
    if kind == "missing":
        return f"{key}: missing"
    message = error["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    if kind == "value_error":
        if not loc:
            return message
        return f"{key}: {shorten(given)} given, {message}" if not isinstance(given, dict) else f"{key}: {message}"
    if kind in ("model_type", "list_type"):
        message = header(loc) or message
    if kind == "literal_error":
        options = [option.strip("' ") for option in message.replace(" or ", ",").split(",")]
        message += nearest(str(given), options)
    return f"{key}: {kind_of(given)} given, allowed: {message}"


def kind_of(value: object) -> str:
    """Given value in TOML's terms."""
    if isinstance(value, bool):
        return str(value).lower()
    return "one table" if isinstance(value, dict) else shorten(value)


def header(loc: Sequence[int | str]) -> str:
    """Syntax of the table at `loc`, ``a table, write [effects.drag]``; empty if the key holds no table."""
    names = [part for part in loc if isinstance(part, str)]
    path, annotation = ".".join(names), table_at(names[:-1]).model_fields[names[-1]].annotation
    if not tables_in(annotation):
        return ""
    if get_origin(annotation) is list:
        return f"any number of tables, write [[{path}]]"
    return f"a table, write [{path}]"


def is_table(value: object) -> bool:
    """Whether a value is a table or a list of tables."""
    return isinstance(value[0] if isinstance(value, list) and value else value, dict)


def elsewhere(name: str, *, table: bool) -> str | None:
    """Path of a key, or of a table, of that name in another table: ``effects.drag`` for ``drag``; None without."""
    waiting: list[list[str]] = [[]]
    while waiting:  # from the outermost tables on
        path = waiting.pop(0)
        fields = table_at(path).model_fields
        if path and name in fields and bool(tables_in(fields[name].annotation)) == table:
            return ".".join([*path, name])
        waiting += [[*path, key] for key, field in fields.items() if tables_in(field.annotation)]
    return None


def keys_only(loc: Sequence[int | str]) -> list[int | str]:
    """Pydantic's location without the tag of a number or a list."""
    return [part for i, part in enumerate(loc) if i == 0 or part not in (NUMBER, LIST)]


def key_path(loc: Sequence[int | str]) -> str:
    """``chain.mass_kg[2]`` from pydantic's location; lists count from 0 as in the file."""
    text = ""
    for part in loc:
        text += f"[{part}]" if isinstance(part, int) else f".{part}"
    return text.lstrip(".") or "scene"


def keys_of_table(loc: Sequence[int | str]) -> list[str]:
    """Keys that the table at `loc` may hold."""
    return list(table_at(loc).model_fields)


def table_at(loc: Sequence[int | str]) -> type[BaseModel]:
    """Model of the table at `loc`."""
    model: type[BaseModel] = SceneFile
    for part in loc:
        if isinstance(part, str):
            model = tables_in(model.model_fields[part].annotation)[0]
    return model


def tables_in(annotation: Any) -> list[type[BaseModel]]:
    """Models that a field may hold, by itself or in a list."""
    inner = getattr(annotation, "__args__", (annotation,))
    return [a for a in inner if isinstance(a, type) and issubclass(a, BaseModel)]


def shorten(value: object, most: int = 60) -> str:
    """Text of a given value, cut to `most` characters."""
    text = repr(value)
    return text if len(text) <= most else text[: most - 3] + "..."
