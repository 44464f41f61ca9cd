"""Overview of a comparison: normalised errors of all runs, a line for each engine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from reports.plotting.palette import COLOURS, Pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import TEXT_SIZE, figure, inline
from reports.text.numerals import power_of_ten

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

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
    whole = TOP + height + BOTTOM
    made = figure(WIDTH, whole)
    ax = made.add_axes((LEFT / WIDTH, BOTTOM / whole, (WIDTH - LEFT - RIGHT) / WIDTH, height / whole))
    dress(ax, height, span.low, max(span.high, 10.0))
    for heading, at in headings:
        write(ax, heading, at, weight="bold")
    for mark in marks:
        draw(ax, mark)
    legend = (Legend("failed", FAILED),) if any(m.failed for m in marks) else ()
    return Panel(TITLE, inline(made, "agreement", described(marks)), NOTE, legend)


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


def dress(ax: Axes, height: float, low: float, high: float) -> None:
    """Scales, the line at 1, and no box."""
    ax.patch.set_visible(False)
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    ax.spines["bottom"].set_color(COLOURS["rule"].stand_in)
    ax.set_xscale("log")
    ax.set_xlim(low, high)
    ax.set_ylim(height, 0.0)
    first, last = round(np.log10(low)), round(np.log10(high))
    step = max(1, int(np.ceil((last - first) / MOST_TICKS)))
    ticks = [10.0**k for k in range(0, first - 1, -step)] + [10.0**k for k in range(step, last + 1, step)]
    ax.xaxis.set_major_locator(FixedLocator(sorted(ticks)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: "1" if v == 1.0 else power_of_ten(round(np.log10(v)))))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_major_locator(NullLocator())
    ax.tick_params(axis="x", color=COLOURS["rule"].stand_in, labelcolor=COLOURS["muted"].stand_in, labelsize=TEXT_SIZE)
    ax.set_xlabel("normalised error", fontsize=TEXT_SIZE, color=COLOURS["muted"].stand_in, labelpad=3)
    ax.axvline(1.0, color=COLOURS["muted"].stand_in, linewidth=0.9)


def write(ax: Axes, text: str, at: float, *, weight: str = "normal", right: bool = False) -> None:
    """Write a text beside the chart."""
    ax.annotate(
        text,
        (1.0 if right else 0.0, at),
        xycoords=("axes fraction", "data"),
        xytext=(RIGHT - 2.0 if right else -LEFT + 2.0, 0.0),
        textcoords="offset points",
        ha="right" if right else "left",
        va="center",
        fontsize=TEXT_SIZE,
        fontweight=weight,
        color=COLOURS["muted" if right else "ink"].stand_in,
        annotation_clip=False,
    )


def draw(ax: Axes, marks: EngineMarks) -> None:
    """Draw one engine's line, marks, name and count."""
    ax.axhline(marks.height, color=COLOURS["grid"].stand_in, linewidth=0.8, zorder=0)
    for values, pen in ((marks.passed, marks.pen), (marks.failed, FAILED)):
        at = np.full(len(values), marks.height)
        ax.plot(values, at, pen.marker, color=pen.colour.stand_in, markersize=5.4, fillstyle="none", clip_on=False)
    write(ax, marks.engine, marks.height)
    write(ax, marks.count, marks.height, right=True)


def described(marks: Sequence[EngineMarks]) -> str:
    """Chart in words, for screen readers."""
    engines = "; ".join(f"{m.engine}: {m.count} passed" for m in marks if m.count)
    return f"{TITLE}, a line for each engine; horizontal axis: normalised error. {engines}"
