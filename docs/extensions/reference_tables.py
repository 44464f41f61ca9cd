"""Tables of the reference in Markdown, from the code: scene keys, tables of results, outcomes, exit codes."""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING, Any

import reports.tables
from barchain.cli.common.exit_codes import MEANINGS
from reference_impl.paper.misprint_effects import misprint_effects
from reports.tables.files import StudyFiles
from reports.tables.outcome import ADVICE
from reports.text.glossary import TERMS
from scenarios.toml.file import SceneFile

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

ROUNDING = 1e-12  # far above the rounding of a dense solution in double precision, far below every effect
LIMITS = {"minimum": "≥ {}", "exclusiveMinimum": "> {}", "maximum": "≤ {}", "exclusiveMaximum": "< {}"}
NAMES = {"number": "number", "integer": "integer", "string": "text", "boolean": "true or false", "array": "list",
         "object": "table", "null": "nothing"}  # fmt: skip


def markdown_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Table in Markdown; a bar inside a cell is escaped."""
    lines = [[cell.replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    names = [*head]
    return "\n".join("| " + " | ".join(line) + " |" for line in [names, ["---"] * len(names), *lines]) + "\n"


def scene_keys() -> str:
    """Every key of a scene file, table by table."""
    schema: dict[str, Any] = SceneFile.model_json_schema()
    parts = []
    for name, table in schema_tables(schema, schema, ""):
        rows = [key_row(schema, key, value) for key, value in table.get("properties", {}).items()
                if target(schema, value).get("type") != "object"]  # fmt: skip
        if rows:
            title = f"`[{name}]`" if name else "Top level"
            text = table.get("description", "") if name else ""
            parts.append(f"## {title}\n\n{text}\n\n{markdown_table(('key', 'allowed', 'default', 'meaning'), rows)}")
    return "\n".join(parts)


def schema_tables(schema: dict[str, Any], table: dict[str, Any], name: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """A table and all tables below it, each with its name in a file."""
    yield name, table
    for key, value in table.get("properties", {}).items():
        for each in alternatives(schema, value):
            below = f"{name}.{key}".strip(".")
            if each.get("type") == "object" and "properties" in each:
                yield from schema_tables(schema, each, below)
            inner = target(schema, each.get("items", {}))
            if each.get("type") == "array" and "properties" in inner:
                yield from schema_tables(schema, inner, f"[{below}]")


def alternatives(schema: dict[str, Any], value: dict[str, Any]) -> list[dict[str, Any]]:
    """Schemas that a value may follow."""
    several = value.get("anyOf") or value.get("oneOf") or [value]
    return [target(schema, each) for each in several]


def target(schema: dict[str, Any], value: dict[str, Any]) -> dict[str, Any]:
    """Schema itself, where a reference stands for it."""
    name = value.get("$ref", "").rpartition("/")[2]
    found: dict[str, Any] = schema["$defs"][name] if name else value
    return found


def key_row(schema: dict[str, Any], key: str, value: dict[str, Any]) -> list[str]:
    """Row of one key."""
    allowed = " or ".join(dict.fromkeys(allowed_words(schema, each) for each in alternatives(schema, value)))
    default = f"`{value['default']}`" if value.get("default") is not None else ""
    return [f"`{key}`", allowed, default, value.get("description", "")]


def allowed_words(schema: dict[str, Any], value: dict[str, Any]) -> str:
    """Type and limits of a value."""
    if "enum" in value:
        return ", ".join(f"`{each}`" for each in value["enum"])
    if "const" in value:
        return f"`{value['const']}`"
    kind = NAMES.get(str(value.get("type", "")), "table")
    if kind == "list":
        return f"list of {' or '.join(allowed_words(schema, e) for e in alternatives(schema, value.get('items', {})))}"
    limits = [words.format(f"{value[key]:g}") for key, words in LIMITS.items() if key in value]
    return f"{kind} {', '.join(limits)}".strip()


def result_tables() -> str:
    """Files and columns of every kind of result."""
    parts = []
    for files in sorted(all_study_files(), key=lambda f: f.study):
        rows = [(f"`{name}.csv`", ", ".join(f"`{column}`" for column in columns) or "follow from the data")
                for name, columns in files.tables.items()]  # fmt: skip
        where = f"in the folder `{files.study}/`" if files.study else "in the result folder itself"
        parts.append(f"## {files.name}\n\nTables lie {where}, with `record.json`.\n\n"
                     f"{markdown_table(('file', 'columns'), rows)}")  # fmt: skip
    return "\n".join(parts)


def all_study_files() -> Iterator[StudyFiles]:
    """Descriptions of all result folders, found in the modules of tables."""
    for module in pkgutil.walk_packages(reports.tables.__path__, "reports.tables."):
        found = getattr(importlib.import_module(module.name), "FILES", None)
        if isinstance(found, StudyFiles):
            yield found


def outcomes() -> str:
    """Outcomes with their meaning."""
    rows = [(f"`{outcome}`", "yes" if outcome.ok else "no", advice) for outcome, advice in ADVICE.items()]
    return markdown_table(("outcome", "exit code 0", "meaning and remedy"), rows)


def exit_codes() -> str:
    """Exit codes with their meaning."""
    return markdown_table(("code", "meaning"), ((str(int(code)), words) for code, words in MEANINGS.items()))


def glossary() -> str:
    """Every term that a report explains."""
    return markdown_table(("term", "meaning"), ((term, TERMS[term]) for term in sorted(TERMS, key=str.casefold)))


def misprints() -> str:
    """The paper's misprints with the change of reactions and of phi'' that each makes in a generic state."""
    head = ("place", "printed", "correct", "change of reactions", "change of phi''", "consequence and reason")
    return markdown_table(head, (
        (r.place, r.printed, r.right, share(r.effect_on_reactions), share(r.effect_on_angular_acceleration), r.note)
        for r in misprint_effects()
    ))  # fmt: skip


def share(value: float | None) -> str:
    """A relative change; below rounding it is zero."""
    if value is None:
        return "–"
    return "0" if value < ROUNDING else f"{value:.3g}"


TABLES: dict[str, Callable[[], str]] = {
    "glossary": glossary,
    "misprints": misprints,
    "scene-keys": scene_keys,
    "result-tables": result_tables,
    "outcomes": outcomes,
    "exit-codes": exit_codes,
}
