"""Small charts of trends: factors relative to the median over the nights, with steps marked."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import escape

from reports.plotting.palette import COLOURS
from reports.plotting.svg import Chart, Scale
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Sequence

    from markupsafe import Markup

    from reports.results.nights.trends import TrendChart, TrendCurve

WIDTH, HEIGHT = 300.0, 84.0
LEFT, RIGHT, TOP, BOTTOM = 44.0, 6.0, 12.0, 16.0
ABOVE = 1.0 + 16.0 / (HEIGHT - TOP - BOTTOM)
"""Place of the marks of changes above the plot, relative to half of the axis"""
LEAST_RANGE = math.log(1.05)
"""Half of the axis at least: the least effect that is told of times"""
MOST_CURVES = 12
"""Curves of a chart, those that moved most"""
KIND_WORDS = {
    "error": "errors",
    "ratio": "times, relative to the anchor",
    "memory": "peak memory",
    "count": "counts",
}


def small_chart(chart: TrendChart, nights: int) -> tuple[str, Markup, str]:
    """Title, chart of some curves over `nights` nights, and the words below it.

    A mark stands on each night on which a figure changed, for better or worse: a dashed line below a diamond.
    """
    curves = sorted(chart.curves, key=lambda curve: max(curve.factor) / min(curve.factor), reverse=True)[:MOST_CURVES]
    half = max([LEAST_RANGE, *(abs(math.log(f)) for c in curves for f in c.factor)]) * 1.08
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    drawn = Chart(Scale(-0.5, nights - 0.5, LEFT, right), Scale(-half, half, bottom, TOP), (WIDTH, HEIGHT))
    drawn.straight((LEFT, TOP), (LEFT, bottom), COLOURS["rule"])
    drawn.across_at(-half, COLOURS["rule"])
    drawn.across_at(0.0, COLOURS["grid"])
    for at, log in ((TOP + 4.0, half), ((TOP + bottom) / 2.0 + 4.0, 0.0), (bottom + 1.0, -half)):
        drawn.text((LEFT - 4.0, at), f"×{number(math.exp(log))}", "end")
    drawn.text((LEFT, HEIGHT - 3.0), "night 1")
    if nights > 1:
        drawn.text((right, HEIGHT - 3.0), f"night {nights}", "end")
    for step in chart.steps:
        drawn.up_at(step, COLOURS["ink"], 1.0, "30 20")
        drawn.marks(step, ABOVE * half, "D", COLOURS["ink"], 6.7)
    for curve in curves:
        x, y = np.array(curve.night), np.log(curve.factor)
        drawn.shapes.append(f"<g><title>{escape(curve.quantity)}</title>")
        drawn.line(x, y, COLOURS["accent"], 1.3, opacity=0.75)
        drawn.marks(x[-1], y[-1], "o", COLOURS["accent"], 3.6)
        drawn.shapes.append("</g>")
    title = f"{chart.engine}, {chart.scene}: {KIND_WORDS[chart.kind]}"
    shown = f"{len(curves)} of {len(chart.curves)} figures that moved" if len(curves) < len(chart.curves) else ""
    still = f"{plural(chart.still, 'figure')} the same on all nights" if chart.still else ""
    return title, drawn.svg(f"{title}: {described(chart, curves, nights)}"), "; ".join(filter(None, (shown, still)))


def number(factor: float) -> str:
    """Factor in at most five characters."""
    if 0.01 <= factor < 1000.0:
        return f"{factor:.3g}"
    return f"{factor:.0e}".replace("e-0", "e-").replace("e+0", "e")


def described(chart: TrendChart, curves: Sequence[TrendCurve], nights: int) -> str:
    """Words on a chart for readers who don't see it."""
    if not curves:
        return f"{plural(chart.still, 'figure')}, the same on all {plural(nights, 'night')}"
    moved = ", ".join(f"{c.quantity} now ×{number(c.factor[-1])} of its median" for c in curves[:3])
    steps = f"; changes on night {', '.join(str(s + 1) for s in chart.steps)}" if chart.steps else ""
    return f"{plural(len(chart.curves), 'figure')} over {plural(nights, 'night')}: {moved}{steps}"
