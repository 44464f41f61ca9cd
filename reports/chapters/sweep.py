"""Chapter of a parameter sweep: curves and maps over numbers of a grid, histograms and quantiles of drawn ones."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plotting.palette import COLOURS, DASHES, DIGITS, Colour, engine_pen
from reports.plotting.panels import Legend, Panel, linear_span
from reports.plotting.svg import HEIGHT, RIGHT, WIDTH, Chart, Scale, across, upwards
from reports.results.outcome import Outcome
from reports.results.rows import plain
from reports.results.sweep import FILES, samples_of
from reports.text.numerals import digits_apart, powers, typeset, unpadded
from reports.text.record import SceneRecord

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    import pandas as pd

    from reports.plotting.series import Array

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
LOW, MIDDLE, HIGH = QUANTILES[0], 0.5, QUANTILES[-1]
MOST_CURVES = 4
"""Values of further numbers that a chart of curves tells apart; of more, two numbers make a map"""
MOST_PANELS = 24
MOST_ROWS = 200
"""Of the table of values; `barchain show --csv` has all"""
FEWEST_DIGITS = 6
"""Of a value in a table; more where values lie closer together"""
MOST_BINS, FEWEST_BINS = 40, 5
OPACITY = 0.2
SHADES = tuple(Colour(f"d{k}", light, dark) for k, (light, dark) in enumerate(DIGITS))
"""Colours of a map, of one hue: lightness alone tells them apart"""
REMARK = "†"
"""In a cell of a map some of whose runs ended early, or lack a measure"""
BAR_PX, BAR_ROOM_PX = 12.0, 88.0
"""Width of a map's bar of colours, and of all that lies to the right of the map"""


@dataclass(frozen=True)
class Sweep:
    """A sweep as its charts need it."""

    samples: pd.DataFrame
    axes: list[str]
    """Numbers with several values on a grid or a list"""
    drawn: list[str]
    tied: list[str]
    """Numbers whose values go with those of another one"""
    units: dict[str, str]
    """Of numbers that vary, and of measures"""
    measures: list[str]

    @property
    def engines(self) -> list[str]:
        """Engines in their order."""
        return list(dict.fromkeys(self.samples["engine"]))

    def unit(self, name: str) -> str:
        """Unit of a number or measure; empty of a ratio."""
        return self.units[name].removeprefix("1")

    def labelled(self, name: str) -> str:
        """Name with its unit."""
        return ", ".join(filter(None, [name, self.unit(name)]))

    def each(self, names: list[str]) -> Iterator[tuple[str, pd.DataFrame]]:
        """Runs of each engine at each value of some numbers, with what tells them from the others in words."""
        values = [list(dict.fromkeys(self.samples[name])) for name in names]
        for engine, point in itertools.product(self.engines, itertools.product(*values)):
            words = [engine] if len(self.engines) > 1 else []
            own = self.samples[self.samples["engine"] == engine]
            for name, value in zip(names, point, strict=True):
                own = own[own[name] == value]
                words.append(f"{name} = {exact(value)}")
            yield ", ".join(words), own


def view_sweep(folder: Path) -> SimpleNamespace:
    """Contents of the page, from the sweep in a result folder."""
    tables = FILES.contents(folder)
    record, about = tables.record, tables.record.get("scene") or {}
    varied: dict[str, str] = record.get("varied") or {}
    measures: dict[str, str] = record.get("measures") or {}
    samples = samples_of(tables.values, tables.runs, tables.measures)
    units = {row["quantity"]: row["unit"] for row in plain(tables.values.drop_duplicates("quantity"))} | measures
    grids = [path for path, kind in varied.items() if kind == "grid" and path in samples]
    axes = [path for path in grids if samples[path].nunique() > 1]
    drawn = [path for path, kind in varied.items() if kind == "drawn" and path in samples]
    tied = [path for path, kind in varied.items() if kind == "tied" and path in samples]
    shown = Sweep(samples, axes, drawn, tied, units, [name for name in measures if name in samples])
    panels = list(itertools.chain.from_iterable(panels_of(shown, name) for name in shown.measures))
    return SimpleNamespace(
        record=record,
        scene=SceneRecord(str(about.get("name") or ""), about),
        outcomes=samples["outcome"].value_counts(sort=False).to_dict(),
        panels=panels[:MOST_PANELS],
        left_out=len(panels) - MOST_PANELS,
        quantiles=quantile_rows(shown) if drawn else [],
        shares=[f"#{100.0 * share:g} %" for share in QUANTILES],
        headings=["Engine"] * (len(shown.engines) > 1) + [f"#{name}" for name in numbers(shown)],
        rows=value_rows(shown),
        more=len(samples) - MOST_ROWS,
        remarks=[row for row in plain(samples) if row["reason"]][:MOST_ROWS],
        bad=[str(o) for o in samples["outcome"].unique() if o != Outcome.PASS.value],
    )


