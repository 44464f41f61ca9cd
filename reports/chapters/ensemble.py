"""Chapter of an ensemble: quantiles of perturbed runs over time, the median as a line in two shaded ranges."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plotting.palette import COLOURS
from reports.plotting.panels import Panel, linear_span
from reports.plotting.svg import Chart, across, upwards
from reports.results.ensemble import FILES
from reports.text.record import SceneRecord

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

QUANTITIES = {
    "attitude": ("bar", "angle from the z1 axis, rad"),
    "reaction": ("joint", "magnitude of the reaction, N"),
}
MOST_PANELS = 6
OPACITY = (0.22, 0.36)  # outer range, inner range: distinct in both themes and in print


def view_ensemble(folder: Path) -> SimpleNamespace:
    """Contents of the page, from the ensemble in a result folder."""
    tables = FILES.contents(folder, "quantiles")
    about = tables.record.get("scene") or {}
    scene, table = SceneRecord(str(about.get("name") or ""), about), tables.quantiles
    groups = []
    for quantity, (item, label) in QUANTITIES.items():
        part = table[table["quantity"] == quantity]
        items = np.sort(part["item"].unique())
        spread = np.linspace(0, len(items) - 1, min(len(items), MOST_PANELS)).round().astype(int)
        shown, unit_s = items[np.unique(spread)], scene.period_s if scene.in_orbits else 0.0
        panels = [fan(part[part["item"] == k], f"{item} {k}".capitalize(), label, unit_s) for k in shown]
        if panels:
            groups.append((quantity.capitalize(), panels, len(items) - len(panels)))
    last = final(table)
    quantiles = [f"#{100 * q:g} %" for q in (last[0]["values"] if last else ())]
    return SimpleNamespace(record=tables.record, scene=scene, groups=groups, final=last, quantiles=quantiles)


def fan(part: pd.DataFrame, title: str, label: str, period_s: float) -> Panel:
    """Fan chart of one bar or joint; a period of 0 s means time in seconds."""
    wide = part.pivot_table(index="t_s", columns="quantile", values="value").sort_index(axis=1)
    x, values = wide.index.to_numpy(dtype=float) / (period_s or 1.0), wide.to_numpy(float)
    chart = Chart(across(0.0, float(x[-1])), upwards(*linear_span(values[np.isfinite(values)])))
    chart.axes("orbits" if period_s else "s", label)
    for k in range(values.shape[1] // 2):  # between symmetrical quantiles, outermost first
        chart.band(x, values[:, k], values[:, -1 - k], COLOURS["s2"], OPACITY[min(k, 1)])
    if 0.5 in wide:
        chart.line(x, wide[0.5].to_numpy(float), COLOURS["ink"], 1.5)
    return Panel(title, chart.svg(title))


def final(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Quantiles at the last instant, a row for each bar or joint."""
    last = table[table["t_s"] == table["t_s"].max()]
    index = ["quantity", "item", "unit", "runs"]
    wide = last.pivot_table(index=index, columns="quantile", values="value")
    return [
        {**dict(zip(index, key, strict=True)), "values": dict(row)}
        for key, row in zip(wide.index, wide.to_dict("records"), strict=True)
    ]
