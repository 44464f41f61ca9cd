"""Charts of cost against error on the pages of the engines."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from adapters.registry import COMPILED
from pictures.pages.engine_page import COST_SCENE, page_file
from pictures.templating import render
from pictures.themes import theme_css
from reports.plotting.families import EngineChart, EngineCurve, overview
from reports.plotting.palette import COLOURS
from reports.plotting.series import decade_range

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from pictures.pages.libraries import EngineLibrary
    from pictures.pages.record import MeasuredRecord
    from reports.plotting.panels import Legend, Panel

ROW_PX, COLUMN_PX = 18, 130
LEGEND_COLUMNS = 3
WORDS = {"attitude_error_rad": ("attitude", "rad"), "com_error_m": ("centre of mass", "m")}


@dataclass(frozen=True)
class LegendEntry:
    """Entry of the legend with its place."""

    legend: Legend
    x: int
    y: int


def chart_file(library: EngineLibrary) -> Path:
    """File of a library's chart."""
    return page_file(library).with_name(f"{library.page}-cost.svg")


def cost_chart(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """SVG of time against error for the engines of a library and the compiled reference; empty without points."""
    points = measured.points[(measured.points.scene == COST_SCENE) & (measured.points.outcome == "pass")]
    own = points[points.engine.isin(list(library.engines))]
    column = next((c for c in WORDS if own[c].notna().any()), None)
    if column is None or not own.seconds.notna().any():
        return ""
    names = list(dict.fromkeys([*own.engine, COMPILED]))
    words, unit = WORDS[column]
    curves = [curve(points[points.engine == n], n, column, library) for n in names]
    labels = f"largest error of the {words}, {unit}", "s"
    ends = decade_range([c.x[c.drawn] for c in curves]), decade_range([c.y[c.drawn] for c in curves])
    title = f"{library.title}: time against error in {COST_SCENE}, first orbit"
    panel = overview(EngineChart(library.page, title, labels, curves, ends))
    return "" if panel is None else standalone(panel)


def curve(points: pd.DataFrame, engine: str, column: str, library: EngineLibrary) -> EngineCurve:
    """Points of one engine."""
    error, none = points[column].to_numpy(float), np.zeros(len(points), bool)
    external = engine in library.engines and library.engines[engine].external
    return EngineCurve(engine, error, points.seconds.to_numpy(float), none, none, dashed=not external)


def standalone(panel: Panel) -> str:
    """Chart of a page as a file of its own: with its colours and its legend."""
    size = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', panel.svg)
    assert size is not None
    width, height = float(size[1]), float(size[2])
    entries = [
        LegendEntry(e, 24 + COLUMN_PX * (k % LEGEND_COLUMNS), int(height) + 14 + ROW_PX * (k // LEGEND_COLUMNS))
        for k, e in enumerate(panel.legend)
    ]
    return render(
        "chart.svg.j2",
        alt=panel.title,
        width=int(width),
        height=entries[-1].y + 14,
        drawing=Markup(str(panel.svg).strip().partition(">")[2].removesuffix("</svg>")),
        entries=entries,
        themes=theme_css("", tuple(COLOURS)),
    )