def numbers(sweep: Sweep) -> list[str]:
    """Columns of the table of values."""
    return [*sweep.axes, *sweep.drawn, *sweep.tied, *sweep.measures]


def panels_of(sweep: Sweep, measure: str) -> Iterator[Panel]:
    """Charts of a measure."""
    if not sweep.axes:
        found = [histogram(sweep, measure)] if sweep.drawn else []
    else:
        first, *further = sweep.axes
        count = int(sweep.samples.groupby(further).ngroups) if further else 1
        if count <= MOST_CURVES:
            found = [curves(sweep, measure, first, further)]
        else:
            across_by, up_by, *rest = sweep.axes
            found = [value_map(sweep, measure, (across_by, up_by), *part) for part in sweep.each(rest)]
    yield from (panel for panel in found if panel)


def curves(sweep: Sweep, measure: str, axis: str, further: list[str]) -> Panel | None:
    """Chart of a measure over one number: medians between quantiles where several runs share its value."""
    parts = [(words, quantiles(own, [axis], measure)) for words, own in sweep.each(further)]
    values = np.concatenate([part[[LOW, HIGH]].to_numpy(float).ravel() for _, part in parts])
    if not np.isfinite(values).any():
        return None
    x = sweep.samples[axis].to_numpy(float)
    chart = Chart(across(*linear_span(x)), upwards(*linear_span(values[np.isfinite(values)])))
    chart.axes(sweep.labelled(axis), sweep.unit(measure))
    legend = []
    for k, (words, part) in enumerate(parts):
        pen, at = replace(engine_pen(k + 2), dash=DASHES[k % len(DASHES)]), part.index.to_numpy(float)
        if sweep.drawn:
            chart.band(at, part[LOW].to_numpy(float), part[HIGH].to_numpy(float), pen.colour, OPACITY)
        chart.line(at, part[MIDDLE].to_numpy(float), pen.colour, 1.4, pen.dash)
        chart.marks(at, part[MIDDLE].to_numpy(float), pen.marker, pen.colour)
        legend += [Legend(words, pen)] if words else []
    note = f"Line: median; shaded: {100 * LOW:g} to {100 * HIGH:g} % of the draws." if sweep.drawn else ""
    return Panel(measure, chart.svg(measure), note, tuple(legend))


def quantiles(samples: pd.DataFrame, by: list[str], measure: str) -> pd.DataFrame:
    """Quantiles of a measure over all draws, a row for each value of some numbers, in rising order."""
    return samples.groupby(by)[measure].quantile(np.array(QUANTILES)).unstack()


def value_map(sweep: Sweep, measure: str, axes: tuple[str, str], words: str, own: pd.DataFrame) -> Panel | None:
    """Map of a measure over two numbers: a cell for each pair of values, coloured and, where there is room, written."""
    table = own.groupby(list(axes))[measure].median().unstack(axes[1])
    values = table.to_numpy(float)
    if not np.isfinite(values).any():
        return None
    remarked = own[own["reason"] != ""].groupby(list(axes)).size().unstack(axes[1]).reindex_like(table).gt(0).to_numpy()
    columns, rows = (edges(index.to_numpy(float)) for index in (table.index, table.columns))
    low, high = linear_span(values[np.isfinite(values)]) if np.ptp(values[np.isfinite(values)]) == 0.0 else (
        float(np.nanmin(values)), float(np.nanmax(values)))  # fmt: skip
    x = Scale(columns[0], columns[-1], across(0.0, 1.0).start, WIDTH - BAR_ROOM_PX)
    chart = Chart(x, upwards(rows[0], rows[-1]))
    chart.axes(sweep.labelled(axes[0]), sweep.labelled(axes[1]))
    for (i, left, right), (j, below, above) in itertools.product(cells(x(columns)), cells(chart.y(rows))):
        value, middle = values[i, j], (0.5 * (left + right), 0.5 * (below + above) + 4.0)
        if np.isfinite(value):
            chart.area((left, right), (below, above), SHADES[shade(value, low, high)])
        else:
            chart.text(middle, "×", "middle")
        if remarked[i, j] and np.isfinite(value):
            chart.text(middle, REMARK, "middle")
    colour_bar(chart, low, high, sweep.unit(measure))
    lost = "×: no value. " if not np.isfinite(values).all() else ""
    early = f"{REMARK}: a run ended early; see the remarks. " if (remarked & np.isfinite(values)).any() else ""
    note = f"{lost}{early}{'Medians of the draws.' if sweep.drawn else ''}".strip()
    return Panel(f"{measure}: {words}" if words else measure, chart.svg(measure), note)


