"""Chapter of the scaling study: cost against the number of bars."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plotting.families import EngineChart, EngineCurve, by_family, overview
from reports.plotting.panels import guide
from reports.plotting.series import decade_range
from reports.results.outcome import Outcome
from reports.results.rows import plain
from reports.results.scaling import FILES
from reports.text.numerals import power_of_ten, significant

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from reports.plotting.svg import Chart

QUANTITIES = ("evaluation", "orbit", "evaluations per orbit", "steps per orbit", "memory")
SHARED = "Outlined: a part of an orbit, scaled up."
STEPS = "Outlined: time of a step, for engines that do not count evaluations."
SHOWN_MEMORY_B = 2.0**20  # allocators hide less
MARGIN = 1.3  # of the axis beyond the least and the largest N
TICKS = [(10.0**k, str(10**k) if k < 3 else power_of_ten(k)) for k in range(6)]


def view_scaling(folder: Path) -> SimpleNamespace:
    """Contents of the chapter, from the study in a result folder."""
    tables = FILES.contents(folder)
    record, points = tables.record, tables.points
    charts = charts_of(points)
    shown = plain(points)
    bars = sorted({int(row["bars"]) for row in shown if row["orbit_s"] is not None})
    orbits: dict[str, list[dict[str, Any] | None]] = {}  # of each engine, with a place for each number of bars
    stops: dict[tuple[str, str], dict[str, Any]] = {}  # skipped and failed points; of skipped orbits only the first
    for row in shown:
        row["memory"] = memory_text(row["memory_B"])
        if row["orbit_s"] is not None:
            orbits.setdefault(row["engine"], [None] * len(bars))[bars.index(int(row["bars"]))] = row
        good = row["outcome"] == Outcome.PASS.value
        if not good or row["reason"]:
            stops.setdefault((row["engine"], "orbit" if good else str(row["bars"])), row)
    return SimpleNamespace(
        record=record,
        scene=record.get("scene") or {},
        overviews=[p for chart in charts if (p := overview(chart))],
        families=[p for chart in charts for p in by_family(chart, f"{chart.title}: ")],
        exponents=exponents(tables.exponents),
        bars=bars,
        orbits=orbits,
        stops=list(stops.values()),
        points=shown,
    )


def charts_of(points: pd.DataFrame) -> list[EngineChart]:
    """Charts of the time of an evaluation, the time of an orbit, and memory."""
    none = np.zeros(len(points), bool)
    shown = (
        ("scaling-evaluation", "Time of one evaluation", "s", "evaluation_s", points.per == "steps", STEPS),
        ("scaling-orbit", "Time of one orbit", "s", "orbit_s", points.share < 1.0, SHARED),
        ("scaling-memory", "Peak memory above that of three bars", "bytes", "memory_B", none, ""),
    )
    curves = [curves_of(points, column, hollow) for *_, column, hollow, _ in shown]
    engines = list(dict.fromkeys(c.engine for each in curves for c in each))
    found = []
    for (name, title, unit, column, _, words), each in zip(shown, curves, strict=True):
        if each:
            bars = np.concatenate([c.x for c in each])
            ends = (float(bars.min()) / MARGIN, float(bars.max()) * MARGIN), decade_range([c.y for c in each])
            powers = {1: "∝ N", 2: "∝ N²"} if column == "orbit_s" else {1: "∝ N"}
            below = partial(draw_guides, powers=powers)
            labels = ("number of bars N", unit)
            found.append(EngineChart(name, title, labels, each, ends, words, below, TICKS, engines))
    return found


def curves_of(points: pd.DataFrame, column: str, hollow: Any) -> list[EngineCurve]:
    """Each engine's measured values of a column."""
    least = SHOWN_MEMORY_B if column == "memory_B" else np.nextafter(0.0, 1.0)
    good = points.assign(hollow=hollow)[points[column] >= least].sort_values("bars", kind="stable")
    return [
        EngineCurve(
            engine, own.bars.to_numpy(float), own[column].to_numpy(float), own.hollow.to_numpy(bool), ~(own.bars > 0)
        )
        for engine in dict.fromkeys(points.engine)
        if len(own := good[good.engine == engine])
    ]


def draw_guides(chart: Chart, powers: dict[int, str]) -> None:
    """Lines of costs in proportion to powers of N."""
    for power, words in powers.items():
        guide(chart, power, words)


def exponents(found: pd.DataFrame) -> dict[str, list[dict[str, Any] | None]]:
    """Fitted exponents of each engine that has any, with the range of N."""
    fits: dict[str, dict[str, dict[str, Any]]] = {}
    for row in plain(found):
        fits.setdefault(row["engine"], {})[row["quantity"]] = row
    return {engine: [own.get(q) for q in QUANTITIES] for engine, own in fits.items()}


def memory_text(value: float | None) -> str:
    """``12.3 MB``; less than one is hidden by allocators."""
    if value is None:
        return ""
    return "< 1 MB" if value < SHOWN_MEMORY_B else f"{significant(value / 1e6)} MB"
