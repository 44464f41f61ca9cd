"""Log-log charts of errors: named objects along the top, shaded where no digit is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.roundoff.series import LOST
from reports.plotting.palette import COLOURS
from reports.plotting.panels import Legend, Panel
from reports.plotting.svg import BOTTOM, LEFT, RIGHT, TOP, WIDTH, Chart, Scale
from reports.text.numerals import as_given

if TYPE_CHECKING:
    from reports.chapters.roundoff.series import NamedObject
    from reports.plotting.families import Flags
    from reports.plotting.palette import Pen
    from reports.plotting.series import Array

PLOT_HEIGHT = 205.0
NAME_SIZE, NAME_ROW, NAME_GAP = 10.0, 12.5, 5.0
LETTER = 0.54
"""Mean width of a letter, of its size"""
LARGEST = 1  # decade: larger relative errors are not drawn
FAR_AWAY = 1e30  # ordinate of infinite errors, outside the axes
BOUND = 0.18
MARKER_SIZE, RING_SIZE = 4.6, 10.0
MOST_MARKERS = 14
MARGIN = 0.22  # decades beyond the first and the last point


@dataclass(frozen=True)
class ErrorCurve:
    """Medians of errors, with their quantiles and fit."""

    x: Array
    """(n,) rising"""
    y: Array
    """(n,); infinite where a run diverged"""
    pen: Pen
    bound: tuple[Array, Array] | None = None
    """(n,) each: quantiles"""
    fit: tuple[Array, Array] | None = None
    """A thin line"""
    ringed: Flags | None = None
    """(n,) bool: smallest error that round-off allows"""
    blurred: Flags | None = None
    """(n,) bool: drawn hollow"""


@dataclass(frozen=True)
class Sheet:
    """Labels and axes of a chart."""

    name: str
    title: str
    x_label: str
    y_label: str
    named: tuple[NamedObject, ...] = ()
    ticks: tuple[float, ...] = ()
    """Of the horizontal axis; powers of ten if empty"""
    reverse: bool = False
    """Whether the horizontal axis falls to the right"""
    in_digits: bool = False
    """Whether the vertical axis counts digits, evenly"""


def panel(sheet: Sheet, curves: list[ErrorCurve], legend: tuple[Legend, ...], note: str = "") -> Panel | None:
    """Chart; None if there is nothing to draw."""
    shown = [c for c in curves if (np.isfinite(c.y) & (c.y > 0.0)).any()]
    if not shown:
        return None
    x = np.concatenate([c.x for c in shown])
    ends = 10.0 ** (np.log10(x.min()) - MARGIN), 10.0 ** (np.log10(x.max()) + MARGIN)
    names = [n for n in sheet.named if ends[0] < n.ratio < ends[1]]
    rows = staggered([(place(n.ratio, ends), width(n.name)) for n in names])
    chart = axes(sheet, shown, ends, NAME_ROW * (max(rows, default=-1) + 1))
    for thing, row in zip(names, rows, strict=True):
        write_name(chart, thing, row, ends)
    for curve in shown:
        draw(chart, curve)
    return Panel(sheet.title, chart.svg(sheet.title, sheet.name), note, legend)


def axes(sheet: Sheet, curves: list[ErrorCurve], ends: tuple[float, float], names_height: float) -> Chart:
    """Empty axes, shaded where no digit is left, with room for the names above."""
    top = TOP + names_height + (3.0 if names_height else 0.0)
    x_ends = ends[::-1] if sheet.reverse else ends
    low, high = (0.0, 1.08 * max(float(c.y.max()) for c in curves)) if sheet.in_digits else heights(curves)
    y = Scale(low, high, top + PLOT_HEIGHT, top, not sheet.in_digits)
    chart = Chart(Scale(*x_ends, LEFT, WIDTH - RIGHT, log=True), y, (WIDTH, top + PLOT_HEIGHT + BOTTOM))
    lost = (0.0, 1.0) if sheet.in_digits else (max(LOST, low), high)
    if lost[0] < high:
        chart.area((chart.x.start, chart.x.end), (float(y(lost[0])), float(y(lost[1]))), COLOURS["body"])
    chart.ticks_up(y.ticks, sheet.y_label, top - TOP + 9.0)
    if not sheet.in_digits and high > 1.0:
        chart.across_at(1.0, COLOURS["rule"])
    given = [(t, as_given(t)) for t in sheet.ticks if ends[0] < t < ends[1]]
    chart.ticks_across(given or chart.x.ticks, sheet.x_label)
    return chart


def heights(curves: list[ErrorCurve]) -> tuple[float, float]:
    """Whole decades around the errors, but none beyond :data:`LARGEST`."""
    edges = [edge for c in curves for edge in (c.y, *(c.bound or ()))]
    values = np.concatenate([e[np.isfinite(e) & (e > 0.0)] for e in edges])
    high = min(int(np.ceil(np.log10(values.max()))), LARGEST)
    low = min(int(np.floor(np.log10(values.min()))), high - 2)
    return 10.0**low, 10.0**high


def draw(chart: Chart, curve: ErrorCurve) -> None:
    """Draw one curve over its quantiles, with its fit and its marks."""
    colour, pen = curve.pen.colour, curve.pen
    y = np.where(np.isinf(curve.y), FAR_AWAY, curve.y)
    if curve.bound is not None:
        low, high = (np.where(np.isinf(edge), FAR_AWAY, edge) for edge in curve.bound)
        chart.band(curve.x, low, high, colour, BOUND)
    if curve.fit is not None:
        chart.line(*curve.fit, colour, 0.6)
    chart.line(curve.x, y, colour, 1.4, pen.dash)
    hollow = np.zeros(len(y), bool) if curve.blurred is None else curve.blurred
    each = max(1, int(np.ceil(len(y) / MOST_MARKERS)))
    marked = np.arange(len(y)) % each == 0
    if pen.marker:
        for outlined, at in ((False, marked & ~hollow), (True, marked & hollow)):
            chart.marks(curve.x[at], y[at], pen.marker, colour, MARKER_SIZE, hollow=outlined)
    if curve.ringed is not None:
        chart.marks(curve.x[curve.ringed], y[curve.ringed], "o", colour, RING_SIZE, hollow=True, edge=1.1)


def place(value: float, ends: tuple[float, float]) -> float:
    """Distance from the left edge of the plot, px."""
    share = np.log(value / ends[0]) / np.log(ends[1] / ends[0])
    return float(share) * (WIDTH - LEFT - RIGHT)


def width(text: str) -> float:
    """Width of a name in a wide font, px."""
    return LETTER * NAME_SIZE * len(text)


def staggered(names: list[tuple[float, float]]) -> list[int]:
    """Rows of names, counted upwards, so that no name hides another name or, if possible, its line.

    Parameters
    ----------
    names : list of tuple of float
        Place and width of each, pixels.
    """
    boxes = [box(at, wide) for at, wide in names]
    rows: list[int] = []
    for k, (at, _) in enumerate(names):
        others = [(names[j][0], boxes[j], rows[j]) for j in range(k)]
        found = (row for row in range(k + 1) if free(row, at, boxes[k], others))
        rows.append(next(found, max(rows, default=-1) + 1))
    return rows


def free(row: int, at: float, own: tuple[float, float], others: list[tuple[float, tuple[float, float], int]]) -> bool:
    """Whether a name may stand in a row beside others, each a place, a box and a row."""
    for place_, (left, right), level in others:
        if level == row and own[0] < right + NAME_GAP and left < own[1] + NAME_GAP:
            return False
        if level > row and own[0] - 1.0 < place_ < own[1] + 1.0:
            return False
        if level < row and left - 1.0 < at < right + 1.0:
            return False
    return True


def box(at: float, wide: float) -> tuple[float, float]:
    """Left and right end of a name about a place, moved inside the plot."""
    left = min(max(at - 0.5 * wide, 0.0), WIDTH - LEFT - RIGHT - wide)
    return left, left + wide


def write_name(chart: Chart, thing: NamedObject, row: int, ends: tuple[float, float]) -> None:
    """Name above the plot, and a line from it down to the axis."""
    height = chart.y.end - 4.0 - NAME_ROW * row
    left, right = box(place(thing.ratio, ends), width(thing.name))
    at = float(chart.x(thing.ratio))
    chart.straight((at, chart.y.start), (at, chart.y.end), COLOURS["grid"])
    chart.text((LEFT + 0.5 * (left + right), height - 2.0), thing.name, "middle", more=f"font-size:{NAME_SIZE:g}px")
