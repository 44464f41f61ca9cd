"""Tables of the reference in Markdown, from the code: scene keys, tables of results, outcomes, exit codes."""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING

from scene_keys import HEAD, key_tables

import reports.tables
from barchain.cli.common.exit_codes import MEANINGS
from reference_impl.paper.misprint_effects import misprint_effects
from reports.tables.files import StudyFiles
from reports.tables.outcome import ADVICE
from reports.text.glossary import TERMS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

ROUNDING = 1e-12  # far above the rounding of a dense solution in double precision, far below every effect


def markdown_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Table in Markdown; a bar inside a cell is escaped."""
    lines = [[cell.replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    names = [*head]
    return "\n".join("| " + " | ".join(line) + " |" for line in [names, ["---"] * len(names), *lines]) + "\n"


def scene_keys() -> str:
    """Every key of a scene file, table by table."""
    return "\n".join(f"## {title}\n\n{text}\n\n{markdown_table(HEAD, rows)}" for title, text, rows in key_tables())


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
