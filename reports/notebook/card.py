"""Comparisons in a notebook, and the frame of every object there: light in every theme, without a style sheet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.chapters.comparison.overview import SYMBOLS, agreement_panel, engine_groups, kind, summary_verdict
from reports.chapters.comparison.summary import summarise
from reports.plotting.palette import COLOURS, PAPER
from reports.results.files import StudyTables
from reports.text.words import LAYOUT, visible

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    import pandas as pd

    from reports.chapters.comparison.overview import EngineGroup
    from reports.chapters.comparison.summary import RunCell, Summary

INK, MUTED, RULE, GRID = (COLOURS[name].light for name in ("ink", "muted", "rule", "grid"))
FRAME = (
    f"background:{PAPER[0]};color:{INK};border:1px solid {RULE};border-radius:4px;padding:.7em 1em;max-width:60em;"
    "font:13px/1.5 sans-serif;overflow-x:auto"
)
CELL = f"text-align:left;vertical-align:top;padding:.15em .9em .15em 0;border-bottom:1px solid {GRID};color:{INK}"


def card(title: str, about: str, pictures: Iterable[Markup], *parts: Markup) -> Markup:
    """HTML of an object: its title, a line about it, pictures side by side, and further parts below."""
    drawn = Markup("").join(pictures)
    row = Markup(
        '<div style="display:flex;flex-wrap:wrap;align-items:flex-start;gap:1em;margin:.5em 0">{}</div>'
    ).format(drawn)
    head = Markup('<p style="margin:0;font-size:1.15em"><strong>{}</strong></p>').format(title)
    line = Markup('<p style="margin:.1em 0;color:{}">{}</p>').format(MUTED, about) if about else Markup("")
    body = Markup("").join([head, line, row if drawn else Markup(""), *parts])
    whole = Markup('<div style="{}">{}</div>').format(FRAME, body)
    return Markup(visible(whole, but=LAYOUT))


def picture(svg: Markup, width_px: float) -> Markup:
    """Drawing with fixed colours and a size: a notebook has none of a page's variables and rules."""
    text = str(svg)
    for colour in COLOURS.values():
        text = text.replace(colour.css, colour.light)
    size = f"width:{width_px:g}px;max-width:100%;height:auto;font:11px sans-serif;overflow:visible"
    return Markup(text.replace("<svg ", f'<svg style="{size}" ', 1))


def facts_table(facts: Iterable[tuple[str, object]]) -> Markup:
    """Table of names and values."""
    row = Markup('<tr><th scope="row" style="{};font-weight:400">{}</th><td style="{}">{}</td></tr>')
    return table(row.format(f"{CELL};color:{MUTED}", name, CELL, value) for name, value in facts)


def table(rows: Iterable[Markup]) -> Markup:
    """Table of some rows."""
    style = "border-collapse:collapse;margin:.4em 0;background:transparent"
    return Markup('<table style="{}"><tbody>{}</tbody></table>').format(style, Markup("").join(rows))


WIDTH_PX = 400.0
KIND_COLOURS = {"pass": "#0d6b4d", "fail": "#a3261c", "gone": "#7c5200", "aside": MUTED}


def comparison_html(metrics: pd.DataFrame, external: Mapping[str, bool], report: Path | None) -> Markup:
    """HTML of a comparison from its table of metrics.

    Parameters
    ----------
    metrics : DataFrame
        Columns :data:`reports.results.comparison.METRIC_COLUMNS`.
    external : mapping of str to bool
        Whether each engine has independent physics.
    report : Path or None
        Page of the comparison.
    """
    compared = {e: {"external": external[e]} for e in dict.fromkeys(metrics["engine"]) if e in external}
    summary = summarise(StudyTables(Path(), {"metrics": metrics}, {"engines": compared}, "comparison"))
    verdict, groups = summary_verdict(summary), engine_groups(summary)
    panel = agreement_panel(summary, groups)
    pictures = [picture(panel.svg, WIDTH_PX)] if panel else []
    where = [Markup("<p>Report: <code>{}</code></p>").format(report)] if report else []
    return card(verdict.headline, " ".join(verdict.sentences), pictures, matrix(summary, groups), *where)


def matrix(summary: Summary, groups: Sequence[EngineGroup]) -> Markup:
    """Outcomes of all scenes and engines: a line of heads, and a line for each scene."""
    engines = [e for group in groups for e in group.engines]
    head = Markup(f'<th scope="col" style="{CELL}">{{}}</th>')
    first = Markup(f'<th scope="row" style="{CELL};font-weight:400">{{}}</th>')
    cell = Markup(f'<td style="{CELL}">{{}}</td>')
    lines = [[head.format(name) for name in ("Scene", *engines)]]
    lines += [
        [first.format(s.name), *(cell.format(outcome(summary.cell(s.name, e))) for e in engines)]
        for s in summary.scenes
    ]
    return table(Markup("<tr>{}</tr>").format(Markup("").join(line)) for line in lines)


def outcome(cell: RunCell | None) -> Markup:
    """One cell: sign and word, and the reason as a title."""
    if cell is None:
        return Markup("not run")
    shown = Markup('<span style="color:{}" title="{}">{} {}</span>')
    return shown.format(KIND_COLOURS[kind(cell.outcome)], cell.reason, SYMBOLS[cell.outcome], cell.word)
