"""Charts of errors of whole runs: against step and tolerance, smallest error against size, growth in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.roundoff.axes import ErrorCurve, Sheet, panel
from reports.chapters.roundoff.chart_parts import (
    HOLLOW,
    QUANTITIES,
    RTOL_LABEL,
    STEPS_LABEL,
    by_pair,
    has_unresolved,
    sizes_of,
)
from reports.chapters.roundoff.charts import DASHES, HUES, SHADED, SIZE_LABEL
from reports.chapters.roundoff.series import ABSOLUTE, DOUBLE, LOST, MINIMAL, RELATIVE, SINGLE
from reports.chapters.roundoff.words import size
from reports.plotting.palette import COLOURS, MARKERS, Pen
from reports.plotting.panels import Legend, Panel
from reports.tables.files import flags

if TYPE_CHECKING:
    import pandas as pd

    from reports.chapters.roundoff.series import RoundoffData
    from reports.plotting.families import Flags
    from reports.plotting.series import Array

SIGNS: dict[str, tuple[float, ...]] = {ABSOLUTE: (), RELATIVE: (6, 2), MINIMAL: (2, 1.6)}
COORDINATES = tuple(SIGNS)
METHODS = {"rk4": "RK4", "dop853": "DOP853 at equal steps", "dop853, chosen steps": "DOP853 with step control"}
RINGED = "Ring: smallest error; finer steps only add round-off."


def run_panels(study: RoundoffData, arithmetic: str, quantities: tuple[str, ...]) -> tuple[Panel, ...]:
    """Errors against step or tolerance, one chart for each quantity and method."""
    table = study.tables.trajectories
    methods = [m for m in METHODS if m in set(table.method)]
    found = (against_step(study, arithmetic, q, m) for q in quantities for m in methods)
    return tuple(p for p in found if p)


def against_step(study: RoundoffData, arithmetic: str, quantity: str, method: str) -> Panel | None:
    """Chart of one quantity and method: every set of coordinates at every size."""
    table = study.tables.trajectories
    own = table[(table.arithmetic == arithmetic) & (table.quantity == quantity) & (table.method == method)]
    if not len(own):
        return None
    chosen = own.steps_per_orbit.isna().all()
    column = "rtol" if chosen else "steps_per_orbit"
    sizes, groups = sizes_of(own), by_pair(own, "coordinates")
    curves = [
        run_curve(study, part, column, run_pen(c, sizes.index(r)))
        for (c, r), part in groups if c in HUES
    ]  # fmt: skip
    ticks = () if chosen else tuple(float(4**k) for k in range(1, 12))
    word, y_label = QUANTITIES[quantity]
    title = f"{word}, {METHODS[method]}{'' if arithmetic == DOUBLE else f', {arithmetic}'}"
    name = f"roundoff-run-{quantity}-{arithmetic}-{list(METHODS).index(method)}"
    sheet = Sheet(name, title, RTOL_LABEL if chosen else STEPS_LABEL, y_label, ticks=ticks, reverse=bool(chosen))
    ringed = any(c.ringed is not None and c.ringed.any() for c in curves)
    return panel(sheet, curves, run_legend(study, own, sizes), marks(ringed, has_unresolved(curves)))


def run_pen(coordinates: str, place: int) -> Pen:
    """Colour and dashes of a set of coordinates, marker of a size."""
    return Pen(COLOURS[HUES[coordinates][0]], MARKERS[place % len(MARKERS)], SIGNS[coordinates])


def marks(ringed: bool, hollow: bool) -> str:
    """Meaning of the marks of a chart."""
    return " ".join([RINGED] * ringed + [HOLLOW] * hollow)


def run_legend(study: RoundoffData, own: pd.DataFrame, sizes: list[float]) -> tuple[Legend, ...]:
    """Colours of coordinates, then markers of sizes."""
    shown = [c for c in COORDINATES if c in set(own.coordinates)]
    coloured = tuple(Legend(c, Pen(COLOURS[HUES[c][0]], "", SIGNS[c])) for c in shown)
    muted = COLOURS["muted"]
    sized = (Legend(size(study, r), Pen(muted, MARKERS[k % len(MARKERS)], hollow=True)) for k, r in enumerate(sizes))
    return (*coloured, *sized)


def run_curve(study: RoundoffData, own: pd.DataFrame, column: str, drawn: Pen) -> ErrorCurve:
    """One run's errors, ringed where round-off takes over."""
    part = own.sort_values(column)
    x, y, low, high = (part[c].to_numpy(float) for c in (column, "median", "q05", "q95"))
    return ErrorCurve(x, y, drawn, (low, high), None, ring(study, part, x, column), ~flags(part.known))


