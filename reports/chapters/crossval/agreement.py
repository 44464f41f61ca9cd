"""Overview of a comparison: normalised errors of all runs, a line for each engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reports.plotting.palette import COLOURS, Pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import Chart, Scale
from reports.text.numerals import power_of_ten

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.chapters.crossval.matrix import EngineGroup
    from reports.chapters.crossval.summary import RunCell, Summary

WIDTH, ROW, HEADING, TOP, BOTTOM = 400.0, 16.0, 22.0, 6.0, 34.0
LEFT, RIGHT = 142.0, 62.0
"""Room for the names of engines, and for the counts"""
MOST_TICKS = 5
PENS = {
    "independent": Pen(COLOURS["s2"], "o", hollow=True),
    "own": Pen(COLOURS["s1"], "s", hollow=True),
    "engines": Pen(COLOURS["s2"], "o", hollow=True),
}
FAILED = Pen(COLOURS["s8"], "X", hollow=True)
TITLE = "Normalised error of every comparison"
NOTE = (
    "One mark for each scene, and the number of comparisons that passed. Left of the line at 1, the error estimates "
    "explain the difference."
)


@dataclass(frozen=True)
class EngineMarks:
    """Marks of one engine."""

    engine: str
    pen: Pen
    height: float
    """From the top of the chart, px"""
    passed: tuple[float, ...]
    """Normalised errors of comparisons that passed"""
    failed: tuple[float, ...]
    count: str
    """``13 of 14``: comparisons that passed, of those judged; empty without any"""


def agreement_panel(summary: Summary, groups: Sequence[EngineGroup]) -> Panel | None:
    """Chart of all normalised errors; None without any."""
    marks, headings, height = laid_out(summary, groups)
    values = np.array([v for m in marks for v in (*m.passed, *m.failed)])
    span = decade_range([values, np.array([1.0])])
    if not len(values) or span is None:
        return None
    chart = Chart(
        Scale(span.low, max(span.high, 10.0), LEFT, WIDTH - RIGHT, log=True),
        Scale(0.0, height, TOP, TOP + height),
        (WIDTH, TOP + height + BOTTOM),
    )
    chart.ticks_across([(v, "1" if v == 1.0 else words) for v, words in ticks(chart.x)], "normalised error")
    chart.up_at(1.0, COLOURS["muted"], 0.9)
    for heading, at in headings:
        chart.text((2.0, TOP + at + 4.0), heading, colour="ink", more="font-weight:bold")
    for mark in marks:
        draw(chart, mark)
    legend = (Legend("failed", FAILED),) if any(m.failed for m in marks) else ()
    return Panel(TITLE, chart.svg(described(marks)), NOTE, legend)


def ticks(scale: Scale) -> list[tuple[float, str]]:
    """Powers of ten, 1 among them."""
    first, last = round(np.log10(scale.low)), round(np.log10(scale.high))
    step = max(1, int(np.ceil((last - first) / MOST_TICKS)))
    return [(10.0**k, power_of_ten(k)) for k in (*range(0, first - 1, -step), *range(step, last + 1, step))]


def laid_out(
    summary: Summary, groups: Sequence[EngineGroup]
) -> tuple[list[EngineMarks], list[tuple[str, float]], float]:
    """Marks of all engines, headings with their heights, and the height of the chart."""
    marks, headings, at = [], [], 0.0
    for group in groups:
        if len(groups) > 1:
            headings.append((group.heading, at + 0.5 * HEADING))
            at += HEADING
        for engine in group.engines:
            cells = [c for s in summary.scenes if (c := summary.cell(s.name, engine))]
            marks.append(engine_marks(engine, PENS[group.key], at + 0.5 * ROW, cells))
            at += ROW
    return marks, headings, at


def engine_marks(engine: str, pen: Pen, height: float, cells: Sequence[RunCell]) -> EngineMarks:
    """Marks of one engine from its cells."""
    judged = [c for c in cells if c.outcome.judged]
    passed = [c for c in judged if c.outcome.ok]
    count = f"{len(passed)} of {len(judged)}" if judged else ""
    failed = [c for c in judged if not c.outcome.ok]
    return EngineMarks(engine, pen, height, largest(passed), largest(failed), count)


def largest(cells: Sequence[RunCell]) -> tuple[float, ...]:
    """Largest normalised errors of runs that have one above zero."""
    ratios = (row.ratio for c in cells if (row := c.worst_ratio))
    return tuple(r for r in ratios if r is not None and np.isfinite(r) and r > 0.0)


def draw(chart: Chart, marks: EngineMarks) -> None:
    """Draw one engine's line, marks, name and count."""
    chart.across_at(marks.height, COLOURS["grid"])
    for values, pen in ((marks.passed, marks.pen), (marks.failed, FAILED)):
        chart.marks(np.array(values), np.full(len(values), marks.height), pen.marker, pen.colour, 5.4, hollow=True)
    chart.text((2.0, TOP + marks.height + 4.0), marks.engine, colour="ink")
    chart.text((WIDTH - 2.0, TOP + marks.height + 4.0), marks.count, "end")


def described(marks: Sequence[EngineMarks]) -> str:
    """Chart in words, for screen readers."""
    engines = "; ".join(f"{m.engine}: {m.count} passed" for m in marks if m.count)
    return f"{TITLE}, a line for each engine; horizontal axis: normalised error. {engines}"
