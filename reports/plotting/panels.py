"""Panels of curves against time, linear and logarithmic; legends are set by the page."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from reports.plotting.palette import COLOURS, Pen
from reports.plotting.series import Array, DecadeRange, decade_range, thin
from reports.plotting.svg import TEXT_SIZE, figure, inline
from reports.text.numerals import power_of_ten

if TYPE_CHECKING:
    from markupsafe import Markup
    from matplotlib.axes import Axes

WIDTH, HEIGHT = 400.0, 250.0  # about a phone's width, so that letters are not shrunk on it
LEFT, RIGHT, TOP, BOTTOM = 50.0, 10.0, 24.0, 34.0
MOST_TICKS = 6
FAINT = 0.4
TOLERANCE_POINTS = 120  # tolerances are smooth
TOLERANCE_DASH = (0.0, (3.0, 2.5))


@dataclass(frozen=True)
class Line:
    """One curve."""

    x: Array
    y: Array
    pen: Pen
    tolerance: Array | None = None
    """Same shape as `y`; drawn dashed in the same colour"""
    cut: bool = False
    """Whether it ends before the run: a tick marks its end"""
    width: float = 1.4
    faint: bool = False
    """Whether it is drawn faint, as unreliable"""

    def scaled(self, x: float, y: float) -> Line:
        """Line in other units; for lines without a tolerance."""
        return replace(self, x=self.x * x, y=self.y * y)


@dataclass(frozen=True)
class Legend:
    """One entry of a legend set beside the charts."""

    label: str
    pen: Pen


@dataclass(frozen=True)
class Panel:
    """One chart with its note and legend."""

    title: str
    svg: Markup
    note: str = ""
    legend: tuple[Legend, ...] = ()
    """Of this chart alone"""
    moving: str = ""
    """Id of the control that sets the drawing in motion; empty for a still one"""


@dataclass
class ChartFrame:
    """Labels, ranges and curves of a panel."""

    name: str
    title: str
    x_label: str
    y_label: str
    x_span: tuple[float, float]
    lines: list[Line] = field(default_factory=list)
    mark: float | None = None
    """Abscissa of a thin vertical line"""
    mark_label: str = ""


def blank_axes(frame: ChartFrame) -> Axes:
    """Axes in the style of the page: no box, a light grid, the unit above the vertical axis."""
    made = figure(WIDTH, HEIGHT)
    ax = made.add_axes(
        (LEFT / WIDTH, BOTTOM / HEIGHT, (WIDTH - LEFT - RIGHT) / WIDTH, (HEIGHT - TOP - BOTTOM) / HEIGHT)
    )
    dress(ax)
    ax.set_xlim(*frame.x_span)
    ax.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
    ax.set_xlabel(frame.x_label, fontsize=TEXT_SIZE, color=COLOURS["muted"].stand_in, labelpad=4)
    ax.text(
        -(LEFT - 4) / (WIDTH - LEFT - RIGHT),
        1.0 + 9.0 / (HEIGHT - TOP - BOTTOM),
        frame.y_label,
        transform=ax.transAxes,
        fontsize=TEXT_SIZE,
        color=COLOURS["muted"].stand_in,
        va="bottom",
    )
    return ax


def dress(ax: Axes) -> None:
    """Set colours and spines."""
    ax.patch.set_visible(False)
    ax.set_axisbelow(True)
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    ax.spines["bottom"].set_color(COLOURS["rule"].stand_in)
    ax.tick_params(axis="x", color=COLOURS["rule"].stand_in, labelcolor=COLOURS["muted"].stand_in, labelsize=TEXT_SIZE)
    ax.tick_params(axis="y", length=0, labelcolor=COLOURS["muted"].stand_in, labelsize=TEXT_SIZE)
    ax.grid(axis="y", color=COLOURS["grid"].stand_in, linewidth=0.8)


def linear_panel(frame: ChartFrame) -> Panel | None:
    """Panel on a linear axis; None if there is nothing finite to draw."""
    if not any(np.isfinite(line.y).any() for line in frame.lines):
        return None
    ax = blank_axes(frame)
    ax.yaxis.set_major_locator(MaxNLocator(MOST_TICKS, steps=[1, 2, 2.5, 5, 10]))
    ax.margins(y=0.06)
    for line in frame.lines:
        draw(ax, line, *thin(line.x, line.y))
    widen_flat(ax, frame)
    if frame.mark is not None:
        draw_mark(ax, frame, frame.mark)
    return Panel(frame.title, finish(ax, frame))


def draw_mark(ax: Axes, frame: ChartFrame, at: float) -> None:
    """Draw a thin vertical line, labelled above the plot on the side with more room."""
    left, right = frame.x_span
    late = at > 0.5 * (left + right)
    ax.axvline(at, color=COLOURS["muted"].stand_in, linewidth=0.9)
    ax.annotate(
        frame.mark_label,
        (at, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0, 4),
        textcoords="offset points",
        ha="right" if late else "left",
        fontsize=TEXT_SIZE,
        color=COLOURS["muted"].stand_in,
    )


def widen_flat(ax: Axes, frame: ChartFrame) -> None:
    """Widen the axis of a curve that is constant up to round-off."""
    values = np.concatenate([line.y[np.isfinite(line.y)] for line in frame.lines])
    size, spread = float(np.abs(values).max()), float(np.ptp(values))
    if spread < 1e-6 * size:
        middle = float(values.mean())
        ax.set_ylim(middle - 0.5 * size, middle + 0.5 * size)


def log_panel(frame: ChartFrame) -> Panel | None:
    """Panel on a log axis; None if nothing is above zero.

    An exact zero has no place on it: it is left out, and counted in the note unless it is the first
    sample (every run starts from the same state). Values below the lower edge are drawn on it and counted.
    NaN is a break in the line.
    """
    zeros = sum(int((line.y[1:] == 0.0).sum()) for line in frame.lines)
    lines = [without_zeros(line) for line in frame.lines]
    floor = decade_range([curve for line in lines for curve in (line.y, line.tolerance) if curve is not None])
    if floor is None:
        return None
    ax = blank_axes(frame)
    log_axis(ax, floor)
    lifted = sum(draw_log(ax, line, floor) for line in lines)
    exponent = round(np.log10(floor.low))
    notes = []
    if lifted:
        below = power_of_ten(exponent)
        notes.append(f"{lifted} sample{'s'[: lifted > 1]} below {below} lie{'s'[: lifted == 1]} on the lower edge.")
    if zeros:
        words = "sample that is exactly zero is" if zeros == 1 else "samples that are exactly zero are"
        notes.append(f"{zeros} {words} left out.")
    return Panel(frame.title, finish(ax, frame), " ".join(notes))


def without_zeros(line: Line) -> Line:
    """Line without the samples that are exactly zero."""
    kept = line.y != 0.0
    tolerance = None if line.tolerance is None else line.tolerance[kept]
    return replace(line, x=line.x[kept], y=line.y[kept], tolerance=tolerance)


def log_axis(ax: Axes, floor: DecadeRange) -> None:
    """Log scale with at most :data:`MOST_TICKS` labelled decades."""
    ax.set_yscale("log", nonpositive="mask")
    first, last = round(np.log10(floor.low)), round(np.log10(floor.high))
    step = max(1, int(np.ceil((last - first) / MOST_TICKS)))
    ax.yaxis.set_major_locator(FixedLocator([10.0**k for k in range(last, first - 1, -step)]))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda v, _: power_of_ten(round(np.log10(v)))))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.set_ylim(floor.low, floor.high)


def draw_log(ax: Axes, line: Line, floor: DecadeRange) -> int:
    """Draw a line and its tolerance; return the number of samples at the edge."""
    y, lifted = floor.lift(line.y)
    draw(ax, line, *thin(line.x, y))
    if line.tolerance is not None:
        x, tolerance = thin(line.x, floor.lift(line.tolerance)[0], TOLERANCE_POINTS)
        ax.plot(x, tolerance, color=line.pen.colour.stand_in, linewidth=0.9, linestyle=TOLERANCE_DASH)
    return lifted


def draw(ax: Axes, line: Line, x: Array, y: Array) -> None:
    """Draw one thinned curve with a few markers, and a tick at a cut end."""
    colour, finite = line.pen.colour.stand_in, np.flatnonzero(np.isfinite(y))
    if line.pen.hollow:
        ax.plot(x, y, line.pen.marker, color=colour, markersize=5.2, markeredgewidth=0.9, fillstyle="none")
        return
    ax.plot(
        x,
        y,
        color=colour,
        linewidth=line.width,
        alpha=FAINT if line.faint else None,
        linestyle=(0.0, line.pen.dash) if line.pen.dash else "-",
        solid_joinstyle="round",
    )
    if not finite.size:
        return
    if line.pen.marker:
        shift = sum(map(ord, line.pen.marker + line.pen.colour.name)) % 7 / 7  # so that markers of lines do not pile up
        at = finite[((np.arange(5) + 0.2 + 0.6 * shift) / 5 * len(finite)).astype(int)]
        ax.plot(x[at], y[at], line.pen.marker, color=colour, markersize=5.6, markeredgewidth=0)
    if line.cut:
        end = finite[-1]
        ax.plot(x[end], y[end], "|", color=colour, markersize=15, markeredgewidth=1.8, clip_on=False)


def finish(ax: Axes, frame: ChartFrame) -> Markup:
    """Render the axes' figure as SVG."""
    found = ax.get_figure(root=True)
    assert found is not None
    return inline(found, frame.name, f"{frame.title}; horizontal axis: {frame.x_label}; vertical axis: {frame.y_label}")
