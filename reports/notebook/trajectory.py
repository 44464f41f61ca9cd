"""A trajectory in a notebook: charts of its table, and its size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from reports.notebook.card import card, facts_table, picture
from reports.plotting.palette import SERIES, Pen
from reports.plotting.panels import ChartFrame, Line, linear_panel
from reports.plotting.series import numbered
from reports.text.numerals import significant
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from reports.plotting.series import Array

INCHES = (6.4, 2.2)
"""Width, and height of each chart"""
WIDTH_PX = 400.0
MOST_LABELS = 8
SHOWN = (*CHANNELS["attitude"].columns, *CHANNELS["reaction"].columns)
"""Columns of angles, and of both components of reactions"""


@dataclass(frozen=True)
class TimeChart:
    """One quantity over time."""

    label: str
    """Name and unit"""
    values: Array
    """(n, k)"""
    each: str = ""
    """Word for one column, e.g. ``bar``; empty for a single one"""


def plot(table: pd.DataFrame) -> tuple[Figure, NDArray[np.object_]]:
    """Draw attitude, magnitude of reactions, drift of the centre of mass and residual over time, in Matplotlib's style.

    Parameters
    ----------
    table : DataFrame
        Of :meth:`adapters.trajectory.Trajectory.to_frame`.

    Returns
    -------
    tuple of Figure and ndarray of Axes
        One axes for each quantity that the table holds.
    """
    import matplotlib.pyplot as plt  # noqa: PLC0415  # chooses a backend, which reports have no need of

    found = charts(table)
    made = plt.figure(figsize=(INCHES[0], INCHES[1] * len(found)))
    return made, drawn(made, table["t_s"].to_numpy(float), found)


def html(table: pd.DataFrame, ended: str, info: Mapping[str, object], run: tuple[str, str, str]) -> Markup:
    """HTML of a trajectory from its table.

    Parameters
    ----------
    table : DataFrame
    ended : str
        Reason why the run ended early; empty if it did not.
    info : mapping
        The engine's counters.
    run : tuple of str
        Scene, engine and setting; empty where they are not known.
    """
    t_s, found = table["t_s"].to_numpy(float), charts(table)
    facts = [
        ("Samples", f"{len(t_s)}, from {t_s[0]:g} to {t_s[-1]:g} s" if len(t_s) else "none"),
        *([("Ended", ended)] if ended else []),
        *((c.label, f"at most {significant(float(np.nanmax(np.abs(c.values))))}") for c in found if c.values.size),
        *((name.replace("_", " "), f"{v:.6g}" if isinstance(v, float) else v) for name, v in info.items()),
        ("Table", f"to_frame(): {len(table)} rows, {len(table.columns)} columns"),
    ]
    scene, engine, setting = run
    title = " in ".join(filter(None, [scene, engine])) or "Trajectory"
    return card(title, setting, [drawing(t_s, c) for c in found], facts_table(facts))


def drawing(t_s: Array, chart: TimeChart) -> Markup:
    """Chart of one quantity over time with its legend; empty without samples."""
    columns = chart.values.T
    pens = [Pen(SERIES[2 + k % (len(SERIES) - 2)]) for k in range(len(columns))]
    lines = [Line(t_s, column, pen) for column, pen in zip(columns, pens, strict=True)]
    ends = (float(t_s[0]), float(t_s[-1])) if len(t_s) > 1 else (0.0, 1.0)
    panel = linear_panel(ChartFrame(chart.label, "time, s", chart.label, ends, lines))
    if panel is None:
        return Markup("")
    named = list(enumerate(pens, start=1)) if chart.each and len(pens) <= MOST_LABELS else []
    entry = Markup('<span style="color:{}">\N{EM DASH} {} {}</span> ')
    legend = Markup("").join(entry.format(pen.colour.light, chart.each, k) for k, pen in named)
    return Markup("<div>{}{}</div>").format(picture(panel.svg, WIDTH_PX), legend)


def charts(table: pd.DataFrame) -> list[TimeChart]:
    """Quantities that a table holds, each with its unit."""
    radius = np.linalg.norm(table[["com_x_m", "com_y_m"]].to_numpy(float), axis=1)
    angle, x, y = (numbered(table, name) for name in SHOWN)
    found = [] if angle is None else [TimeChart("attitude, rad", angle, "bar")]
    if x is not None and y is not None:
        found.append(TimeChart("magnitude of reactions, N", np.hypot(x, y), "joint"))
    found.append(TimeChart("change of the CM's radius, m", (radius - radius[:1])[:, None]))
    if "com_residual_m" in table:
        found.append(TimeChart("centre-of-mass residual, m", table[["com_residual_m"]].to_numpy(float)))
    return found


def drawn(made: Figure, t_s: Array, found: Sequence[TimeChart]) -> NDArray[np.object_]:
    """Draw quantities below each other with one axis of time, and return the axes."""
    count = len(found)
    room: dict[str, Any] = {"left": 0.13, "right": 0.97, "top": 1.0 - 0.17 / count, "bottom": 0.25 / count}
    axes: NDArray[np.object_] = made.subplots(
        count, 1, sharex=True, squeeze=False, gridspec_kw=room | {"hspace": 0.45}
    )[:, 0]
    for ax, chart in zip(axes, found, strict=True):
        ax.plot(t_s, chart.values, linewidth=1.2)
        ax.set_title(chart.label, loc="left", fontsize="medium")
        if chart.each and chart.values.shape[1] <= MOST_LABELS:
            names = [f"{chart.each} {j + 1}" for j in range(chart.values.shape[1])]
            place = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "borderaxespad": 0.0}
            ax.legend(names, ncols=len(names), fontsize="small", frameon=False, handlelength=1.2, **place)
    axes[-1].set_xlabel("time, s")
    return axes
