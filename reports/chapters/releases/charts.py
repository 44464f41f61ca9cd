"""Charts of errors, times and sizes against the release."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.plotting.palette import COLOURS, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import Chart, across, upwards
from reports.tables.nights.releases import ReleaseState

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from reports.plotting.series import Array
    from reports.tables.nights.releases import ReleasesTables

MOST_LABELS = 8
X_LABEL = "release; × at the lower edge: does not run"
SHOWN = ("attitude", "reaction", "com")
Curve = tuple[str, "Array", "Array"]


def release_charts(tables: ReleasesTables) -> tuple[Panel, ...]:
    """Charts of one study."""
    versions = [str(v) for v in tables.releases["version"]]
    place = {version: k for k, version in enumerate(versions)}
    failed = [place[str(r["version"])] for r in rows(tables.releases) if r["state"] != ReleaseState.RUNS.value]
    found = [
        log_chart(f"Largest error: {quantity}", unit, curves, versions, failed)
        for quantity, unit, curves in error_curves(tables.errors, place)
    ]
    found.append(log_chart(
        "Time at equal error, relative to the anchor", "anchor's time = 1",
        ratio_curves(tables.times, place), versions, failed,
    ))  # fmt: skip
    for column, title, unit in (
        ("wheel_B", "Size of the wheel", "bytes"),
        ("import_s", "Time of the first import in a process", "s"),
    ):
        known = tables.releases[tables.releases[column].notna()]
        at = np.array([place[str(v)] for v in known["version"]], float)
        found.append(log_chart(title, unit, [("", at, known[column].to_numpy(float))], versions, failed))
    return tuple(panel for panel in found if panel is not None)


def rows(frame: pd.DataFrame) -> list[dict[str, object]]:
    """Rows of a table."""
    return [{str(k): v for k, v in row.items()} for row in frame.to_dict("records")]


def error_curves(errors: pd.DataFrame, place: dict[str, int]) -> list[tuple[str, str, list[Curve]]]:
    """Curves of each quantity: one a scene."""
    found = []
    good = errors[errors["value"].notna() & (errors["value"] > 0.0)]
    for quantity in (q for q in SHOWN if q in set(good["quantity"])):
        own = good[good["quantity"] == quantity]
        curves = [
            (str(scene), np.array([place[str(v)] for v in part["version"]], float), part["value"].to_numpy(float))
            for scene, part in own.groupby("scene", sort=False)
        ]
        found.append((quantity, str(own["unit"].iloc[0]), curves))
    return found


def ratio_curves(times: pd.DataFrame, place: dict[str, int]) -> list[Curve]:
    """Curves of the time ratio: one a target."""
    return [
        (str(target), np.array([place[str(v)] for v in part["version"]], float), part["ratio"].to_numpy(float))
        for target, part in times.groupby("target", sort=False)
    ]


def log_chart(
    title: str, unit: str, curves: Sequence[Curve], versions: Sequence[str], failed: Sequence[int]
) -> Panel | None:
    """Chart on a logarithmic axis; None if there is nothing to draw."""
    up = decade_range([y for _, _, y in curves if len(y)])
    if up is None:
        return None
    step = max(1, -(-len(versions) // MOST_LABELS))
    chart = Chart(across(-0.7, len(versions) - 0.3), upwards(up.low, up.high, log=True))
    chart.axes(X_LABEL, unit, [(k, versions[k]) for k in range(len(versions) - 1, -1, -step)])
    legend = []
    for k, (label, x, y) in enumerate(curves):
        pen = engine_pen(k + 2)
        chart.line(x, y, pen.colour, 1.1)
        chart.marks(x, y, pen.marker, pen.colour, 4.6)
        if label:
            legend.append(Legend(label, pen))
    if failed:
        chart.marks(failed, [up.low] * len(failed), "x", COLOURS["muted"], 5.0)
    return Panel(title, chart.svg(title), "", tuple(legend))
