"""Charts of errors of other engines, in the inertial frame and in moving frames."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.roundoff.axes import ErrorCurve, Sheet, panel
from reports.chapters.roundoff.chart_parts import (
    HOLLOW,
    QUANTITIES,
    RTOL_LABEL,
    STEPS_LABEL,
    by_pair,
    has_unresolved,
    sizes_of,
)
from reports.chapters.roundoff.charts import SHADED, SIZE_LABEL, by_size
from reports.chapters.roundoff.series import GENERIC, STRAIGHT, Key
from reports.chapters.roundoff.words import size
from reports.plotting.palette import COLOURS, DASHES, MARKERS, Pen, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.tables.files import flags

if TYPE_CHECKING:
    import pandas as pd

    from reports.chapters.roundoff.series import RoundoffData

INERTIAL = "inertial"


def engine_panels(study: RoundoffData, quantity: str) -> tuple[Panel, ...]:
    """One chart of errors against step for each engine, and one of all engines against size."""
    own = good(study.tables.engines)
    own = own[own.quantity == quantity]
    found = [engine_panel(study, part, str(e), quantity) for e, part in own.groupby("engine", sort=False)]
    return tuple(p for p in (*found, all_against_size(study, own, quantity)) if p)


def good(engines: pd.DataFrame) -> pd.DataFrame:
    """Rows with an error."""
    return engines[engines["median"].astype(float) > 0.0]


def frame_pen(frame: str, frames: list[str], marker: str = "") -> Pen:
    """Pen of a frame: the inertial frame has the colour of absolute coordinates."""
    if frame == INERTIAL:
        return Pen(COLOURS["s3"], marker)
    place = [f for f in frames if f != INERTIAL].index(frame)
    return Pen(COLOURS[("s2", "s4", "s7", "s5")[place % 4]], marker, DASHES[1 + place % 3])


def engine_panel(study: RoundoffData, own: pd.DataFrame, engine: str, quantity: str) -> Panel | None:
    """Chart of one engine's errors against its step, or its tolerance with step control."""
    column = "rtol" if own.steps_per_orbit.isna().all() else "steps_per_orbit"
    own = own[own[column].notna()]
    if not len(own):
        return None
    sizes, frames = sizes_of(own), sorted(set(map(str, own.frame)), key=lambda f: (f != INERTIAL, f))
    curves = [
        step_curve(part, column, frame_pen(f, frames, MARKERS[sizes.index(r) % len(MARKERS)]))
        for (f, r), part in by_pair(own, "frame")
    ]
    word, y_label = QUANTITIES.get(quantity, (quantity.capitalize(), "error"))
    x_label = RTOL_LABEL if column == "rtol" else STEPS_LABEL
    name = f"roundoff-engine-{engine}-{quantity}"
    sheet = Sheet(name, f"{word}: {engine}", x_label, y_label, reverse=column == "rtol")
    legend = [Legend(f"{f} frame", frame_pen(f, frames)) for f in frames]
    muted = COLOURS["muted"]
    legend += [Legend(size(study, r), Pen(muted, MARKERS[k % len(MARKERS)], hollow=True)) for k, r in enumerate(sizes)]
    return panel(sheet, curves, tuple(legend), HOLLOW if has_unresolved(curves) else "")


def step_curve(own: pd.DataFrame, column: str, drawn: Pen) -> ErrorCurve:
    """One frame's errors at one size."""
    part = own.sort_values(column)
    x, y, low, high = (part[c].to_numpy(float) for c in (column, "median", "q05", "q95"))
    return ErrorCurve(x, y, drawn, (low, high), blurred=~flags(part.known))


def all_against_size(study: RoundoffData, own: pd.DataFrame, quantity: str) -> Panel | None:
    """Chart of the smallest error of each engine and frame against size."""
    least = least_errors(own)
    names = list(dict.fromkeys(map(str, least.engine)))
    curves, legend = [], []
    for (engine, frame), part in least.groupby(["engine", "frame"], sort=False):
        pen = engine_pen(names.index(str(engine)) + 2)
        drawn = Pen(pen.colour, pen.marker, () if frame == INERTIAL else DASHES[2])
        line = part.sort_values("ratio")
        if len(line) > 1:
            x, y, low, high = (line[c].to_numpy(float) for c in ("ratio", "median", "q05", "q95"))
            curves.append(ErrorCurve(x, y, drawn, (low, high)))
            legend.append(Legend(f"{engine}, {frame}", drawn))
    word, y_label = QUANTITIES.get(quantity, (quantity.capitalize(), "error"))
    title = f"{word}: smallest error of each engine"
    sheet = Sheet(f"roundoff-engines-{quantity}", title, SIZE_LABEL, y_label, study.named)
    return panel(sheet, curves, tuple(legend), f"Over all steps and tolerances. {SHADED}")


def least_errors(own: pd.DataFrame) -> pd.DataFrame:
    """Rows with the smallest median of each engine, frame and size."""
    finite = own[np.isfinite(own["median"].astype(float))]
    if not len(finite):
        return finite
    found: pd.DataFrame = finite.loc[finite.groupby(["engine", "frame", "ratio"], sort=False)["median"].idxmin()]
    return found


def libraries(study: RoundoffData) -> list[tuple[str, str]]:
    """Library and frame of formulations named ``library (frame)``."""
    names = dict.fromkeys(map(str, study.tables.evaluation.formulation))
    return [(m[1], m[2]) for name in names if (m := re.fullmatch(r"(\S+) \((.+)\)", name))]


def library_panels(study: RoundoffData) -> tuple[Panel, ...]:
    """Charts of errors of libraries' evaluations against size, in each frame."""
    pairs = libraries(study)
    names, frames = list(dict.fromkeys(n for n, _ in pairs)), list(dict.fromkeys(f for _, f in pairs))
    pens = {f"{n} ({f})": frame_pen(f, frames, MARKERS[names.index(n) % len(MARKERS)]) for n, f in pairs}
    found = (
        by_size(study, f"roundoff-libraries-{k}", f"One evaluation by other libraries: {state}",
                [Key(name, state=state) for name in pens], lambda key: pens[key.formulation],
                lambda key: key.formulation)
        for k, state in enumerate((GENERIC, STRAIGHT)) if pens
    )  # fmt: skip
    return tuple(p for p in found if p)
