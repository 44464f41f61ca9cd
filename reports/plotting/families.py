"""Log-log charts of many engines: all in one chart, then family by family.

Engines of one family share a colour where many are drawn together; the charts by family tell them apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reports.plotting.palette import COLOURS, SERIES, Pen, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.svg import Chart, across, upwards
from reports.text.words import identifier

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from reports.plotting.series import Array

Flags = NDArray[np.bool_]
OTHERS = "others"
SHARED = "Engines of one family share a colour here; the charts by family tell them apart."
SOLID_AND_DASHED = "Solid lines: independent physics. Dashed lines: barchain's equations."
MARKER_SIZE, CROSS_SIZE = 5.6, 6.0
DASH = (4.0, 2.0)
"""Dashes of integrators on barchain's equations"""


class EngineCurve(NamedTuple):
    """Measured points of one engine, all fields but the first and the last of shape (n,)."""

    engine: str
    x: Array
    """NaN where it is unknown"""
    y: Array
    """NaN without a measurement"""
    hollow: Flags
    """Drawn outlined"""
    failed: Flags
    """Drawn as crosses, at the edges where a value is unknown"""
    dashed: bool = False

    @property
    def drawn(self) -> Flags:
        """Good points that have a place on both axes, (n,) bool."""
        placed = np.isfinite(self.x) & (self.x > 0.0) & np.isfinite(self.y) & (self.y > 0.0)
        found: Flags = placed & ~self.failed
        return found


@dataclass(frozen=True)
class EngineChart:
    """Contents of a chart of all engines, and of those by family."""

    name: str
    """Unique in the page"""
    title: str
    labels: tuple[str, str]
    """Of both axes"""
    curves: Sequence[EngineCurve]
    ends: tuple[tuple[float, float] | None, tuple[float, float] | None]
    """Least and largest value of each axis; None if there is nothing to draw"""
    hollow_words: str = ""
    """Meaning of outlined points"""
    below: Callable[[Chart], None] = lambda _: None
    """Draws what lies below the curves"""
    ticks: Sequence[tuple[float, str]] | None = None
    engines: Sequence[str] = ()
    """Engines of all charts of a study, so that each keeps its colour; those of the curves by default"""
    alone: Mapping[bool, str] | None = None
    """Name of the family of engines that are alone in theirs, by whether they are dashed"""

    @property
    def known(self) -> list[str]:
        """Engines that have pens."""
        return list(self.engines) or [c.engine for c in self.curves]


def families(engines: Sequence[str]) -> dict[str, str]:
    """Family of each engine: the first word of its name, or ``others`` for single ones."""
    words = [e.partition("-")[0] for e in engines]
    return {e: word if words.count(word) > 1 else OTHERS for e, word in zip(engines, words, strict=True)}


def group_of(engines: Sequence[str]) -> dict[str, str]:
    """Group of each engine that shares a pen: itself if there are enough pens, else the first word of its name."""
    names = list(dict.fromkeys(engines))
    return {e: e if len(names) <= len(SERIES) else e.partition("-")[0] for e in names}


