"""Charts of cost against the number of bars on log-log axes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from reports.plotting.families import MARKER_SIZE, OTHERS, SHARED, Flags, families, family_pens, group_of
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import Legend, Panel, guide
from reports.plotting.series import Array, decade_range
from reports.plotting.svg import Chart, across, upwards
from reports.text.numerals import power_of_ten

BARS_LABEL = "number of bars N"
MARGIN = 1.3  # of the axis beyond the least and the largest N
GUIDE_WORDS = {1: "∝ N", 2: "∝ N²"}


@dataclass(frozen=True)
class ScalingCurve:
    """Costs of one engine against the number of bars."""

    engine: str
    bars: Array
    """(n,) rising"""
    cost: Array
    """(n,) positive"""
    hollow: Flags
    """(n,) bool: drawn outlined"""


@dataclass(frozen=True)
class ScalingChart:
    """Shared contents of all charts of one cost."""

    name: str
    title: str
    y_label: str
    tracks: tuple[ScalingCurve, ...]
    engines: tuple[str, ...]
    """Engines of all charts, so that each family keeps its colour"""
    hollow_words: str = ""
    """Meaning of outlined points"""
    guides: tuple[int, ...] = (1,)
    """Powers of N that thin lines show"""


def all_engines(chart: ScalingChart) -> Panel | None:
    """Chart of all engines, each family in a colour."""
    pens, groups = family_pens(chart.engines), group_of(chart.engines)
    words = [groups[t.engine] for t in chart.tracks]
    legend = tuple(Legend(word, pen) for word, pen in pens.items() if word in words)
    found = panel(chart, [(t, pens[word]) for t, word in zip(chart.tracks, words, strict=True)], legend)
    shared = SHARED if len(groups) > len(pens) else ""
    return found and replace(found, note=f"{found.note} {shared}".strip())


def each_family(chart: ScalingChart) -> list[Panel]:
    """One chart for each family: its engines in colour, all others in grey."""
    groups = families(chart.engines)
    shown = {groups[t.engine] for t in chart.tracks}
    names = sorted(shown, key=lambda g: (g == OTHERS, list(groups.values()).index(g)))
    found = (one_family(chart, g, [t for t in chart.tracks if groups[t.engine] == g]) for g in names)
    return [p for p in found if p]


def one_family(chart: ScalingChart, family: str, own: list[ScalingCurve]) -> Panel | None:
    """Chart of one family."""
    group = [e for e, name in families(chart.engines).items() if name == family]
    pens = [engine_pen(group.index(t.engine) + 2) for t in own]
    title = f"{chart.title}: {family}"
    legend = tuple(Legend(t.engine, p) for t, p in zip(own, pens, strict=True))
    named = replace(chart, name=f"{chart.name}-{family}", title=title)
    return panel(named, list(zip(own, pens, strict=True)), legend)


def panel(chart: ScalingChart, coloured: list[tuple[ScalingCurve, Pen]], legend: tuple[Legend, ...]) -> Panel | None:
    """Chart with some of the curves in colour; None if there is nothing to draw."""
    drawn = axes(chart)
    if drawn is None:
        return None
    shown = {t.engine for t, _ in coloured}
    for track in chart.tracks:
        if track.engine not in shown:
            drawn.line(track.bars, track.cost, COLOURS["rule"], 0.8)
    for track, pen in coloured:
        drawn.line(track.bars, track.cost, pen.colour, 1.3)
        for hollow, part in ((False, ~track.hollow), (True, track.hollow)):
            drawn.marks(track.bars[part], track.cost[part], pen.marker, pen.colour, MARKER_SIZE, hollow=hollow)
    hollow_words = chart.hollow_words if any(t.hollow.any() for t, _ in coloured) else ""
    return Panel(chart.title, drawn.svg(chart.title), hollow_words, legend)


def axes(chart: ScalingChart) -> Chart | None:
    """Empty log-log axes with guide lines."""
    up = decade_range([t.cost for t in chart.tracks])
    if up is None:
        return None
    bars = np.concatenate([t.bars for t in chart.tracks])
    ends = float(bars.min()) / MARGIN, float(bars.max()) * MARGIN
    drawn = Chart(across(*ends, log=True), upwards(up.low, up.high, log=True))
    drawn.axes(BARS_LABEL, chart.y_label, [(10.0**k, tick(k)) for k in range(6)])
    for power in chart.guides:
        guide(drawn, power, GUIDE_WORDS[power])
    return drawn


def tick(exponent: int) -> str:
    """``1``, ``10``, ``100``, then powers."""
    return str(10**exponent) if exponent < 3 else power_of_ten(exponent)
