"""Chapter of a study of releases: which releases of an engine run, their digits, errors, times and sizes."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plotting.palette import COLOURS, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import Chart, across, upwards
from reports.results.releases import FILES, ReleaseState
from reports.results.rows import known
from reports.text.numerals import significant
from reports.text.record import is_complete

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import pandas as pd

    from reports.results.files import StudyTables

    Curve = tuple[str, pd.DataFrame]  # label, rows with `version` and the drawn column

MOST_LABELS = 8
X_LABEL = "release; × at the lower edge: does not run"
SHOWN = ("attitude", "reaction", "com")
SAME = "the same digits"


def view_releases(folder: Path) -> SimpleNamespace:
    """Contents of the chapter, from the study in a result folder."""
    tables = FILES.contents(folder)
    rows = release_rows(tables)
    return SimpleNamespace(
        record=tables.record,
        finished=is_complete(tables.record),
        scenes=list(tables.record.get("scenes") or {}),
        charts=release_charts(tables),
        rows=rows,
        running=[r for r in rows if r["runs"]],
        changes=[r["version"] for r in rows if r["runs"] and r["digits"] not in {"", SAME}],
    )


def release_rows(tables: StudyTables) -> list[dict[str, Any]]:
    """Releases in their order: state, digits compared with the last release that runs, time ratio, sizes."""
    found, before = [], dict[str, str]()
    for row in tables.releases.to_dict("records"):
        version, runs = str(row["version"]), row["state"] == ReleaseState.RUNS.value
        own = tables.runs[tables.runs["version"].astype(str) == version]
        bits = dict(zip(own["scene"], own["trajectory"], strict=True))
        digits = ""
        if bits and before:
            other = [scene for scene, word in bits.items() if before.get(scene) not in {None, word}]
            digits = f"other digits in {len(other)} of {len(bits)} scenes" if other else SAME
        before = bits or before
        state, reason = row["state"], row["reason"]
        errors = tables.errors[tables.errors["version"].astype(str) == version]
        dead = errors[errors["quantity"] == ""]
        if runs and len(dead):
            every = errors["scene"].nunique()
            state = f"runs in {every - dead['scene'].nunique()} of {every} scenes"
            reason = str(dead["reason"].iloc[0]) or reason
        times = tables.times[tables.times["version"].astype(str) == version]
        found.append(
            {
                "version": version,
                "released": row["released"],
                "state": state,
                "runs": runs,
                "reason": reason,
                "digits": digits,
                "ratio": ratio_words(times.iloc[-1]) if len(times) else "",  # at the finest common target
                "wheel": measured(row["wheel_B"], 1e-6, "MB"),
                "installed": measured(row["installed_B"], 1e-6, "MB"),
                "importing": measured(row["import_s"], 1e3, "ms"),
                "moved": row["moved"],
            }
        )
    return found


def ratio_words(row: pd.Series) -> str:
    """``3.00 (2.50 to 3.50)``."""
    ends = f" ({significant(row['low'])} to {significant(row['high'])})" if known(row["low"]) else ""
    return f"{significant(row['ratio'])}{ends}"


def measured(value: float, factor: float, unit: str) -> str:
    """``1.24 MB``; empty without a measurement."""
    return f"{significant(factor * value)} {unit}" if known(value) else ""


def release_charts(tables: StudyTables) -> list[Panel]:
    """Charts of errors, times and sizes against the release."""
    good = tables.errors[tables.errors["value"] > 0.0]
    charts = []
    for quantity in SHOWN:
        own = good[good["quantity"] == quantity]
        unit = str(own["unit"].iloc[0]) if len(own) else ""
        charts.append(release_chart(tables, f"Largest error: {quantity}", unit, by(own, "scene"), "value"))
    charts += [
        release_chart(tables, "Time at equal error, relative to the anchor", "anchor's time = 1",
                      by(tables.times, "setting"), "ratio"),
        release_chart(tables, "Size of the wheel", "bytes", [("", tables.releases)], "wheel_B"),
        release_chart(tables, "Time of the first import in a process", "s", [("", tables.releases)], "import_s"),
    ]  # fmt: skip
    return [p for p in charts if p]


def by(table: pd.DataFrame, column: str) -> list[Curve]:
    """Parts of a table by the words of a column."""
    return [(str(word), part) for word, part in table.groupby(column, sort=False)]


def release_chart(tables: StudyTables, title: str, unit: str, curves: Sequence[Curve], column: str) -> Panel | None:
    """Chart on a logarithmic axis; None if there is nothing to draw."""
    versions = [str(v) for v in tables.releases["version"]]
    place = {version: k for k, version in enumerate(versions)}
    shown = [(label, part[part[column].notna()]) for label, part in curves]
    up = decade_range([part[column].to_numpy(float) for _, part in shown])
    if up is None:
        return None
    chart = Chart(across(-0.7, len(versions) - 0.3), upwards(up.low, up.high, log=True))
    step = max(1, -(-len(versions) // MOST_LABELS))
    chart.axes(X_LABEL, unit, [(k, versions[k]) for k in range(len(versions) - 1, -1, -step)])
    legend = []
    for k, (label, part) in enumerate(shown):
        pen, x = engine_pen(k + 2), np.array([place[str(v)] for v in part["version"]], float)
        y = part[column].to_numpy(float)
        chart.line(x, y, pen.colour, 1.1)
        chart.marks(x, y, pen.marker, pen.colour, 4.6)
        legend += [Legend(label, pen)] if label else []
    failed = np.flatnonzero(tables.releases["state"] != ReleaseState.RUNS.value)
    chart.marks(failed, np.full(len(failed), up.low), "x", COLOURS["muted"], 5.0)
    return Panel(title, chart.svg(title), "", tuple(legend))
