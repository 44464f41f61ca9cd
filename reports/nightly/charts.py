"""Small charts of trends as SVG: factors relative to the median over the nights, with steps marked."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.tables.nights.trends import TrendChart, TrendCurve

WIDTH, HEIGHT = 300.0, 84.0
LEFT, RIGHT, TOP, BOTTOM = 44.0, 6.0, 12.0, 16.0
LEAST_RANGE = math.log(1.05)
"""Half of the axis at least: the least effect that is told of times"""
HEAD = 4.0
"""Half the height of the mark of a change, px"""
MOST_CURVES = 12
"""Curves of a chart, those that moved most"""
SAME = 0.05
"""Changes of less than this part of a pixel are not drawn"""
KIND_WORDS = {
    "error": "errors",
    "ratio": "times, relative to the anchor",
    "memory": "peak memory",
    "count": "counts",
}


@dataclass(frozen=True)
class SmallChart:
    """A chart with its words."""

    title: str
    svg: Markup
    note: str


def small_chart(chart: TrendChart, nights: int) -> SmallChart:
    """Chart of some curves over `nights` nights."""
    curves = sorted(chart.curves, key=spread, reverse=True)[:MOST_CURVES]
    half = max([LEAST_RANGE, *(abs(math.log(f)) for c in curves for f in c.factor)]) * 1.08
    title = f"{chart.engine}, {chart.scene}: {KIND_WORDS[chart.kind]}"
    parts = [
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" class="trend"><title>{escape(title)}</title>',
        f"<desc>{escape(described(chart, curves, nights))}</desc>",
        *axis(half, nights),
        *(mark(step, nights) for step in chart.steps),
        *(line(curve, half, nights) for curve in curves),
        "</svg>",
    ]
    return SmallChart(title, Markup("".join(parts)), note(chart, curves))


def spread(curve: TrendCurve) -> float:
    """Largest factor of a curve over its least one, as a logarithm."""
    return math.log(max(curve.factor) / min(curve.factor))


def axis(half: float, nights: int) -> list[str]:
    """Frame, the line of the median, and the ends of both axes."""
    right, bottom, middle = WIDTH - RIGHT, HEIGHT - BOTTOM, (TOP + HEIGHT - BOTTOM) / 2.0
    last = f'<text x="{right:g}" y="{HEIGHT - 3:g}" text-anchor="end">night {nights}</text>' if nights > 1 else ""
    return [
        f'<path class="frame" d="M{LEFT:g} {TOP:g}V{bottom:g}H{right:g}"/>',
        f'<path class="median" d="M{LEFT:g} {middle:g}H{right:g}"/>',
        f'<text x="{LEFT - 4:g}" y="{TOP + 4:g}" text-anchor="end">×{number(math.exp(half))}</text>',
        f'<text x="{LEFT - 4:g}" y="{middle + 4:g}" text-anchor="end">×1</text>',
        f'<text x="{LEFT - 4:g}" y="{bottom + 1:g}" text-anchor="end">×{number(math.exp(-half))}</text>',
        f'<text x="{LEFT:g}" y="{HEIGHT - 3:g}">night 1</text>{last}',
    ]


def number(factor: float) -> str:
    """Factor in at most five characters."""
    if 0.01 <= factor < 1000.0:
        return f"{factor:.3g}"
    return f"{factor:.0e}".replace("e-0", "e-").replace("e+0", "e")


def across(night: float, nights: int) -> float:
    """Place of a night."""
    width = WIDTH - LEFT - RIGHT
    return LEFT + width * ((night + 0.5) / nights)


def up(factor: float, half: float) -> float:
    """Place of a factor."""
    middle, height = (TOP + HEIGHT - BOTTOM) / 2.0, HEIGHT - TOP - BOTTOM
    return middle - 0.5 * height * math.log(factor) / half


def mark(step: int, nights: int) -> str:
    """Mark of a night on which a figure changed, for better or worse: a dashed line below a diamond."""
    x = across(step, nights)
    return (
        f'<path class="step" d="M{x:.1f} {TOP:g}V{HEIGHT - BOTTOM:g}"/>'
        f'<path class="head" d="M{x:.1f} 0L{x + 4:.1f} {HEAD:g} {x:.1f} {2 * HEAD:g} {x - 4:.1f} {HEAD:g}Z"/>'
    )


def line(curve: TrendCurve, half: float, nights: int) -> str:
    """Curve; a single night is a point."""
    points = [(across(n, nights), up(f, half)) for n, f in zip(curve.night, curve.factor, strict=True)]
    kept = needed(points)
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in kept)
    dot = f'<circle cx="{kept[-1][0]:.1f}" cy="{kept[-1][1]:.1f}" r="1.8"/>'
    return f'<g class="{escape(curve.kind)}"><title>{escape(curve.quantity)}</title><path d="{path}"/>{dot}</g>'


def needed(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Points without those in the middle of a horizontal line."""
    inner = (
        point
        for before, point, after in zip(points, points[1:], points[2:], strict=False)
        if abs(point[1] - before[1]) > SAME or abs(after[1] - point[1]) > SAME
    )
    return [points[0], *inner, *points[-1:]] if len(points) > 1 else list(points)


def described(chart: TrendChart, curves: Sequence[TrendCurve], nights: int) -> str:
    """Words on a chart for readers who don't see it."""
    if not curves:
        return f"{chart.still} figures, the same on all {nights} nights"
    moved = ", ".join(f"{c.quantity} now ×{number(c.factor[-1])} of its median" for c in curves[:3])
    steps = f"; changes on night {', '.join(str(s + 1) for s in chart.steps)}" if chart.steps else ""
    return f"{len(chart.curves)} figures over {nights} nights: {moved}{steps}"


def note(chart: TrendChart, curves: Sequence[TrendCurve]) -> str:
    """Words below a chart."""
    shown = f"{len(curves)} of {len(chart.curves)} figures that moved" if len(curves) < len(chart.curves) else ""
    still = f"{chart.still} figures the same on all nights" if chart.still else ""
    return "; ".join(part for part in (shown, still) if part)
