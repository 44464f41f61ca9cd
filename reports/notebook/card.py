"""Frame of an object in a notebook: light in every theme, without a style sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.plotting.palette import COLOURS, PAPER
from reports.text.visible import LAYOUT, visible

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

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


def grid_table(heads: Sequence[object], rows: Iterable[Sequence[object]]) -> Markup:
    """Table with a line of heads; the first cell of each row is a head, too."""
    head = Markup(f'<th scope="col" style="{CELL}">{{}}</th>')
    first = Markup(f'<th scope="row" style="{CELL};font-weight:400">{{}}</th>')
    cell = Markup(f'<td style="{CELL}">{{}}</td>')
    lines = [[head.format(h) for h in heads], *([first.format(r[0]), *map(cell.format, r[1:])] for r in rows)]
    return table(Markup("<tr>{}</tr>").format(Markup("").join(line)) for line in lines)


def table(rows: Iterable[Markup]) -> Markup:
    """Table of some rows."""
    style = "border-collapse:collapse;margin:.4em 0;background:transparent"
    return Markup('<table style="{}"><tbody>{}</tbody></table>').format(style, Markup("").join(rows))
