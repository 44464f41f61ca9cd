"""A trajectory in a notebook: charts of its table, and its size."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from reports.motion.charts import main_charts
from reports.motion.figure import MOST_LABELS
from reports.notebook.card import card, facts_table, picture
from reports.plotting.palette import SERIES, Pen
from reports.plotting.panels import ChartFrame, Line, linear_panel
from reports.text.numerals import significant

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from reports.motion.charts import TimeChart
    from reports.plotting.series import Array

WIDTH_PX = 400.0


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
    t_s, found = table["t_s"].to_numpy(float), main_charts(table)
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
