"""Chapter of the cost study: work-precision diagrams, cost at equal error, orders and the price of one more digit."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plotting.families import EngineChart, EngineCurve, by_family, overview
from reports.plotting.palette import COLOURS
from reports.plotting.series import decade_range
from reports.results.cost import BASELINE, INDEPENDENT, KINDS, busy_machine, read_cost
from reports.results.outcome import Outcome
from reports.results.rows import plain, was_run
from reports.text.words import anchor

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import pandas as pd

    from reports.plotting.svg import Chart

FLOOR_MARGIN = 10.0  # times the certified solution's own error: smaller errors of an engine are unresolved
LARGEST = 10.0  # larger errors are drawn on the edge
QUANTITIES = {  # columns of errors and floors, label of the axis
    "attitude": ("attitude_error_rad", "attitude_floor_rad", "largest attitude error, rad"),
    "reaction": ("reaction_relative", "reaction_floor_relative", "largest reaction error / largest reaction"),
}
LABELS = {"seconds": "simulate, s", "evaluations": "evaluations of the right-hand side"}
REACH = (
    ("attitude", "seconds", "Time to reach an attitude error"),
    ("reaction", "seconds", "Time to reach a relative reaction error"),
    ("attitude", "evaluations", "Evaluations to reach an attitude error"),
)
ALONE = {False: "single engines with independent physics", True: "single integrators on barchain's equations"}
"""Titles of the charts of engines that are alone in their family, by whether they integrate barchain's equations"""
HOLLOW = "Hollow: below the floor of the certified solution (shaded)."


def view_cost(folder: Path) -> SimpleNamespace:
    """Contents of the chapter, from the study in a result folder."""
    tables = read_cost(folder)
    found = []
    for scene in dict.fromkeys(tables.points.scene):
        own = {name: getattr(tables, name) for name in ("points", "orders", "reach", "price", "loads")}
        found.append(scene_of(scene, {k: t[t.scene == scene] for k, t in own.items()}, tables.record))
    return SimpleNamespace(record=tables.record, scenes=found, busy=busy_machine(tables.record))


def scene_of(scene: str, tables: dict[str, pd.DataFrame], record: dict[str, Any]) -> dict[str, Any]:
    """One scene's part of the chapter."""
    points, name = tables["points"], f"cost-{anchor(scene)}"
    facts = (record.get("scenes") or {}).get(scene, {})
    timed = chart_of(points, "attitude", "seconds", f"{name}-attitude", "Time against attitude error")
    charts = (
        replace(timed, below=partial(draw_fronts, points=points, below=timed.below)),
        chart_of(points, "reaction", "seconds", f"{name}-reaction", "Time against error of reactions"),
        chart_of(points, "attitude", "evaluations", f"{name}-count", "Evaluations against attitude error"),
    )
    reach = [table for q, m, title in REACH if (table := reach_table(tables["reach"], q, m, title))["groups"]]
    return {
        "name": scene,
        "anchor": name,
        "title": str(facts.get("title") or scene),
        "orbits": facts.get("orbits"),
        "solution": (record.get("certified_solutions") or {}).get(scene, {}),
        "overviews": [p for chart in charts if (p := overview(chart))],
        "families": by_family(timed),
        "reach": reach,
        "baseline": next((t for t in reach if t["timed"] and BASELINE in t["engines"]), None),
        "baseline_name": BASELINE,
        "orders": plain(tables["orders"]),
        "price": prices(tables["price"]),
        "phase_times": phase_times(points, record.get("engines") or {}),
        "points": plain(points),
        "loads": [row | {"text": share_text(row)} for row in plain(tables["loads"])],
        "shortened_s": (record.get("shortened_limits_s") or {}).get(scene),
        "left_out": [r for r in record.get("left_out") or () if r.get("scene") == scene],
    }


def chart_of(points: pd.DataFrame, quantity: str, cost: str, name: str, title: str) -> EngineChart:
    """Chart of cost against error with a curve for each engine; errors below the solution's own lie on the edge."""
    error, floor_name, label = QUANTITIES[quantity]
    least = points[floor_name].max()
    floor = 0.0 if np.isnan(least) else float(least)
    curves = [curve_of(own, error, floor_name, cost) for _, own in points.groupby("engine", sort=False)]
    # an undeclared quantity is no failure
    untracked = {str(e) for e, own in points.groupby("engine") if own.com_error_m.isna().all()}
    kept = [c for c in curves if np.isfinite(c.x).any() or c.engine in untracked]
    errors = [np.clip(c.x[c.drawn], floor, LARGEST) for c in kept]
    across = decade_range([*errors, np.array([FLOOR_MARGIN * floor])] if floor else errors)
    ends = across, decade_range([c.y[c.drawn] for c in kept])
    below = partial(shade_floor, floor=floor)
    return EngineChart(name, title, (label, LABELS[cost]), kept, ends, HOLLOW, below, alone=ALONE)