def edges(values: Array) -> Array:
    """Edges of cells about some rising values, in the middle between them."""
    if len(values) == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    middle = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2.0 * values[0] - middle[0]], middle, [2.0 * values[-1] - middle[-1]]])


def cells(places: Array) -> Iterator[tuple[int, float, float]]:
    """Number and both ends of each cell, px."""
    for k, (start, end) in enumerate(itertools.pairwise(places.tolist())):
        yield k, start, end


def shade(value: float, low: float, high: float) -> int:
    """Index of a value's colour."""
    return min(int(len(SHADES) * (value - low) / (high - low)), len(SHADES) - 1)


def colour_bar(chart: Chart, low: float, high: float, unit: str) -> None:
    """Colours of a map from the least to the largest value, beside it."""
    left = WIDTH - BAR_ROOM_PX + RIGHT
    scale = Scale(low, high, chart.y.start, chart.y.end)
    ends = np.linspace(low, high, len(SHADES) + 1)
    digits = digits_apart(ends, 5)
    for k, below, above in cells(scale(ends)):
        chart.area((left, left + BAR_PX), (below, above), SHADES[k])
    for value in ends:
        chart.text((left + BAR_PX + 4.0, float(scale(value)) + 4.0), exact(float(value), digits))
    chart.text((left, HEIGHT - 6.0), unit)


def histogram(sweep: Sweep, measure: str) -> Panel | None:
    """Chart of the number of draws in each range of a measure, a curve for each engine."""
    values = sweep.samples[measure].to_numpy(float)
    values = values[np.isfinite(values)]
    if not values.size:
        return None
    bins = int(np.clip(np.sqrt(values.size), FEWEST_BINS, MOST_BINS))
    ends = np.linspace(*linear_span(values), bins + 1)
    parts = [(words, np.histogram(own[measure].dropna(), ends)[0].astype(float)) for words, own in sweep.each([])]
    chart = Chart(across(ends[0], ends[-1]), upwards(0.0, 1.05 * max(float(counts.max()) for _, counts in parts)))
    chart.axes(sweep.unit(measure), "runs")
    x, legend = np.repeat(ends, 2), []
    for k, (words, counts) in enumerate(parts):
        y, pen = np.concatenate([[0.0], np.repeat(counts, 2), [0.0]]), engine_pen(k + 2)
        chart.band(x, np.zeros_like(y), y, pen.colour, OPACITY)
        chart.line(x, y, pen.colour)
        legend += [Legend(words, pen)] if words else []
    middle, digits = float(np.median(values)), digits_apart(values)
    chart.up_at(middle, COLOURS["muted"], 0.9)
    return Panel(measure, chart.svg(measure), f"Thin line: median, {typeset(middle, digits)}.", tuple(legend))


def quantile_rows(sweep: Sweep) -> list[dict[str, Any]]:
    """Quantiles of each measure over the draws, for each engine and each point of the grids."""
    found = []
    for measure, (words, own) in itertools.product(sweep.measures, sweep.each(sweep.axes)):
        values = own[measure].dropna()
        if len(values):
            place = {"measure": measure, "unit": sweep.unit(measure), "of": words, "runs": len(values)}
            ranks = values.quantile(list(QUANTILES)).tolist()
            digits = digits_apart(ranks, FEWEST_DIGITS)
            found.append(place | {"values": [exact(value, digits) for value in ranks]})
    return found[:MOST_ROWS]


def value_rows(sweep: Sweep) -> list[dict[str, Any]]:
    """First rows of the table of values."""
    several = len(sweep.engines) > 1
    digits = {name: digits_apart(sweep.samples[name].to_numpy(float), FEWEST_DIGITS) for name in numbers(sweep)}
    return [
        {"engine": row["engine"] if several else "", "values": [exact(row[name], digits[name]) for name in digits]}
        for row in plain(sweep.samples.head(MOST_ROWS))
    ]


def exact(value: float | None, digits: int = FEWEST_DIGITS) -> str:
    """Number to some digits, without zeros at its end; empty for None."""
    return "" if value is None else powers(unpadded(f"{value:.{digits}g}"))
