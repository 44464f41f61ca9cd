"""Fan charts: quantiles over time, the median as a line in two shaded ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.plotting.palette import COLOURS
from reports.plotting.panels import Panel, linear_span
from reports.plotting.svg import Chart, across, upwards

if TYPE_CHECKING:
    import pandas as pd

    from reports.plotting.series import Array

MOST_PANELS = 6
BOUND = "s2"
OPACITY = (0.22, 0.36)  # outer range, inner range: distinct in both themes and in print


def fans(part: pd.DataFrame, item: str, label: str, period_s: float) -> tuple[Panel, ...]:
    """One panel for each bar or joint, at most :data:`MOST_PANELS`, spread over the chain.

    Parameters
    ----------
    part : DataFrame
        Quantiles of one quantity.
    item, label : str
        Word of one bar or joint, and label of the vertical axis.
    period_s : float
        Unit of time; 0: seconds.
    """
    items = np.sort(part["item"].unique())
    shown = items[np.unique(np.linspace(0, len(items) - 1, min(len(items), MOST_PANELS)).round().astype(int))]
    return tuple(fan(part[part["item"] == k], f"{item} {k}", label, period_s) for k in shown)


def fan(part: pd.DataFrame, title: str, label: str, period_s: float) -> Panel:
    """Fan chart of one bar or joint."""
    wide = part.pivot_table(index="t_s", columns="quantile", values="value").sort_index(axis=1)
    x = wide.index.to_numpy(dtype=float) / (period_s or 1.0)
    values = wide.to_numpy(float)
    chart = Chart(across(0.0, float(x[-1])), upwards(*linear_span(values[np.isfinite(values)])))
    chart.axes("orbits" if period_s else "s", label)
    quantile_ranges(chart, x, wide)
    return Panel(title.capitalize(), chart.svg(title.capitalize()))


def quantile_ranges(chart: Chart, x: Array, wide: pd.DataFrame) -> None:
    """Draw ranges between symmetrical quantiles, outermost first, and the median."""
    levels = [float(q) for q in wide.columns]
    for k in range(len(levels) // 2):
        low, high = wide[levels[k]].to_numpy(), wide[levels[-1 - k]].to_numpy()
        chart.band(x, low, high, COLOURS[BOUND], OPACITY[min(k, 1)])
    if 0.5 in levels:
        chart.line(x, wide[0.5].to_numpy(), COLOURS["ink"], 1.5)
