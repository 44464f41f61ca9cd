"""Charts of an effect's change against its cost in time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from reports.chapters.effects.labels import LINE, Anchor, placed
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import (
    BOTTOM,
    HEIGHT,
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    ChartFrame,
    Legend,
    Panel,
    blank_axes,
    finish,
    log_axis,
)
from reports.plotting.series import decade_range
from reports.plotting.svg import TEXT_SIZE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from reports.chapters.effects.rows import BudgetScope, EffectChange, EffectRow
    from reports.plotting.series import DecadeRange

TITLES = {
    "reaction": ("Change of the reactions", "relative to the largest reaction"),
    "attitude": ("Change of the attitude", "rad"),
    "com": ("Displacement of the centre of mass", "relative to its initial distance"),
}
X_LABEL = "run time with the effect / without it"
MARKER_SIZE = 7.0
ROOM = 10.0  # times, below a bound, for its arrow
MARGIN = 1.08  # of the horizontal axis beyond the least and the largest ratio
MOST_TICKS = 7
CLOSE = 2.0  # times the least ratio: an axis that spans less has tenths
NARROWEST = 1.15  # ratio that the axis reaches at least, either way
PLOT = (WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM)  # px


@dataclass(frozen=True)
class Point:
    """One effect in one chart."""

    row: EffectRow
    change: EffectChange
    pen: Pen
    ratio: float

    @property
    def reach(self) -> tuple[float, float]:
        """Interval of the ratio."""
        low, high = self.row.time.low, self.row.time.high
        return (self.ratio if low is None else low, self.ratio if high is None else high)


def effect_charts(rows: Sequence[EffectRow], scope: BudgetScope) -> tuple[tuple[Panel, ...], tuple[Legend, ...]]:
    """One chart for each changed quantity, and the legend of all."""
    switched = [row for row in rows if row.changes and row.time.value]
    found = (chart(name, points_of(switched, name), scope) for name in TITLES)
    legend = tuple(Legend(label(row), engine_pen(k + 2)) for k, row in enumerate(switched))
    return tuple(p for p in found if p), legend


def points_of(rows: Sequence[EffectRow], name: str) -> list[Point]:
    """Effects that change a quantity; each has the same pen in all charts."""
    found = []
    for k, row in enumerate(rows):
        change = row.change(name)
        if change is not None and change.scale and row.time.value is not None:
            found.append(Point(row, change, engine_pen(k + 2), row.time.value))
    return found


def chart(name: str, points: list[Point], scope: BudgetScope) -> Panel | None:
    """Chart of change against cost; None if there is nothing to draw."""
    low = [p.change.share / (1.0 if p.change.resolved else ROOM) for p in points]
    up = decade_range([np.array([*low, *(p.change.share for p in points), scope.matters])]) if points else None
    if up is None:
        return None
    title, unit = TITLES[name]
    frame = ChartFrame(f"effects-{name}", title, X_LABEL, unit, (0.0, 1.0))
    ax = axes(frame, points, up)
    ax.axhline(scope.matters, color=COLOURS["muted"].stand_in, linewidth=0.9, linestyle=(0.0, (3.0, 2.5)), zorder=1)
    for point in points:
        draw(ax, point, up)
    name_points(ax, points, up)
    return Panel(title, finish(ax, frame))


def name_points(ax: Axes, points: list[Point], up: DecadeRange) -> None:
    """Write the name of each effect beside its point, with a line to a name that is farther away."""
    anchors = [anchor(ax, p, up) for p in points]
    for point, at, box in zip(points, anchors, placed(anchors, *PLOT), strict=True):
        if box is None:  # the legend has it
            continue
        colour, right = point.pen.colour.stand_in, box.left > at.x
        near = box.left if right else box.right
        if abs(box.middle - at.y) > LINE:
            ends = ((at.x, near), (at.y, box.middle))
            ax.plot(*(np.array(e) / size for e, size in zip(ends, PLOT, strict=True)), color=colour, linewidth=0.5,
                    transform=ax.transAxes, zorder=1)  # fmt: skip
        ax.text(
            near / PLOT[0], box.middle / PLOT[1], point.row.title, transform=ax.transAxes, color=colour,
            fontsize=TEXT_SIZE, ha="left" if right else "right", va="center_baseline",
        )  # fmt: skip


def anchor(ax: Axes, point: Point, up: DecadeRange) -> Anchor:
    """Position of a point in the plot, px."""
    (left, right), y = ax.get_xlim(), float(up.lift(np.array([point.change.share]))[0][0])

    def across(ratio: float) -> float:
        return PLOT[0] * math.log(ratio / left) / math.log(right / left)

    height = PLOT[1] * math.log(y / up.low) / math.log(up.high / up.low)
    low, high = point.reach
    return Anchor(point.row.title, across(point.ratio), height, (across(low), across(high)))


def label(row: EffectRow) -> str:
    """Effect in a legend."""
    return row.title if row.model else f"{row.title} ({row.state})"


def axes(frame: ChartFrame, points: list[Point], up: DecadeRange) -> Axes:
    """Empty log-log axes with a line at a ratio of 1."""
    ax = blank_axes(frame)
    low, high = min(1.0 / NARROWEST, *(p.reach[0] for p in points)), max(NARROWEST, *(p.reach[1] for p in points))
    ax.set_xscale("log")
    ax.set_xlim(low / MARGIN, high * MARGIN)
    ax.xaxis.set_major_locator(FixedLocator(ticks(low / MARGIN, high * MARGIN)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:.3g}"))
    ax.xaxis.set_minor_locator(NullLocator())
    log_axis(ax, up)
    ax.axvline(1.0, color=COLOURS["rule"].stand_in, linewidth=0.8, zorder=0)
    return ax


def ticks(low: float, high: float) -> list[float]:
    """Labelled ratios: 1, 2 and 5 of each decade, or 1 alone if there are too many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    fine = [m * 10.0**k for k in decades for m in (1.0, 2.0, 5.0) if low <= m * 10.0**k <= high]
    if high / low < CLOSE:
        return [v for v in (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7) if low <= v <= high]
    return fine if len(fine) <= MOST_TICKS else [10.0**k for k in decades]


def draw(ax: Axes, point: Point, up: DecadeRange) -> None:
    """Draw one effect: filled if resolved, else outlined at its bound with an arrow down."""
    colour, y = point.pen.colour.stand_in, float(up.lift(np.array([point.change.share]))[0][0])
    ax.plot(point.reach, (y, y), color=colour, linewidth=1.1, zorder=2)
    known = point.change.resolved
    ax.plot(
        [point.ratio], [y], point.pen.marker, color=colour, markersize=MARKER_SIZE, zorder=3, clip_on=False,
        fillstyle="full" if known else "none", markeredgewidth=0.0 if known else 1.0,
    )  # fmt: skip
    if not known:
        ax.annotate(
            "", (point.ratio, y), xytext=(0.0, -16.0), textcoords="offset points", annotation_clip=False,
            arrowprops={"arrowstyle": "<-", "color": colour, "linewidth": 0.9, "shrinkA": 0.0, "shrinkB": 4.0},
        )  # fmt: skip