def family_pens(engines: Sequence[str]) -> dict[str, Pen]:
    """One pen for each group of engines."""
    words = list(dict.fromkeys(group_of(engines).values()))
    places = [0, *range(2, len(SERIES)), 1]  # the second neutral comes last
    count = len(places)
    return {word: engine_pen(places[k % count] + k // count * count) for k, word in enumerate(words)}


def overview(chart: EngineChart) -> Panel | None:
    """Chart of all engines, each group in a colour; dashed ones last in the legend. None without anything to draw."""
    groups = group_of(chart.known)
    dashed = {groups[c.engine] for c in chart.curves if c.dashed}
    pens = {word: replace(pen, dash=DASH if word in dashed else ()) for word, pen in family_pens(chart.known).items()}
    coloured = [(c, pens[groups[c.engine]]) for c in chart.curves]
    used = {groups[c.engine] for c in chart.curves if (c.drawn | c.failed).any()}
    legend = [Legend(word, pens[word]) for word in sorted(pens, key=lambda word: word in dashed) if word in used]
    found = panel(chart, coloured, legend, f"{chart.name}-all", chart.title)
    return found and replace(found, note=f"{found.note} {SHARED if len(groups) > len(pens) else ''}".strip())


def by_family(chart: EngineChart, heading: str = "") -> list[Panel]:
    """One chart for each family, its engines in colour and all others in grey; `heading` begins the titles."""
    family = families(chart.known)
    alone = chart.alone or dict.fromkeys((True, False), OTHERS)
    own: dict[str, list[EngineCurve]] = {}
    for curve in (c for c in chart.curves if (c.drawn | c.failed).any()):
        name = family[curve.engine]
        own.setdefault(alone[curve.dashed] if name == OTHERS else name, []).append(curve)
    found = []
    for name, curves in sorted(own.items(), key=lambda item: item[0] in alone.values()):
        group = [e for e in family if family[e] == name] or [c.engine for c in curves]
        pens = [replace(engine_pen(group.index(c.engine) + 2), dash=DASH if c.dashed else ()) for c in curves]
        legend = [Legend(c.engine, pen) for c, pen in zip(curves, pens, strict=True)]
        title = heading + name
        named = f"{chart.name}-{identifier(name)}"
        found.append(panel(chart, list(zip(curves, pens, strict=True)), legend, named, title[:1].upper() + title[1:]))
    return [p for p in found if p]


def panel(
    chart: EngineChart, coloured: Sequence[tuple[EngineCurve, Pen]], legend: Sequence[Legend], name: str, title: str
) -> Panel | None:
    """Chart with some of the curves in colour; None if there is nothing to draw."""
    x, y = chart.ends
    if x is None or y is None:
        return None
    drawn = Chart(across(*x, log=True), upwards(*y, log=True))
    chart.below(drawn)
    drawn.axes(*chart.labels, chart.ticks)
    shown = {c.engine for c, _ in coloured}
    for curve in (c for c in chart.curves if c.engine not in shown):
        drawn.line(curve.x[curve.drawn], curve.y[curve.drawn], COLOURS["rule"], 0.8)
    for curve, pen in coloured:
        draw(drawn, curve, pen)
    return Panel(title, drawn.svg(title, name), note([c for c, _ in coloured], chart.hollow_words), tuple(legend))


def draw(chart: Chart, curve: EngineCurve, pen: Pen) -> None:
    """Draw one engine's curve: filled points, outlined ones, and crosses for failures."""
    good, right = curve.drawn, chart.x.high
    x = np.clip(curve.x, chart.x.low, right)
    chart.line(x[good], curve.y[good], pen.colour, 1.3, pen.dash)
    for hollow, part in ((False, good & ~curve.hollow), (True, good & curve.hollow)):
        chart.marks(x[part], curve.y[part], pen.marker, pen.colour, MARKER_SIZE, hollow=hollow)
    lost, gone = curve.failed & np.isfinite(curve.y), int((curve.failed & ~np.isfinite(curve.y)).sum())
    at = np.concatenate([np.where(np.isfinite(x), x, right)[lost], np.full(gone, right)])
    high = np.concatenate([curve.y[lost], np.full(gone, chart.y.high)])
    chart.marks(at, high, "x", pen.colour, CROSS_SIZE, edge=1.5)


def note(curves: Sequence[EngineCurve], hollow_words: str) -> str:
    """Note beside a chart: failed runs, kinds of lines, and the meaning of outlined points."""
    failed = [f"{c.engine} ({int(c.failed.sum())})" for c in curves if c.failed.any()]
    said = [f"× failed: {', '.join(failed)}."] if failed else []
    said += [SOLID_AND_DASHED] if len({c.dashed for c in curves if c.drawn.any()}) > 1 else []
    said += [hollow_words] if any((c.hollow & c.drawn).any() for c in curves) else []
    return " ".join(filter(None, said))
