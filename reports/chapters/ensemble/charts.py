"""Fan charts: quantiles over time, the median as a line in two shaded ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from reports.plotting.palette import COLOURS
from reports.plotting.panels import MOST_TICKS, ChartFrame, Panel, blank_axes, finish

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

MOST_PANELS = 6
BOUND = "s2"
OPACITY = (0.22, 0.36)  # outer range, inner range: distinct in both themes and in print


def fans(part: pd.DataFrame, quantity: str, item: str, label: str, period_s: float) -> tuple[Panel, ...]:
    """One panel for each bar or joint, at most :data:`MOST_PANELS`, spread over the chain.

    Parameters
    ----------
    part : DataFrame
        Quantiles of one quantity.
    quantity, item, label : str
        Name of the quantity, word of its item, and label of its axis.
    period_s : float
        Unit of time; 0: seconds.
    """
    items = np.sort(part["item"].unique())
    shown = items[np.unique(np.linspace(0, len(items) - 1, min(len(items), MOST_PANELS)).round().astype(int))]
    return tuple(fan(part[part["item"] == k], f"{quantity}{k}", f"{item} {k}", label, period_s) for k in shown)


def fan(part: pd.DataFrame, name: str, title: str, label: str, period_s: float) -> Panel:
    """Fan chart of one bar or joint."""
    wide = part.pivot_table(index="t_s", columns="quantile", values="value").sort_index(axis=1)
    x = wide.index.to_numpy(dtype=float) / (period_s or 1.0)
    frame = ChartFrame(f"fan-{name}", title.capitalize(), "orbits" if period_s else "s", label, (0.0, float(x[-1])))
    ax = blank_axes(frame)
    ax.yaxis.set_major_locator(MaxNLocator(MOST_TICKS, steps=[1, 2, 2.5, 5, 10]))
    quantile_ranges(ax, x, wide)
    return Panel(frame.title, finish(ax, frame))


def quantile_ranges(ax: Axes, x: np.ndarray, wide: pd.DataFrame) -> None:
    """Draw ranges between symmetrical quantiles, outermost first, and the median."""
    levels, colour = [float(q) for q in wide.columns], COLOURS[BOUND].stand_in
    for k in range(len(levels) // 2):
        low, high = wide[levels[k]].to_numpy(), wide[levels[-1 - k]].to_numpy()
        ax.fill_between(x, low, high, color=colour, alpha=OPACITY[min(k, 1)], linewidth=0)
    if 0.5 in levels:
        ax.plot(x, wide[0.5].to_numpy(), color=COLOURS["ink"].stand_in, linewidth=1.5)
