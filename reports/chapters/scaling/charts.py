"""Charts of cost against the number of bars on log-log axes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from reports.plotting.families import MARKER_SIZE, OTHERS, SHARED, Flags, families, family_pens, group_of
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import ChartFrame, Legend, Panel, blank_axes, finish, log_axis
from reports.plotting.series import Array, decade_range
from reports.plotting.svg import TEXT_SIZE
from reports.text.numerals import power_of_ten

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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
    frame = ChartFrame(chart.name, chart.title, BARS_LABEL, chart.y_label, (0.0, 1.0))
    ax = axes(chart, frame)
    if ax is None:
        return None
    shown = {t.engine for t, _ in coloured}
    for track in chart.tracks:
        if track.engine not in shown:
            ax.plot(track.bars, track.cost, color=COLOURS["rule"].stand_in, linewidth=0.8, zorder=1)
    for track, pen in coloured:
        draw(ax, track, pen)
    hollow = any(t.hollow.any() for t, _ in coloured)
    return Panel(chart.title, finish(ax, frame), chart.hollow_words if hollow else "", legend)


def axes(chart: ScalingChart, frame: ChartFrame) -> Axes | None:
    """Empty log-log axes with guide lines."""
    up = decade_range([t.cost for t in chart.tracks])
    if up is None:
        return None
    bars = np.concatenate([t.bars for t in chart.tracks])
    ax = blank_axes(frame)
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(FixedLocator([10.0**k for k in range(6) if 10.0**k <= MARGIN * bars.max()]))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: tick(v)))
    ax.xaxis.set_minor_locator(NullLocator())
    log_axis(ax, up)
    ax.set_xlim(bars.min() / MARGIN, bars.max() * MARGIN)
    for power in chart.guides:
        guide(ax, power)
    return ax


def tick(value: float) -> str:
    """``1``, ``10``, ``100``, then powers."""
    return f"{value:.0f}" if value < 1e3 else power_of_ten(round(np.log10(value)))


def guide(ax: Axes, power: int) -> None:
    """Thin line of slope `power` from the lower left corner, with its label at the far end."""
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    end = min(right, left * (high / low) ** (1.0 / power))
    top = low * (end / left) ** power
    ax.plot(
        [left, end], [low, top], color=COLOURS["rule"].stand_in, linewidth=0.8, linestyle=(0.0, (2.0, 2.0)), zorder=0
    )
    at = end**0.93 * left**0.07
    ax.text(
        at, low * (at / left) ** power, GUIDE_WORDS[power],
        fontsize=TEXT_SIZE, color=COLOURS["muted"].stand_in, ha="right", va="bottom",
    )  # fmt: skip


def draw(ax: Axes, track: ScalingCurve, pen: Pen) -> None:
    """Draw one engine's curve, its hollow points outlined."""
    colour = pen.colour.stand_in
    ax.plot(track.bars, track.cost, color=colour, linewidth=1.3, zorder=2)
    full = ~track.hollow
    ax.plot(
        track.bars[full],
        track.cost[full],
        pen.marker,
        color=colour,
        markersize=MARKER_SIZE,
        markeredgewidth=0,
        zorder=3,
    )
    ax.plot(
        track.bars[track.hollow], track.cost[track.hollow], pen.marker, color=colour, markersize=MARKER_SIZE,
        fillstyle="none", markeredgewidth=0.9, zorder=3,
    )  # fmt: skip
