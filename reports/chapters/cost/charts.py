"""Work-precision diagrams: cost against error on log-log axes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from reports.plotting.families import CROSS_SIZE, MARKER_SIZE, OTHERS, SHARED, Flags, families, family_pens, group_of
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import Array, DecadeRange, decade_range
from reports.plotting.svg import Chart, across, upwards
from reports.text.words import identifier

if TYPE_CHECKING:
    from collections.abc import Sequence

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
    chart = axes(data)
    if chart is None:
        return None
    for front in fronts:
        draw_front(chart, front)
    for track in data.tracks:
        draw(chart, track, pens[groups[track.engine]])
    used = {groups[t.engine] for t in data.tracks if t.drawn.any() or t.failed.any()}
    shown = sorted((word for word in pens if word in used), key=lambda word: word in dashed)
    legend = tuple(Legend(word, pens[word]) for word in shown)
    said = f"{note(data)} {SHARED if len(groups) > len(pens) else ''}".strip()
    return Panel(title, chart.svg(title, f"{data.name}-all"), said, legend)


def styled(pen: Pen, *, dashed: bool) -> Pen:
    """Pen of an engine of one kind."""
    return replace(pen, dash=DASH) if dashed else pen


def draw_front(chart: Chart, front: Front) -> None:
    """Draw the wide line of a work-precision front."""
    colour = COLOURS["accent" if front.independent else "rule"]
    chart.line(front.error, front.cost, colour, 7.0, opacity=0.25 if front.independent else 0.5)


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
    chart = axes(data)
    if chart is None:
        return None
    for track in data.tracks:
        if track.engine not in {t.engine for t in own}:
            chart.line(track.error[track.drawn], track.cost[track.drawn], COLOURS["rule"], 0.8)
    pens = {t.engine: styled(engine_pen(k + 2), dashed=not t.independent) for k, t in enumerate(own)}
    for track in own:
        draw(chart, track, pens[track.engine])
    svg = chart.svg(title, f"{data.name}-{identifier(name)}")
    return Panel(title, svg, note(replace(data, tracks=tuple(own))), tuple(Legend(e, p) for e, p in pens.items()))


def axes(data: ChartData) -> Chart | None:
    """Empty log-log axes with the certified solution's floor; None if there is nothing to draw."""
    errors, costs = data.x_span, data.y_span
    if errors is None or costs is None:
        return None
    chart = Chart(across(errors.low, errors.high, log=True), upwards(costs.low, costs.high, log=True))
    if data.floor:
        edge = float(chart.x(max(FLOOR_MARGIN * data.floor, errors.low)))
        chart.area((chart.x.start, edge), (chart.y.start, chart.y.end), COLOURS["body"])
    chart.axes(data.x_label, data.y_label)
    return chart


def draw(chart: Chart, track: CostCurve, pen: Pen) -> None:
    """Draw one engine's curve: filled points, hollow ones below the floor, crosses for failures."""
    good, colour = track.drawn, pen.colour
    right, top = chart.x.high, chart.y.high
    x = np.clip(track.error, chart.x.low, right)
    chart.line(x[good], track.cost[good], colour, 1.3, pen.dash)
    for hollow, part in ((False, good & ~track.blurred), (True, good & track.blurred)):
        chart.marks(x[part], track.cost[part], pen.marker, colour, MARKER_SIZE, hollow=hollow)
    lost, gone = track.failed & np.isfinite(track.cost), int((track.failed & ~np.isfinite(track.cost)).sum())
    at = np.concatenate([np.where(np.isfinite(x), x, right)[lost], np.full(gone, right)])
    chart.marks(at, np.concatenate([track.cost[lost], np.full(gone, top)]), "x", colour, CROSS_SIZE, edge=1.5)


def note(data: ChartData) -> str:
    """Note beside a chart: failed runs, meaning of hollow points."""
    failed = [f"{t.engine} ({int(t.failed.sum())})" for t in data.tracks if t.failed.any()]
    blurred = any((t.blurred & t.drawn).any() for t in data.tracks)
    both = {t.independent for t in data.tracks if t.drawn.any()}
    said = [f"× failed: {', '.join(failed)}." if failed else ""]
    said += [SOLID_AND_DASHED if len(both) > 1 else ""]
    said += ["Hollow: below the floor of the certified solution (shaded)." if blurred else ""]
    return " ".join(s for s in said if s)
