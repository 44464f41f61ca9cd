"""Charts of an effect's change against its cost in time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.effects.labels import LINE, Anchor, placed
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import BOTTOM, FINE, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Chart, across, upwards

if TYPE_CHECKING:
    from collections.abc import Sequence

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
    chart = axes(points, up, unit)
    chart.across_at(scope.matters, COLOURS["muted"], 0.9, "30 25")
    for point in points:
        draw(chart, point, up)
    name_points(chart, points, up)
    return Panel(title, chart.svg(title))


def name_points(chart: Chart, points: list[Point], up: DecadeRange) -> None:
    """Write the name of each effect beside its point, with a line to a name that is farther away."""
    anchors = [anchor(chart, p, up) for p in points]
    for point, at, box in zip(points, anchors, placed(anchors, *PLOT), strict=True):
        if box is None:  # the legend has it
            continue
        right = box.left > at.x
        near = LEFT + (box.left if right else box.right)
        height = chart.y.start - box.middle
        if abs(box.middle - at.y) > LINE:
            chart.straight((LEFT + at.x, chart.y.start - at.y), (near, height), point.pen.colour, 0.5)
        chart.text((near, height + 4.0), point.row.title, "start" if right else "end", point.pen.colour.name)


def anchor(chart: Chart, point: Point, up: DecadeRange) -> Anchor:
    """Position of a point in the plot, px."""
    height = chart.y.start - float(chart.y(up.lift(np.array([point.change.share]))[0][0]))
    low, high, at = (float(chart.x(ratio)) - LEFT for ratio in (*point.reach, point.ratio))
    return Anchor(point.row.title, at, height, (low, high))


def label(row: EffectRow) -> str:
    """Effect in a legend."""
    return row.title if row.model else f"{row.title} ({row.state})"


def axes(points: list[Point], up: DecadeRange, unit: str) -> Chart:
    """Empty log-log axes with a line at a ratio of 1."""
    low, high = min(1.0 / NARROWEST, *(p.reach[0] for p in points)), max(NARROWEST, *(p.reach[1] for p in points))
    chart = Chart(across(low / MARGIN, high * MARGIN, log=True), upwards(up.low, up.high, log=True))
    chart.axes(X_LABEL, unit, [(v, f"{v:.3g}") for v in ticks(low / MARGIN, high * MARGIN)])
    chart.up_at(1.0, COLOURS["rule"])
    return chart


def ticks(low: float, high: float) -> list[float]:
    """Labelled ratios: 1, 2 and 5 of each decade, or 1 alone if there are too many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    fine = [m * 10.0**k for k in decades for m in (1.0, 2.0, 5.0) if low <= m * 10.0**k <= high]
    if high / low < CLOSE:
        return [v for v in (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7) if low <= v <= high]
    return fine if len(fine) <= MOST_TICKS else [10.0**k for k in decades]


def draw(chart: Chart, point: Point, up: DecadeRange) -> None:
    """Draw one effect: filled if resolved, else outlined at its bound with an arrow down."""
    colour, y = point.pen.colour, float(up.lift(np.array([point.change.share]))[0][0])
    chart.line(np.array(point.reach), np.array([y, y]), colour, 1.1)
    chart.marks(point.ratio, y, point.pen.marker, colour, MARKER_SIZE, hollow=not point.change.resolved, edge=1.0)
    if not point.change.resolved:
        at, top = FINE * float(chart.x(point.ratio)), FINE * float(chart.y(y))
        chart.stroke(f"M{at:.0f} {top + 40:.0f}v120m-30-40l30 40l30-40", colour, 0.9)
