"""Charts of curves against time, linear and logarithmic; the page sets their legends."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from reports.plotting.palette import COLOURS, Pen
from reports.plotting.series import Array, decade_range, thin
from reports.plotting.svg import Chart, across, upwards
from reports.text.numerals import power_of_ten

if TYPE_CHECKING:
    from markupsafe import Markup

FAINT = 0.4
TOLERANCE_POINTS = 120  # tolerances are smooth
TOLERANCE_DASH = (3.0, 2.5)
MARGIN = 0.06
"""Share of the range of all values by which a linear axis exceeds it"""
END_PX = 15.0
"""Height of the tick at the end of a line that is cut"""


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
    """Labels, range and curves of a chart against time."""

    title: str
    x_label: str
    y_label: str
    x_span: tuple[float, float]
    lines: list[Line] = field(default_factory=list)
    mark: float | None = None
    """Abscissa of a thin vertical line"""
    mark_label: str = ""


def linear_panel(frame: ChartFrame) -> Panel | None:
    """Panel on a linear axis; None if there is nothing finite to draw."""
    values = np.concatenate([np.empty(0), *(line.y[np.isfinite(line.y)] for line in frame.lines)])
    if not values.size:
        return None
    chart = Chart(across(*frame.x_span), upwards(*linear_span(values)))
    chart.axes(frame.x_label, frame.y_label)
    for line in frame.lines:
        draw(chart, line, *thin(line.x, line.y))
    if frame.mark is not None:
        chart.up_at(frame.mark, COLOURS["muted"], 0.9)
        late = frame.mark > 0.5 * sum(frame.x_span)
        at = (float(chart.x(frame.mark)), chart.y.end - 4.0)
        chart.text(at, frame.mark_label, "end" if late else "start")
    return Panel(frame.title, chart.svg(frame.title))


def linear_span(values: Array) -> tuple[float, float]:
    """Range of a linear axis: that of the values and a margin, more about values that are equal up to round-off."""
    low, high, size = float(values.min()), float(values.max()), float(np.abs(values).max())
    if high - low < 1e-6 * size or not size:
        middle, half = float(values.mean()), 0.5 * (size or 1.0)
        return middle - half, middle + half
    margin = MARGIN * (high - low)
    return low - margin, high + margin


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
    chart = Chart(across(*frame.x_span), upwards(floor.low, floor.high, log=True))
    chart.axes(frame.x_label, frame.y_label)
    lifted = 0
    for line in lines:
        y, below = floor.lift(line.y)
        lifted += below
        draw(chart, line, *thin(line.x, y))
        if line.tolerance is not None:
            x, tolerance = thin(line.x, floor.lift(line.tolerance)[0], TOLERANCE_POINTS)
            chart.line(x, tolerance, line.pen.colour, 0.9, TOLERANCE_DASH)
    notes = (
        [f"Samples below {power_of_ten(round(np.log10(floor.low)))}, on the lower edge: {lifted}."] if lifted else []
    )
    notes += [f"Samples that are exactly zero, left out: {zeros}."] if zeros else []
    return Panel(frame.title, chart.svg(frame.title), " ".join(notes))


def without_zeros(line: Line) -> Line:
    """Line without the samples that are exactly zero."""
    kept = line.y != 0.0
    tolerance = None if line.tolerance is None else line.tolerance[kept]
    return replace(line, x=line.x[kept], y=line.y[kept], tolerance=tolerance)


def draw(chart: Chart, line: Line, x: Array, y: Array) -> None:
    """Draw one thinned curve with a few markers, and a tick at a cut end."""
    colour, finite = line.pen.colour, np.flatnonzero(np.isfinite(y))
    if line.pen.hollow:
        chart.marks(x, y, line.pen.marker, colour, 5.2, hollow=True)
        return
    chart.line(x, y, colour, line.width, line.pen.dash, FAINT if line.faint else 1.0)
    if not finite.size:
        return
    if line.pen.marker:
        shift = sum(map(ord, line.pen.marker + line.pen.colour.name)) % 7 / 7  # so that markers of lines do not pile up
        at = finite[((np.arange(5) + 0.2 + 0.6 * shift) / 5 * len(finite)).astype(int)]
        chart.marks(x[at], y[at], line.pen.marker, colour)
    if line.cut:
        end = finite[-1]
        chart.marks(x[end], y[end], "|", colour, END_PX, edge=1.8)


def guide(chart: Chart, power: float, words: str) -> None:
    """Thin line of slope `power` from the lower left corner of a log-log chart, with its label at the far end."""
    left, low = chart.x.low, chart.y.low
    end = min(chart.x.high, left * (chart.y.high / low) ** (1.0 / power))
    x = np.array([left, end])
    chart.line(x, low * (x / left) ** power, COLOURS["rule"], 0.8, (1.5, 2.5))
    at = end**0.92 * left**0.08
    chart.text((float(chart.x(at)), float(chart.y(low * (at / left) ** power)) - 2.0), words, "end")
