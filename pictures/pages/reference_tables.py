"""Tables of the reference, from the code: scene keys, tables of results, exit codes, terms, misprints."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from barchain.cli.common.exit_codes import MEANINGS
from pictures.pages.words import table
from reference_impl.paper.misprint_effects import misprint_effects
from reports.results.studies import STUDIES
from reports.text.glossary import FIELD, TERMS
from scenarios.channels import IN_COLUMN_ORDER, TIME
from scenarios.derived_channels import DERIVED
from scenarios.toml.key_tables import HEAD, key_tables

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from scenarios.channels import Channel

ROUNDING = 1e-12  # far above the rounding of a dense solution in double precision, far below every effect


def scene_keys() -> str:
    """Every key of a scene file, table by table."""
    parts = ((f"## {title}", text, table(HEAD, rows)) for title, text, rows in key_tables())
    return "\n\n".join(part for three in parts for part in three if part)


def result_tables() -> str:
    """Rows and series of every study."""
    parts = []
    for files in sorted(STUDIES, key=lambda f: f.study):
        rows = [
            (name, of.metric or "metric", words(of.index), ", ".join(f"`{k}` = `{v}`" for k, v in of.cells.items()))
            for name, of in files.tables.items()
        ]
        rows += [(files.series_name(name), "a series", "", words(columns)) for name, columns in files.series.items()]
        parts.append(f"## {files.study}\n\n{table(('table', 'metric', 'told apart by', 'columns'), rows)}\n")
    return "\n".join(parts)


def words(columns: Iterable[str]) -> str:
    """Names of columns, as code."""
    return ", ".join(f"`{column}`" for column in columns)


def stored_channels() -> str:
    """Channels that a trajectory stores, in the order of their columns."""
    rows = [("time", f"`{TIME}`", "s", "Instant of the sample.", "")]
    rows += [(f"`{c.name}`", columns_of(c), c.unit, c.meaning, c.judged) for c in IN_COLUMN_ORDER]
    return table(("channel", "columns", "unit", "content", "judged by"), rows)


def derived_channels() -> str:
    """Channels that are computed on request."""
    rows = [(f"`{c.name}`", columns_of(c), c.unit, c.meaning) for c in DERIVED]
    return table(("channel", "columns", "unit", "content"), rows)


def columns_of(channel: Channel) -> str:
    """Columns of a channel, those of its first bar or joint where there are several."""
    return words(column.format(1) for column in channel.columns) + (" …" if channel.of.numbered else "")


def exit_codes() -> str:
    """Exit codes with their meaning."""
    return table(("code", "meaning"), ((str(int(code)), words) for code, words in MEANINGS.items()))


def glossary(terms: Mapping[str, str]) -> str:
    """Terms with their meanings, in alphabetical order."""
    return table(("term", "meaning"), ((term, terms[term]) for term in sorted(terms, key=str.casefold)))


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
    "glossary": partial(glossary, TERMS),
    "terms-of-the-field": partial(glossary, FIELD),
    "misprints": misprints,
    "scene-keys": scene_keys,
    "result-tables": result_tables,
    "stored-channels": stored_channels,
    "derived-channels": derived_channels,
    "exit-codes": exit_codes,
}
"""Tables by their names"""
