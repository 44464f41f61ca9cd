"""Log-log charts of errors: named objects along the top, shaded where no digit is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.plotting.palette import COLOURS
from reports.plotting.panels import Legend, Panel
from reports.plotting.svg import BOTTOM, LEFT, RIGHT, TOP, WIDTH, Chart, Scale
from reports.text.numerals import as_given

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.plotting.families import Flags
    from reports.plotting.palette import Pen
    from reports.plotting.series import Array

LOST = 0.1  # an error from here on leaves no digit
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
    """Medians of errors between their quantiles."""

    label: str
    pen: Pen
    x: Array
    """(n,) rising"""
    y: Array
    """(n,); infinite where a run diverged"""
    low: Array
    high: Array
    fit: tuple[Array, Array] | None = None
    """A thin line"""
    ringed: Flags | None = None
    """(n,) bool: smallest error that round-off allows"""
    hollow: Flags | None = None
    """(n,) bool: drawn outlined"""


@dataclass(frozen=True)
class Axes:
    """Labels and axes of a chart."""

    name: str
    """Unique in the page"""
    title: str
    x_label: str
    y_label: str
    named: Sequence[tuple[str, float]] = ()
    """Things and their places on the horizontal axis"""
    ticks: tuple[float, ...] = ()
    """Of the horizontal axis; powers of ten if empty"""
    reverse: bool = False
    """Whether the horizontal axis falls to the right"""
    in_digits: bool = False
    """Whether the vertical axis counts digits, evenly"""


def error_chart(axes: Axes, curves: list[ErrorCurve], note: str, legend: tuple[Legend, ...] = ()) -> Panel | None:
    """Chart with a legend of the curves unless another is given; None if there is nothing to draw."""
    shown = [c for c in curves if (np.isfinite(c.y) & (c.y > 0.0)).any()]
    if not shown:
        return None
    x = np.concatenate([c.x for c in shown])
    ends = 10.0 ** (np.log10(x.min()) - MARGIN), 10.0 ** (np.log10(x.max()) + MARGIN)
    named = [(name, at) for name, at in axes.named if ends[0] < at < ends[1]]
    places = [name_box(name, at, ends) for name, at in named]
    levels = staggered([box[1:] for box in places])
    names_height = NAME_ROW * (max(levels, default=-1) + 1)
    chart = empty_chart(axes, shown, ends, TOP + names_height + (3.0 if names_height else 0.0))
    for (name, _), (at, left, right), level in zip(named, places, levels, strict=True):
        chart.straight((LEFT + at, chart.y.start), (LEFT + at, chart.y.end), COLOURS["grid"])
        middle = (LEFT + 0.5 * (left + right), chart.y.end - 6.0 - NAME_ROW * level)
        chart.text(middle, name, "middle", more=f"font-size:{NAME_SIZE:g}px")
    for curve in shown:
        draw(chart, curve)
    keys = legend or tuple(Legend(c.label, c.pen) for c in curves)
    return Panel(axes.title, chart.svg(axes.title, axes.name), note, keys)


def empty_chart(axes: Axes, curves: list[ErrorCurve], ends: tuple[float, float], top: float) -> Chart:
    """Empty axes below `top`, px, shaded where no digit is left."""
    if axes.in_digits:
        low, high = 0.0, 1.08 * max(float(c.y.max()) for c in curves)
    else:  # whole decades around the errors, but none beyond LARGEST
        values = np.concatenate(
            [edge[np.isfinite(edge) & (edge > 0.0)] for c in curves for edge in (c.y, c.low, c.high)]
        )
        highest = min(int(np.ceil(np.log10(values.max()))), LARGEST)
        low, high = 10.0 ** min(int(np.floor(np.log10(values.min()))), highest - 2), 10.0**highest
    y = Scale(low, high, top + PLOT_HEIGHT, top, not axes.in_digits)
    x = Scale(*(ends[::-1] if axes.reverse else ends), LEFT, WIDTH - RIGHT, log=True)
    chart = Chart(x, y, (WIDTH, top + PLOT_HEIGHT + BOTTOM))
    lost = (0.0, 1.0) if axes.in_digits else (max(LOST, low), high)
    if lost[0] < high:
        chart.area((x.start, x.end), (float(y(lost[0])), float(y(lost[1]))), COLOURS["body"])
    chart.ticks_up(y.ticks, axes.y_label, top - TOP + 9.0)
    if not axes.in_digits and high > 1.0:
        chart.across_at(1.0, COLOURS["rule"])
    given = [(t, as_given(t)) for t in axes.ticks if ends[0] < t < ends[1]]
    chart.ticks_across(given or x.ticks, axes.x_label)
    return chart


def draw(chart: Chart, curve: ErrorCurve) -> None:
    """Draw one curve over its quantiles, with its fit and its marks."""
    pen = curve.pen
    y, low, high = (np.where(np.isinf(edge), FAR_AWAY, edge) for edge in (curve.y, curve.low, curve.high))
    chart.band(curve.x, low, high, pen.colour, BOUND)
    if curve.fit is not None:
        chart.line(*curve.fit, pen.colour, 0.6)
    chart.line(curve.x, y, pen.colour, 1.4, pen.dash)
    hollow = np.zeros(len(y), bool) if curve.hollow is None else curve.hollow
    marked = np.arange(len(y)) % max(1, -(-len(y) // MOST_MARKERS)) == 0
    if pen.marker:
        for outlined, at in ((False, marked & ~hollow), (True, marked & hollow)):
            chart.marks(curve.x[at], y[at], pen.marker, pen.colour, MARKER_SIZE, hollow=outlined)
    if curve.ringed is not None:
        chart.marks(curve.x[curve.ringed], y[curve.ringed], "o", pen.colour, RING_SIZE, hollow=True, edge=1.1)


def name_box(name: str, place: float, ends: tuple[float, float]) -> tuple[float, float, float]:
    """Place of a thing, and left and right end of its name about it, moved inside the plot, px from its left edge."""
    room, wide = WIDTH - LEFT - RIGHT, LETTER * NAME_SIZE * len(name)
    at = float(np.log(place / ends[0]) / np.log(ends[1] / ends[0])) * room
    left = min(max(at - 0.5 * wide, 0.0), room - wide)
    return at, left, left + wide


def staggered(boxes: list[tuple[float, float]]) -> list[int]:
    """Rows of names between a left and a right end, px, counted upwards: the lowest in which none meets another."""
    levels: list[int] = []
    for left, right in boxes:
        meets = {
            row for row, (a, b) in zip(levels, boxes, strict=False) if left < b + NAME_GAP and a < right + NAME_GAP
        }
        levels.append(next(row for row in range(len(boxes)) if row not in meets))
    return levels
