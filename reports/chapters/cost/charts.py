"""Work-precision diagrams: cost against error on log-log axes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from reports.plotting.families import CROSS_SIZE, MARKER_SIZE, OTHERS, SHARED, Flags, families, family_pens, group_of
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import MOST_TICKS, ChartFrame, Legend, Panel, blank_axes, finish, log_axis
from reports.plotting.series import Array, DecadeRange, decade_range
from reports.text.numerals import power_of_ten

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

FLOOR_MARGIN = 10.0  # times the certified solution's own error: smaller errors of an engine are unresolved
SOLID_AND_DASHED = "Solid lines: independent physics. Dashed lines: barchain's equations."
LARGEST = 10.0  # larger errors are drawn on the edge
FAILED = Pen(COLOURS["ink"], "x")
DASH = (4.0, 2.0)
"""Dashes of integrators on barchain's equations"""


@dataclass(frozen=True)
class CostCurve:
    """Points of one engine's accuracy sweep, coarse to fine."""

    engine: str
    error: Array
    """(n,); NaN for a failed run without an error"""
    cost: Array
    """(n,); NaN without a measurement"""
    failed: Flags
    """(n,) bool"""
    blurred: Flags
    """(n,) bool: below the floor of the certified solution"""
    independent: bool = True
    """Whether the engine has independent physics"""

    @property
    def drawn(self) -> Flags:
        """Good points that have a place on both axes, (n,) bool."""
        placed = np.isfinite(self.error) & (self.error > 0.0) & np.isfinite(self.cost) & (self.cost > 0.0)
        found: Flags = placed & ~self.failed
        return found


@dataclass(frozen=True)
class Front:
    """Work-precision front of one kind of engines, from the coarsest point."""

    error: Array
    cost: Array
    independent: bool


@dataclass(frozen=True)
class ChartData:
    """Shared contents of all charts of one scene and quantity."""

    name: str
    x_label: str
    y_label: str
    floor: float
    """Error of the certified solution; 0 if negligible"""
    tracks: tuple[CostCurve, ...]

    @property
    def x_span(self) -> DecadeRange | None:
        """Whole decades around all errors; those below the certified solution's error are drawn on the edge."""
        shown = [np.clip(t.error[t.drawn], self.floor, LARGEST) for t in self.tracks]
        return decade_range([*shown, np.array([FLOOR_MARGIN * self.floor])] if self.floor else shown)

    @property
    def y_span(self) -> DecadeRange | None:
        """Whole decades around all costs."""
        return decade_range([t.cost[t.drawn] for t in self.tracks])


def overview(data: ChartData, title: str, fronts: Sequence[Front] = ()) -> Panel | None:
    """Chart of all engines, each family in a colour, both kinds in different lines, with a front for each kind."""
    groups = group_of([t.engine for t in data.tracks])
    dashed = {groups[t.engine] for t in data.tracks if not t.independent}
    pens = {word: styled(pen, dashed=word in dashed) for word, pen in family_pens(list(groups)).items()}
    ax = axes(data, title, "all")
    if ax is None:
        return None
    for front in fronts:
        draw_front(ax, front)
    for track in data.tracks:
        draw(ax, track, pens[groups[track.engine]])
    used = {groups[t.engine] for t in data.tracks if t.drawn.any() or t.failed.any()}
    shown = sorted((word for word in pens if word in used), key=lambda word: word in dashed)
    legend = tuple(Legend(word, pens[word]) for word in shown)
    said = f"{note(data)} {SHARED if len(groups) > len(pens) else ''}".strip()
    return Panel(title, finish(ax, frame(data, title, "all")), said, legend)


def styled(pen: Pen, *, dashed: bool) -> Pen:
    """Pen of an engine of one kind."""
    return replace(pen, dash=DASH) if dashed else pen


def draw_front(ax: Axes, front: Front) -> None:
    """Draw the wide line of a work-precision front."""
    colour = COLOURS["accent" if front.independent else "rule"].stand_in
    if len(front.error) > 1:
        ax.plot(
            front.error, front.cost, color=colour, linewidth=7.0, alpha=0.25 if front.independent else 0.5,
            solid_capstyle="round", zorder=1,
        )  # fmt: skip


def by_family(data: ChartData) -> list[Panel]:
    """One chart for each family: its engines in colour, all others in grey."""
    shown = [t for t in data.tracks if t.drawn.any() or t.failed.any()]
    groups = families([t.engine for t in shown])
    groups = {t.engine: alone(groups[t.engine], t) for t in shown}
    names = sorted(set(groups.values()), key=lambda g: (g in ALONE.values(), list(groups.values()).index(g)))
    found = (family(data, g, [t for t in shown if groups[t.engine] == g]) for g in names)
    return [p for p in found if p]