def ring(study: RoundoffData, own: pd.DataFrame, x: Array, column: str) -> Flags:
    """Point of the smallest error in best.csv, if it leaves a digit and is not at the finest setting, (n,)."""
    best, first = study.tables.best, own.iloc[0]
    kept = np.ones(len(best), bool)
    for name in ("ratio", "quantity", "coordinates", "arithmetic", "method"):
        kept &= (best[name] == first[name]).to_numpy(bool)
    found = best[kept & flags(best.settled) & (best["median"] < LOST)][column].to_numpy(float)
    ringed: Flags = np.isin(x, found)
    return ringed


def best_panels(study: RoundoffData, quantities: tuple[str, ...]) -> tuple[Panel, ...]:
    """Charts of the smallest error against size."""
    return tuple(p for q in quantities if (p := best_panel(study, q)))


def best_panel(study: RoundoffData, quantity: str) -> Panel | None:
    """Chart of the smallest error over all methods, steps and tolerances."""
    own = study.tables.best[study.tables.best.quantity == quantity]
    if not len(own):
        return None
    least = own.loc[own.groupby(["coordinates", "arithmetic", "ratio"])["median"].idxmin()]
    curves, legend = [], []
    for c in COORDINATES:
        for a in (SINGLE, DOUBLE):
            part = least[(least.coordinates == c) & (least.arithmetic == a)].sort_values("ratio")
            if len(part):
                drawn = Pen(COLOURS[HUES[c][0]], HUES[c][1], DASHES[a])
                x, y, low, high = (part[k].to_numpy(float) for k in ("ratio", "median", "q05", "q95"))
                curves.append(ErrorCurve(x, y, drawn, (low, high), blurred=~flags(part.settled)))
                legend.append(Legend(f"{c}, {a}", drawn))
    word, y_label = QUANTITIES[quantity]
    sheet = Sheet(f"roundoff-best-{quantity}", f"{word}: smallest error of an orbit", SIZE_LABEL, y_label, study.named)
    hollow = "Hollow: at the finest setting, may decrease further. " if has_unresolved(curves) else ""
    return panel(sheet, curves, tuple(legend), f"Over all methods, steps and tolerances. {hollow}{SHADED}")


def growth_panels(study: RoundoffData, quantities: tuple[str, ...]) -> tuple[Panel, ...]:
    """Charts of errors against time."""
    return tuple(p for q in quantities if (p := growth_panel(study, q)))


def growth_panel(study: RoundoffData, quantity: str) -> Panel | None:
    """Chart of one quantity's error against time."""
    own = study.tables.growth[study.tables.growth.quantity == quantity]
    if not len(own):
        return None
    sizes = sizes_of(own)
    curves = [
        growth_curve(part, run_pen(c, sizes.index(r)))
        for (c, r), part in by_pair(own, "coordinates") if c in HUES
    ]  # fmt: skip
    word, y_label = QUANTITIES[quantity]
    ticks = tuple(2.0**k for k in range(-3, 8))
    sheet = Sheet(f"roundoff-growth-{quantity}", f"{word}: error growth in time", "orbits", y_label, ticks=ticks)
    return panel(sheet, curves, run_legend(study, own, sizes), marks(False, has_unresolved(curves)))


def growth_curve(own: pd.DataFrame, drawn: Pen) -> ErrorCurve:
    """One run's errors."""
    part = own.sort_values("orbits")
    x, y, low, high = (part[c].to_numpy(float) for c in ("orbits", "median", "q05", "q95"))
    return ErrorCurve(x, y, drawn, (low, high), blurred=~flags(part.known))