def curve_of(own: pd.DataFrame, error: str, floor: str, cost: str) -> EngineCurve:
    """Points of one engine's accuracy sweep, coarse to fine; unresolved ones are hollow."""
    run = own[own.outcome.map(was_run)]
    errors = run[error].to_numpy(float)
    return EngineCurve(
        str(own.engine.iloc[0]),
        errors,
        run[cost].to_numpy(float),
        hollow=errors < FLOOR_MARGIN * run[floor].to_numpy(float),
        failed=(run.outcome != Outcome.PASS.value).to_numpy() & (cost == "seconds"),
        dashed=str(own.kind.iloc[0]) != INDEPENDENT,
    )


def shade_floor(chart: Chart, floor: float) -> None:
    """Shade errors that the certified solution does not resolve."""
    if floor:
        edge = float(chart.x(max(FLOOR_MARGIN * floor, chart.x.low)))
        chart.area((chart.x.start, edge), (chart.y.start, chart.y.end), COLOURS["body"])


def draw_fronts(chart: Chart, points: pd.DataFrame, below: Callable[[Chart], None]) -> None:
    """Draw the work-precision front of each kind of engines as a wide line, from the coarsest point."""
    below(chart)
    best = points[points.on_front].sort_values("attitude_error_rad", ascending=False)
    for kind in KINDS:
        own = best[best.kind == kind]
        colour, opacity = ("accent", 0.25) if kind == INDEPENDENT else ("rule", 0.5)
        error, cost = own.attitude_error_rad.to_numpy(float), own.seconds.to_numpy(float)
        chart.line(error, cost, COLOURS[colour], 7.0, opacity=opacity)


def reach_table(reach: pd.DataFrame, quantity: str, measure: str, title: str) -> dict[str, Any]:
    """Costs to reach target errors: for each kind of engines its heading, and a row for each engine."""
    own = reach[(reach.quantity == quantity) & (reach.measure == measure)]
    targets = [float(t) for t in dict.fromkeys(own.target)]
    cells = {(r["engine"], r["target"]): r for r in plain(own)}
    groups = [
        (heading, [(str(e), [cells[e, t] for t in targets]) for e in dict.fromkeys(own[own.kind == kind].engine)])
        for kind, heading in KINDS.items()
        if (own.kind == kind).any()
    ]
    return {
        "title": title, "targets": targets, "groups": groups, "timed": measure == "seconds", "engines": set(own.engine),
    }  # fmt: skip


def share_text(load: dict[str, Any]) -> tuple[str, str]:
    """Share of the loads and its interval, in per cent; not resolved where the interval is wider than the share.

    A share lies between 0 and 1: an interval beyond tells of the machine's noise alone.
    """
    share, low, high = (load.get(name) for name in ("share", "share_low", "share_high"))
    if share is None or low is None or high is None:
        return ("" if share is None else f"{100.0 * share:.0f} %"), ""
    if low <= 0.0 or high >= 1.0 or high - low > share:
        return "not resolved", ""
    return f"{100.0 * share:.0f} %", f"{100.0 * low:.0f} to {100.0 * high:.0f} %"


def prices(price: pd.DataFrame) -> list[dict[str, Any]]:
    """Cost factors of one more digit, one row for each engine: in time and in evaluations."""
    found: dict[str, dict[str, Any]] = {}
    for row in plain(price):
        found.setdefault(row["engine"], {"engine": row["engine"], "kind": row["kind"]})[row["measure"]] = row
    return list(found.values())


def phase_times(points: pd.DataFrame, engines: dict[str, Any]) -> list[dict[str, Any]]:
    """Times of each engine to build and read out (medians), and to compile (the largest), s."""
    by_engine = points.groupby("engine", sort=False)
    found = by_engine.agg({"kind": "first", "build_s": "median", "compile_s": "max", "read_s": "median"})
    return [
        row | {"version": engines.get(row["engine"], {}).get("version") or ""} for row in plain(found.reset_index())
    ]