ALONE = {True: "single engines with independent physics", False: "single integrators on barchain's equations"}
"""Titles of the charts of engines that are alone in their family, by whether their physics is independent"""


def alone(family: str, track: CostCurve) -> str:
    """Family of an engine; those that are alone in theirs are divided by kind."""
    return family if family != OTHERS else ALONE[track.independent]


def family(data: ChartData, name: str, own: list[CostCurve]) -> Panel | None:
    """Chart of one family."""
    title = name[:1].upper() + name[1:]
    ax = axes(data, title, name)
    if ax is None:
        return None
    for track in data.tracks:
        if track.engine not in {t.engine for t in own}:
            ax.plot(track.error[track.drawn], track.cost[track.drawn], color=COLOURS["rule"].stand_in, linewidth=0.8)
    pens = {t.engine: styled(engine_pen(k + 2), dashed=not t.independent) for k, t in enumerate(own)}
    for track in own:
        draw(ax, track, pens[track.engine])
    svg = finish(ax, frame(data, title, name))
    return Panel(title, svg, note(replace(data, tracks=tuple(own))), tuple(Legend(e, p) for e, p in pens.items()))


def frame(data: ChartData, title: str, name: str) -> ChartFrame:
    """Axes and labels of a chart."""
    return ChartFrame(f"{data.name}-{name}", title, data.x_label, data.y_label, (0.0, 1.0))


def axes(data: ChartData, title: str, name: str) -> Axes | None:
    """Empty log-log axes with the certified solution's floor; None if there is nothing to draw."""
    across, up = data.x_span, data.y_span
    if across is None or up is None:
        return None
    ax = blank_axes(frame(data, title, name))
    ax.set_xscale("log")
    first, last = round(np.log10(across.low)), round(np.log10(across.high))
    step = max(1, int(np.ceil((last - first) / MOST_TICKS)))
    ax.xaxis.set_major_locator(FixedLocator([10.0**k for k in range(last, first - 1, -step)]))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda v, _: power_of_ten(round(np.log10(v)))))
    ax.xaxis.set_minor_locator(NullLocator())
    log_axis(ax, up)
    ax.set_xlim(across.low, across.high)
    if data.floor:
        edge = max(FLOOR_MARGIN * data.floor, across.low)
        ax.axvspan(across.low, edge, color=COLOURS["body"].stand_in, linewidth=0, zorder=0)
    return ax


def draw(ax: Axes, track: CostCurve, pen: Pen) -> None:
    """Draw one engine's curve: filled points, hollow ones below the floor, crosses for failures."""
    good, colour = track.drawn, pen.colour.stand_in
    left, right = ax.get_xlim()
    x = np.clip(track.error, left, right)
    line = (0.0, pen.dash) if pen.dash else "solid"
    ax.plot(x[good], track.cost[good], color=colour, linewidth=1.3, linestyle=line, zorder=2)
    sharp, blurred = good & ~track.blurred, good & track.blurred
    ax.plot(x[sharp], track.cost[sharp], pen.marker, color=colour, markersize=MARKER_SIZE, markeredgewidth=0, zorder=3)
    ax.plot(
        x[blurred], track.cost[blurred], pen.marker, color=colour, markersize=MARKER_SIZE, fillstyle="none",
        markeredgewidth=0.9, zorder=3,
    )  # fmt: skip
    lost = track.failed & np.isfinite(track.cost)
    at = np.where(np.isfinite(x), x, right)[lost]
    ax.plot(
        at, track.cost[lost], "x", color=colour, markersize=CROSS_SIZE, markeredgewidth=1.5, clip_on=False, zorder=4
    )
    gone = int((track.failed & ~np.isfinite(track.cost)).sum())
    top = ax.get_ylim()[1]
    ax.plot([right] * gone, [top] * gone, "x", color=colour, markersize=CROSS_SIZE, markeredgewidth=1.5, clip_on=False)


def note(data: ChartData) -> str:
    """Note beside a chart: failed runs, meaning of hollow points."""
    failed = [f"{t.engine} ({int(t.failed.sum())})" for t in data.tracks if t.failed.any()]
    blurred = any((t.blurred & t.drawn).any() for t in data.tracks)
    both = {t.independent for t in data.tracks if t.drawn.any()}
    said = [f"× failed: {', '.join(failed)}." if failed else ""]
    said += [SOLID_AND_DASHED if len(both) > 1 else ""]
    said += ["Hollow: below the floor of the certified solution (shaded)." if blurred else ""]
    return " ".join(s for s in said if s)
