"""Tables of the reference, from the code: scene keys, tables of results, exit codes, terms, misprints."""

from __future__ import annotations

import importlib
import pkgutil
from typing import TYPE_CHECKING

import reports.tables
from barchain.cli.common.exit_codes import MEANINGS
from pictures.pages.scene_keys import HEAD, key_tables
from pictures.pages.words import table
from reference_impl.paper.misprint_effects import misprint_effects
from reports.tables.files import StudyFiles
from reports.text.glossary import TERMS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

ROUNDING = 1e-12  # far above the rounding of a dense solution in double precision, far below every effect


def scene_keys() -> str:
    """Every key of a scene file, table by table."""
    parts = ((f"## {title}", text, table(HEAD, rows)) for title, text, rows in key_tables())
    return "\n\n".join(part for three in parts for part in three if part)


def result_tables() -> str:
    """Files and columns of every kind of result."""
    parts = []
    for files in sorted(all_study_files(), key=lambda f: f.study):
        rows = [(f"`{name}.csv`", ", ".join(f"`{column}`" for column in columns) or "follow from the data")
                for name, columns in files.tables.items()]  # fmt: skip
        where = f"in the folder `{files.study}/`" if files.study else "in the result folder itself"
        parts.append(f"## {files.name}\n\nTables lie {where}, with `record.json`.\n\n"
                     f"{table(('file', 'columns'), rows)}\n")  # fmt: skip
    return "\n".join(parts)


def all_study_files() -> Iterator[StudyFiles]:
    """Descriptions of all result folders, found in the modules of tables."""
    for module in pkgutil.walk_packages(reports.tables.__path__, "reports.tables."):
        found = getattr(importlib.import_module(module.name), "FILES", None)
        if isinstance(found, StudyFiles):
            yield found


def exit_codes() -> str:
    """Exit codes with their meaning."""
    return table(("code", "meaning"), ((str(int(code)), words) for code, words in MEANINGS.items()))


def glossary() -> str:
    """Every term that a report explains."""
    return table(("term", "meaning"), ((term, TERMS[term]) for term in sorted(TERMS, key=str.casefold)))


def misprints() -> str:
    """The paper's misprints with the change of reactions and of phi'' that each makes in a generic state."""
    head = ("place", "printed", "correct", "change of reactions", "change of phi''", "consequence and reason")
    return table(head, (
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
    "exit-codes": exit_codes,
}
"""Tables by their names"""
