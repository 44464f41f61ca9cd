"""Tables of the keys of a scene file, from its JSON Schema: type, unit, default, allowed values, meaning."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenarios.key_words import unit
from scenarios.size_limits import BARS, MOST_MAGNITUDE
from scenarios.toml.file import SceneFile

if TYPE_CHECKING:
    from collections.abc import Iterator

    Schema = dict[str, Any]

HEAD = ("key", "type", "unit", "default", "allowed", "meaning")
NONE = "–"
SINGLE = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "table",
}
SEVERAL = {"number": "numbers", "integer": "whole numbers", "string": "texts", "object": "tables"}
WORDS = re.compile(r"(?:^|[;,] )((?:required unless [^;,]+)|(?:[^;,]+(?= by default)))")
"""Default in a key's description: ``required unless ...``, or the words before ``by default``"""


def key_tables() -> Iterator[tuple[str, str, list[list[str]]]]:
    """Title, description and rows of every table of a scene file."""
    schema: Schema = SceneFile.model_json_schema()
    for name, table in schema_tables(schema, schema, ""):
        required = table.get("required", [])
        rows = [row(schema, key, value, required=key in required) for key, value in table["properties"].items()]
        yield f"`[{name}]`" if name else "Top level", table.get("description", "") if name else "", rows


def schema_tables(schema: Schema, table: Schema, name: str) -> Iterator[tuple[str, Schema]]:
    """A table and all tables below it, each with its name in a file."""
    yield name, table
    for key, value in table["properties"].items():
        for kind in kinds(schema, value):
            below, inner = f"{name}.{key}".strip("."), target(schema, kind.get("items", {}))
            if "properties" in kind:
                yield from schema_tables(schema, kind, below)
            if "properties" in inner:
                yield from schema_tables(schema, inner, f"[{below}]")


def row(schema: Schema, key: str, value: Schema, *, required: bool) -> list[str]:
    """Cells of one key."""
    found = kinds(schema, value)
    limits = [allowed(schema, kind) for kind in found]
    meaning = value.get("description") or next((k["description"] for k in found if "description" in k), "")
    return [
        f"`{key}`",
        " or ".join(type_words(schema, kind) for kind in found),
        "periods" if key == "orbits" else unit(key) or NONE,
        "required" if required else default(found, value),
        range_of_bars() if key == "bars" else "; ".join(dict.fromkeys(filter(None, limits))) or NONE,
        meaning,
    ]


def kinds(schema: Schema, value: Schema) -> list[Schema]:
    """Schemas that a value may follow, none of them a choice or the missing value."""
    several = value.get("anyOf") or value.get("oneOf")
    if several:
        return [kind for each in several for kind in kinds(schema, each)]
    found = target(schema, value)
    return [] if found.get("type") == "null" else [found]


def target(schema: Schema, value: Schema) -> Schema:
    """Schema itself, where a reference stands for it."""
    name = value.get("$ref", "").rpartition("/")[2]
    found: Schema = schema["$defs"][name] if name else value
    return found


def type_words(schema: Schema, kind: Schema) -> str:
    """Type of a value in words."""
    if kind.get("type") != "array":
        return "one of the words allowed" if "enum" in kind else SINGLE[kind["type"]]
    inner = target(schema, kind["items"])
    if inner["type"] == "array":
        return f"list of pairs of {SEVERAL[inner['items']['type']]}"
    return f"list of {SEVERAL[inner['type']]}"


def default(found: list[Schema], value: Schema) -> str:
    """Value of a key that is left out, in TOML or in words."""
    given = value.get("default")
    if isinstance(given, bool):
        return f"`{str(given).lower()}`"
    if isinstance(given, str):
        return f'`"{given}"`'
    if given is not None:
        return f"{given:.12g}"
    said = WORDS.search(value.get("description", ""))
    if said:
        return said[1]
    if any(kind["type"] == "array" for kind in found):
        return "empty list" if "default" not in value else "none"
    tables = [kind for kind in found if kind["type"] == "object"]
    return "the defaults of its keys" if tables and "default" not in value else "none"


def allowed(schema: Schema, kind: Schema) -> str:
    """Allowed values of a kind in words; empty where all of its type are."""
    if kind.get("type") == "array":
        most = kind.get("maxItems", 2)
        inner = allowed(schema, target(schema, kind["items"]))
        return "; ".join(filter(None, [inner, f"at most {most} of them" if most > 2 else ""]))
    if "enum" in kind:
        return ", ".join(f'`"{each}"`' for each in kind["enum"])
    if kind["type"] == "string":
        return f"{kind.get('minLength', 0)} to {kind['maxLength']} characters"
    return numbers(kind) if kind["type"] in ("number", "integer") else ""


def numbers(kind: Schema) -> str:
    """``above 0``, ``0 to 1``, ``from 2``; the magnitudes beyond all physics are told once, above the tables."""
    most = kind.get("maximum", MOST_MAGNITUDE)
    upper = "" if most == MOST_MAGNITUDE else f"{most:,.0f}".replace(",", " ")
    if "exclusiveMinimum" in kind:
        return f"above {kind['exclusiveMinimum']:g}" + (f" to {upper}" if upper else "")
    least = kind.get("minimum", -MOST_MAGNITUDE)
    if least == -MOST_MAGNITUDE:
        return f"up to {upper}" if upper else "any number"
    return f"{least:g} to {upper}" if upper else f"{least:g} or more"


def range_of_bars() -> str:
    """Allowed numbers of bars, which an environment variable changes."""
    return f"1 to {BARS.usual:,}".replace(",", " ") + f", or `{BARS.variable}`"
