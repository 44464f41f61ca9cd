"""Log-log charts of errors: named objects along the top, shaded where no digit is left."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.textpath import TextPath
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from reports.chapters.roundoff.series import LOST
from reports.plotting.palette import COLOURS
from reports.plotting.panels import (
    BOTTOM,
    LEFT,
    MOST_TICKS,
    RIGHT,
    TOP,
    WIDTH,
    ChartFrame,
    Legend,
    Panel,
    dress,
    finish,
    log_axis,
)
from reports.plotting.series import DecadeRange
from reports.plotting.svg import TEXT_SIZE, figure
from reports.text.numerals import as_given, power_of_ten

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from reports.chapters.roundoff.series import NamedObject
    from reports.plotting.families import Flags
    from reports.plotting.palette import Pen
    from reports.plotting.series import Array

PLOT_HEIGHT = 205.0
NAME_SIZE, NAME_ROW, NAME_GAP = 10.0, 12.5, 5.0
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
    ax = axes(sheet, NAME_ROW * (max(rows, default=-1) + 1))
    across(ax, sheet, ends)
    up(ax, sheet, shown)
    for thing, row in zip(names, rows, strict=True):
        write_name(ax, thing, row, ends)
    for curve in shown:
        draw(ax, curve)
    frame = ChartFrame(sheet.name, sheet.title, sheet.x_label, sheet.y_label, (0.0, 1.0))
    return Panel(sheet.title, finish(ax, frame), note, legend)


def axes(sheet: Sheet, names_height: float) -> Axes:
    """Empty axes with room for the names above."""
    top = TOP + names_height + (3.0 if names_height else 0.0)
    height = top + PLOT_HEIGHT + BOTTOM
    made = figure(WIDTH, height)
    wide = WIDTH - LEFT - RIGHT
    ax = made.add_axes((LEFT / WIDTH, BOTTOM / height, wide / WIDTH, PLOT_HEIGHT / height))
    dress(ax)
    muted = COLOURS["muted"].stand_in
    ax.set_xlabel(sheet.x_label, fontsize=TEXT_SIZE, color=muted, labelpad=4)
    above = 1.0 + (top - TOP + 9.0) / PLOT_HEIGHT
    ax.text(-(LEFT - 4) / wide, above, sheet.y_label, transform=ax.transAxes, fontsize=TEXT_SIZE, color=muted)
    return ax


def across(ax: Axes, sheet: Sheet, ends: tuple[float, float]) -> None:
    """Horizontal axis."""
    ax.set_xscale("log")
    ax.set_xlim(*(ends[::-1] if sheet.reverse else ends))
    ax.xaxis.set_minor_locator(NullLocator())
    if sheet.ticks:
        ax.xaxis.set_major_locator(FixedLocator([t for t in sheet.ticks if ends[0] < t < ends[1]]))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: as_given(v)))
        return
    first, last = int(np.ceil(np.log10(ends[0]))), int(np.floor(np.log10(ends[1])))
    step = max(1, int(np.ceil((last - first) / MOST_TICKS)))
    ax.xaxis.set_major_locator(FixedLocator([10.0**k for k in range(last, first - 1, -step)]))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: power_of_ten(round(np.log10(v)))))


def up(ax: Axes, sheet: Sheet, curves: list[ErrorCurve]) -> None:
    """Vertical axis, shaded where no digit is left."""
    if sheet.in_digits:
        ax.yaxis.set_major_locator(MaxNLocator(MOST_TICKS, integer=True))
        ax.set_ylim(0.0, 1.08 * max(float(c.y.max()) for c in curves))
        ax.axhspan(0.0, 1.0, color=COLOURS["body"].stand_in, linewidth=0, zorder=0)
        return
    log_axis(ax, heights(curves))
    low, high = ax.get_ylim()
    if high > LOST:
        ax.axhspan(max(LOST, low), high, color=COLOURS["body"].stand_in, linewidth=0, zorder=0)
        ax.axhline(1.0, color=COLOURS["rule"].stand_in, linewidth=0.8, zorder=0.5)


def heights(curves: list[ErrorCurve]) -> DecadeRange:
    """Whole decades around the errors, but none beyond :data:`LARGEST`."""
    edges = [edge for c in curves for edge in (c.y, *(c.bound or ()))]
    values = np.concatenate([e[np.isfinite(e) & (e > 0.0)] for e in edges])
    high = min(int(np.ceil(np.log10(values.max()))), LARGEST)
    low = min(int(np.floor(np.log10(values.min()))), high - 2)
    return DecadeRange(10.0**low, 10.0**high)


def draw(ax: Axes, curve: ErrorCurve) -> None:
    """Draw one curve over its quantiles, with its fit and its marks."""
    colour, pen = curve.pen.colour.stand_in, curve.pen
    y = np.where(np.isinf(curve.y), FAR_AWAY, curve.y)
    if curve.bound is not None:
        low, high = (np.where(np.isinf(edge), FAR_AWAY, edge) for edge in curve.bound)
        ax.fill_between(curve.x, low, high, color=colour, alpha=BOUND, linewidth=0, zorder=1)
    if curve.fit is not None:
        ax.plot(*curve.fit, color=colour, linewidth=0.6, zorder=2)
    ax.plot(curve.x, y, color=colour, linewidth=1.4, linestyle=(0.0, pen.dash) if pen.dash else "-", zorder=3)
    hollow = np.zeros(len(y), bool) if curve.blurred is None else curve.blurred
    each = max(1, int(np.ceil(len(y) / MOST_MARKERS)))
    marked = np.arange(len(y)) % each == 0
    for at, marker, size, fill, edge in (
        (marked & ~hollow, pen.marker, MARKER_SIZE, "full", 0.0),
        (marked & hollow, pen.marker, MARKER_SIZE, "none", 0.9),
        (marked & False if curve.ringed is None else curve.ringed, "o", RING_SIZE, "none", 1.1),
    ):
        ax.plot(
            curve.x[at], y[at], marker, color=colour, markersize=size, fillstyle=fill, markeredgewidth=edge, zorder=4
        )


def place(value: float, ends: tuple[float, float]) -> float:
    """Distance from the left edge of the plot, px."""
    share = np.log(value / ends[0]) / np.log(ends[1] / ends[0])
    return float(share) * (WIDTH - LEFT - RIGHT)


@cache
def width(text: str) -> float:
    """Width of a name in the widest possible font, px."""
    return float(TextPath((0.0, 0.0), text, size=NAME_SIZE).get_extents().width)


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


def write_name(ax: Axes, thing: NamedObject, row: int, ends: tuple[float, float]) -> None:
    """Name above the plot, and a line from it down to the axis."""
    height = 1.0 + (4.0 + NAME_ROW * row) / PLOT_HEIGHT
    left, right = box(place(thing.ratio, ends), width(thing.name))
    ax.plot(
        [thing.ratio] * 2, [0.0, height], transform=ax.get_xaxis_transform(), clip_on=False,
        color=COLOURS["grid"].stand_in, linewidth=0.8, zorder=0.2,
    )  # fmt: skip
    middle = 0.5 * (left + right) / (WIDTH - LEFT - RIGHT)
    ax.text(
        middle, height, thing.name, transform=ax.transAxes, ha="center", va="bottom",
        fontsize=NAME_SIZE, color=COLOURS["muted"].stand_in,
    )  # fmt: skip
