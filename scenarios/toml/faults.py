"""Faults of a file of tables in words: one line each, with key, given and allowed values, nearest name.

The file is a scene, or of another model (`root`) that is made of the same kinds of tables.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, get_origin

from pydantic import BaseModel

from scenarios.nearest import nearest, nearest_name
from scenarios.size_limits import MOST_FAULTS, MOST_KEY
from scenarios.text import shorten, visible
from scenarios.toml.effect_tables import LIST, NUMBER
from scenarios.toml.file import SceneFile
from scenarios.toml.usual_names import usual_name

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

CONSIDERED = 10 * MOST_FAULTS  # of a file's faults; a nearest name is looked for in each

NUMBERS = {"float_type": "a number", "int_type": "a whole number"}
"""Kinds of faults of a value that is no number, and the words for what is allowed"""

BOUNDS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}
"""Kinds of faults of a number outside its bounds, and for each the words before the bound and its name in the fault"""


def fault_lines(error: ValidationError, root: type[BaseModel] = SceneFile) -> list[str]:
    """Lines on faults of a file, at most :data:`~scenarios.size_limits.MOST_FAULTS`, and how many more there are."""
    faults = error.errors()[:CONSIDERED]
    lines = [line for fault in without_echoes(faults, root) for line in explain(fault, root).split("\n")]
    more = len(lines) - MOST_FAULTS + error.error_count() - len(faults)
    return lines if more <= 0 else [*lines[:MOST_FAULTS], f"{more} more faults"]


def without_echoes(errors: list[ErrorDetails], root: type[BaseModel]) -> list[ErrorDetails]:
    """Faults without the "missing" of a key that was misspelt: the two are the same fault."""
    meant = {
        (*e["loc"][:-1], nearest_name(str(e["loc"][-1]), keys_of_table(keys_only(e["loc"][:-1]), root)))
        for e in errors
        if e["type"] == "extra_forbidden"
    }
    return [e for e in errors if not (e["type"] == "missing" and e["loc"] in meant)]


def explain(error: ErrorDetails, root: type[BaseModel]) -> str:
    """One line for one fault: key, given value, allowed values, nearest match."""
    loc = keys_only(error["loc"])
    key, given, kind = key_path(loc), error["input"], error["type"]
    if kind == "extra_forbidden":
        allowed, there = keys_of_table(loc[:-1], root), elsewhere(str(loc[-1]), root, table=is_table(given))
        meant = f" (did you mean {there}?)" if there else nearest(str(loc[-1]), allowed)
        usual = usual_name(loc) if root is SceneFile else None
        meant = f"; {usual}" if usual else meant
        return f"{key}: unknown key{meant}; allowed here: {', '.join(allowed)}"
    if kind in ("missing", "json_invalid"):
        return f"{key}: missing" if kind == "missing" else f"no JSON: {error['ctx']['error']}"
    if kind == "string_too_long":
        return f"{key}: {len(given)} characters given, allowed: at most {error['ctx']['max_length']}"
    if kind == "too_long":
        return f"{key}: {len(given)} tables or values given, allowed: at most {error['ctx']['max_length']}"
    message = error["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    if kind == "value_error":
        return explain_value(loc, given, message)
    if kind in BOUNDS:
        words, name = BOUNDS[kind]
        bound = error["ctx"][name]
        message = f"{words} {bound if isinstance(bound, int) else f'{bound:g}'}"
    if kind in NUMBERS:
        message = NUMBERS[kind] + (" without quotes" if isinstance(given, str) else "")
    if loc and kind in ("model_type", "list_type"):
        message = header(loc, root) or message
    if kind == "literal_error":
        options = [option.strip("' ") for option in message.replace(" or ", ",").split(",")]
        message += nearest(str(given), options)
    return f"{f'{key}: ' if loc else ''}{kind_of(given)} given, allowed: {message}"


def explain_value(loc: Sequence[int | str], given: object, message: str) -> str:
    """One line for a fault that one of the checks found; its message may tell what is given itself."""
    if not loc:
        return message
    told = isinstance(given, dict) or " given, allowed" in message
    return f"{key_path(loc)}: {message}" if told else f"{key_path(loc)}: {shorten(given)} given, {message}"


def kind_of(value: object) -> str:
    """Given value in TOML's terms."""
    if isinstance(value, bool):
        return str(value).lower()
    return "one table" if isinstance(value, dict) else shorten(value)


def header(loc: Sequence[int | str], root: type[BaseModel]) -> str:
    """Syntax of the table at `loc`, ``a table, write [effects.drag]``; empty if the key holds no table."""
    names = [part for part in loc if isinstance(part, str)]
    path, annotation = ".".join(names), table_at(names[:-1], root).model_fields[names[-1]].annotation
    if not tables_in(annotation):
        return ""
    if get_origin(annotation) is list:
        return f"any number of tables, write [[{path}]]"
    return f"a table, write [{path}]"


def is_table(value: object) -> bool:
    """Whether a value is a table or a list of tables."""
    return isinstance(value[0] if isinstance(value, list) and value else value, dict)


def elsewhere(name: str, root: type[BaseModel], *, table: bool) -> str | None:
    """Path of a key, or of a table, of that name in another table: ``effects.drag`` for ``drag``; None without."""
    waiting: list[list[str]] = [[]]
    while waiting:  # from the outermost tables on
        path = waiting.pop(0)
        fields = table_at(path, root).model_fields
        if path and name in fields and bool(tables_in(fields[name].annotation)) == table:
            return ".".join([*path, name])
        waiting += [[*path, key] for key, field in fields.items() if tables_in(field.annotation)]
    return None


def keys_only(loc: Sequence[int | str]) -> list[int | str]:
    """Pydantic's location without the tag of a number or a list."""
    return [part for i, part in enumerate(loc) if i == 0 or part not in (NUMBER, LIST)]


def key_path(loc: Sequence[int | str]) -> str:
    """``chain.mass_kg[2]`` from pydantic's location; lists count from 1, as bars do."""
    text = ""
    for part in loc:
        text += f"[{part + 1}]" if isinstance(part, int) else f".{visible(part, MOST_KEY)}"
    return text.lstrip(".") or "scene"


def keys_of_table(loc: Sequence[int | str], root: type[BaseModel]) -> list[str]:
    """Keys that the table at `loc` may hold."""
    return [field.alias or name for name, field in table_at(loc, root).model_fields.items()]


def table_at(loc: Sequence[int | str], root: type[BaseModel]) -> type[BaseModel]:
    """Model of the table at `loc`."""
    model = root
    for part in loc:
        if isinstance(part, str):
            model = tables_in(model.model_fields[part].annotation)[0]
    return model


def tables_in(annotation: Any) -> list[type[BaseModel]]:
    """Models that a field may hold, by itself or in a list."""
    inner = getattr(annotation, "__args__", (annotation,))
    return [a for a in inner if isinstance(a, type) and issubclass(a, BaseModel)]
