"""A comparison in a notebook: verdict, normalised errors, and the matrix of outcomes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.chapters.crossval.overview import SYMBOLS, agreement_panel, engine_groups, kind, summary_verdict
from reports.chapters.crossval.summary import summarise
from reports.notebook.card import MUTED, card, grid_table, picture
from reports.tables.crossval import Results

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from reports.chapters.crossval.summary import RunCell, Summary

WIDTH_PX = 400.0
COLOURS = {"pass": "#0d6b4d", "fail": "#a3261c", "gone": "#7c5200", "aside": MUTED}


def html(metrics: pd.DataFrame, external: Mapping[str, bool], report: Path | None) -> Markup:
    """HTML of a comparison from its table of metrics.

    Parameters
    ----------
    metrics : DataFrame
        Columns :data:`reports.tables.crossval.METRIC_COLUMNS`.
    external : mapping of str to bool
        Whether each engine has independent physics.
    report : Path or None
        Page of the comparison.
    """
    compared = {e: {"external": external[e]} for e in dict.fromkeys(metrics["engine"]) if e in external}
    summary = summarise(Results(Path(), metrics, {"engines": compared}))
    verdict, groups = summary_verdict(summary), engine_groups(summary)
    panel = agreement_panel(summary, groups)
    pictures = [picture(panel.svg, WIDTH_PX)] if panel else []
    where = [Markup("<p>Report: <code>{}</code></p>").format(report)] if report else []
    return card(verdict.headline, " ".join(verdict.sentences), pictures, matrix(summary), *where)


def matrix(summary: Summary) -> Markup:
    """Outcomes of all scenes and engines."""
    engines = [e for group in engine_groups(summary) for e in group.engines]
    rows = [[s.name, *(outcome(summary.cell(s.name, e)) for e in engines)] for s in summary.scenes]
    return grid_table(["Scene", *engines], rows)


def outcome(cell: RunCell | None) -> Markup:
    """One cell: sign and word, and the reason as a title."""
    if cell is None:
        return Markup("not run")
    shown = Markup('<span style="color:{}" title="{}">{} {}</span>')
    return shown.format(COLOURS[kind(cell.outcome)], cell.reason, SYMBOLS[cell.outcome], cell.word)
