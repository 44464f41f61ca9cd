"""Charts of the round-off chapter: of one evaluation, of an orbit, of other engines."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.chapters.roundoff.axes import Axes, ErrorCurve, error_chart
from reports.chapters.roundoff.series import (
    ABSOLUTE,
    ACCELERATIONS,
    BOTH,
    DOUBLE,
    FORMULA,
    GENERIC,
    HORIZONTAL,
    INPUT,
    LONG,
    LOST,
    METHODS,
    MINIMAL,
    ORDINARY,
    POSITIONS,
    QUANTITIES,
    REACTION,
    RELATIVE,
    RELATIVE_POSITIONS,
    SINGLE,
    SPIN,
    STRAIGHT,
    UNEQUAL,
    USUAL,
    number_or_none,
    rows_of,
)
from reports.plotting.palette import COLOURS, MARKERS, Pen, engine_pen
from reports.plotting.palette import DASHES as OTHER_DASHES
from reports.plotting.panels import Legend
from reports.text.numerals import decade

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import pandas as pd

    from reports.chapters.roundoff.series import RoundoffData
    from reports.plotting.panels import Panel
    from reports.plotting.series import Array

    Series = tuple[str, Pen, dict[str, Any]]  # label, pen, key of a series of an evaluation

PENS = {
    name: Pen(COLOURS[hue], marker)
    for name, hue, marker in (
        (RELATIVE, "s2", "o"), (ABSOLUTE, "s3", "s"), (MINIMAL, "s4", "^"), (ACCELERATIONS, "s6", "D"),
        (POSITIONS, "s8", "v"), (RELATIVE_POSITIONS, "s7", "P"),
    )
}  # fmt: skip
DASHES: dict[str, tuple[float, ...]] = {SINGLE: (6, 2), DOUBLE: (), LONG: (2, 1.6)}
COORDINATE_DASHES: dict[str, tuple[float, ...]] = {ABSOLUTE: (), RELATIVE: (6, 2), MINIMAL: (2, 1.6)}
MOTION = {
    POSITIONS: "from absolute positions",
    ACCELERATIONS: "from absolute accelerations",
    ABSOLUTE: "solved, absolute",
    RELATIVE_POSITIONS: "from relative positions",
    RELATIVE: "solved, relative",
}
INERTIAL = "inertial"
SIZE_LABEL = "bar's length / Earth's radius"
X_LABELS = {"steps_per_orbit": "steps per orbit", "rtol": "relative tolerance", "orbits": "orbits"}
SHADED = "Grey area: no digit left."
RANGE = "Coloured area: 5 to 95 % of the states"
RINGED = "Ring: smallest error; finer steps only add round-off."
HOLLOW = "Hollow: below the error of the reference solution."
COMPARED_AT = 1e-8  # size at which digits are set against the number of bars


def evaluation_charts(study: RoundoffData) -> tuple[list[Panel], list[Panel]]:
    """Errors of one evaluation against the size ratio and the number of bars: shown at once, and further ones."""
    known, read_off = "Reactions from known motion: 80° chain", "roundoff-read-off"
    first = (
        by_size(study, "roundoff-generic", "One evaluation in a generic state", forms(GENERIC)),
        by_size(study, "roundoff-horizontal-own", "Horizontal chain: error relative to its vanishing reaction",
                forms(HORIZONTAL)),
        by_size(study, "roundoff-horizontal-ordinary", "Horizontal chain: error relative to m n² l",
                forms(HORIZONTAL, ORDINARY)),
        by_size(study, f"{read_off}-{DOUBLE}", f"{known}, {DOUBLE}", known_motion(DOUBLE)),
        by_size(study, "roundoff-sources", "Sources of error: generic state, float64", sources()),
        against_bars(study),
    )  # fmt: skip
    further = [
        by_size(study, f"roundoff-{k}", f"One evaluation: {state}", forms(state))
        for k, state in enumerate((STRAIGHT, SPIN, UNEQUAL))
    ]
    further.append(by_size(study, f"{read_off}-{SINGLE}", f"{known}, {SINGLE}", known_motion(SINGLE)))
    return drawn(first), drawn(further)


def drawn(panels: Iterable[Panel | None]) -> list[Panel]:
    """Charts with something to show."""
    return [p for p in panels if p]


def forms(state: str, yardstick: str = REACTION) -> list[Series]:
    """Both formulations in three arithmetics."""
    return [
        (f"{f}, {a}", replace(PENS[f], dash=dash), {"formulation": f, "arithmetic": a, "state": state,
                                                    "yardstick": yardstick})
        for f, (a, dash) in product((ABSOLUTE, RELATIVE), DASHES.items())
    ]  # fmt: skip


def known_motion(arithmetic: str) -> list[Series]:
    """Reactions computed from known motion, beside those solved for."""
    return [
        (label, PENS[f], {"formulation": f, "arithmetic": arithmetic, "state": STRAIGHT}) for f, label in MOTION.items()
    ]


def sources() -> list[Series]:
    """The formula's error beside the error from rounding its input."""
    shown: tuple[tuple[str, str, tuple[float, ...]], ...] = (
        (FORMULA, "formula", ()),
        (INPUT, "rounded input", (2, 1.6)),
    )
    return [
        (f"{f}, {word}", replace(PENS[f], dash=dash), {"formulation": f, "source": source})
        for f, (source, word, dash) in product((ABSOLUTE, RELATIVE), shown)
    ]


def by_size(study: RoundoffData, name: str, title: str, series: list[Series]) -> Panel | None:
    """Chart of errors against the size ratio, with laws and named objects."""
    curves = [
        error_curve(label, own, "ratio", pen, fit=law_line(study, key, own.ratio.min(), own.ratio.max()))
        for label, pen, key in series if len(own := study.errors(**key))
    ]  # fmt: skip
    ordinary = bool(series) and series[0][2].get("yardstick") == ORDINARY
    axes = Axes(name, title, SIZE_LABEL, "error / (m n² l)" if ordinary else QUANTITIES[REACTION][1], study.named)
    fitted = "; thin lines: fitted laws" * any(c.fit is not None for c in curves)
    return error_chart(axes, curves, f"{RANGE}{fitted}. {SHADED}")


def error_curve(
    label: str, own: pd.DataFrame, x: str, pen: Pen, hollow: str = "", *, ringed: Sequence[float] = (),
    fit: tuple[Array, Array] | None = None,
) -> ErrorCurve:  # fmt: skip
    """Curve of rows of a table against one of its columns, outlined where the column `hollow` says no."""
    own = own.sort_values(x)
    at, y, low, high = (own[c].to_numpy(float) for c in (x, "median", "q05", "q95"))
    return ErrorCurve(
        label, pen, at, y, low, high, fit, np.isin(at, ringed), ~own[hollow].to_numpy(bool) if hollow else None
    )


def law_line(study: RoundoffData, key: dict[str, Any], least: float, largest: float) -> tuple[Array, Array] | None:
    """Fitted line between two sizes, up to an error of 1; None without a fit."""
    law, u = rows_of(study.tables.laws, **USUAL | key), study.unit_roundoff(key.get("arithmetic", DOUBLE))
    if not len(law) or u is None:
        return None
    exponent, constant = (number_or_none(law.iloc[0][k]) for k in ("exponent", "constant"))
    if exponent is None or constant is None:
        return None
    across = np.geomspace(least, largest, 60)
    y = constant * u * across ** float(law.iloc[0].expected)
    return across[y <= 1.0], y[y <= 1.0]


def against_bars(study: RoundoffData) -> Panel | None:
    """Chart of digits against the number of bars, at one size."""
    curves = []
    dashes: tuple[tuple[str, tuple[float, ...]], ...] = ((GENERIC, ()), (STRAIGHT, (6, 2)))
    for (state, dash), f in product(dashes, (ABSOLUTE, RELATIVE)):
        counts = sorted({int(n) for n in rows_of(study.tables.evaluation, state=state, source=BOTH).bars})
        found = [(n, *d) for n in counts if (d := study.digits(COMPARED_AT, formulation=f, state=state, bars=n))]
        if len(found) > 1:
            x, low, y, high = np.array(found, float).T
            curves.append(ErrorCurve(f"{f}, {state}", replace(PENS[f], dash=dash), x, y, low, high))
    axes = Axes(
        "roundoff-bars", "Digits left of chains of many bars, float64", "number of bars N", "digits",
        ticks=tuple(sorted({float(n) for c in curves for n in c.x})), in_digits=True,
    )  # fmt: skip
    note = f"At a size ratio of {decade(COMPARED_AT)}, interpolated between measured sizes. {SHADED}"
    return error_chart(axes, curves, note)


def run_charts(study: RoundoffData, arithmetic: str, quantities: tuple[str, ...]) -> list[Panel]:
    """Errors of an orbit against step or tolerance, one chart for each quantity and method."""
    table = study.tables.trajectories
    methods = [m for m in METHODS if m in set(table.method)]
    return drawn(
        against_step(study, rows_of(table, arithmetic=arithmetic, quantity=q, method=m), arithmetic, q, m)
        for q, m in product(quantities, methods)
    )


def against_step(study: RoundoffData, own: pd.DataFrame, arithmetic: str, quantity: str, method: str) -> Panel | None:
    """Chart of one quantity and method: every set of coordinates at every size."""
    column = "rtol" if own.steps_per_orbit.isna().all() else "steps_per_orbit"
    curves = []
    for (c, r), k, part in by_pair(own, "coordinates"):
        best = rows_of(study.tables.best, ratio=r, quantity=quantity, coordinates=c, arithmetic=arithmetic,
                       method=method)  # fmt: skip
        settled = best[best.settled & (best["median"] < LOST)]  # leaves a digit, not at the finest setting
        curves.append(error_curve("", part, column, run_pen(c, k), "known", ringed=settled[column].to_list()))
    word, y_label = QUANTITIES[quantity]
    axes = Axes(
        f"roundoff-run-{quantity}-{arithmetic}-{list(METHODS).index(method)}",
        f"{word}, {METHODS[method]}{'' if arithmetic == DOUBLE else f', {arithmetic}'}", X_LABELS[column], y_label,
        ticks=() if column == "rtol" else tuple(float(4**k) for k in range(1, 12)), reverse=column == "rtol",
    )  # fmt: skip
    ringed = any(c.ringed is not None and c.ringed.any() for c in curves)
    note = " ".join([RINGED] * ringed + [HOLLOW] * any_hollow(curves))
    return error_chart(axes, curves, note, run_legend(study, own))


def by_pair(table: pd.DataFrame, name: str) -> list[tuple[tuple[str, float], int, pd.DataFrame]]:
    """Parts of a table by the words of a column and by size, each with the number of its size from the longest on."""
    pairs = sorted(
        set(zip(table[name].astype(str), table.ratio.astype(float), strict=True)), key=lambda p: (p[0], -p[1])
    )
    sizes = sizes_of(table)
    return [((w, r), sizes.index(r), rows_of(table, **{name: w, "ratio": r})) for w, r in pairs]


def sizes_of(table: pd.DataFrame) -> list[float]:
    """Size ratios, from the longest."""
    return sorted({float(r) for r in table.ratio}, reverse=True)


def run_pen(coordinates: str, k: int) -> Pen:
    """Colour and dashes of a set of coordinates, marker of a size."""
    return Pen(PENS[coordinates].colour, MARKERS[k % len(MARKERS)], COORDINATE_DASHES[coordinates])


def run_legend(study: RoundoffData, own: pd.DataFrame) -> tuple[Legend, ...]:
    """Colours of coordinates, then markers of sizes."""
    coloured = [
        Legend(c, Pen(PENS[c].colour, "", dash)) for c, dash in COORDINATE_DASHES.items() if c in set(own.coordinates)
    ]
    return (*coloured, *size_legend(study, own))


def size_legend(study: RoundoffData, own: pd.DataFrame) -> list[Legend]:
    """Markers of sizes."""
    return [
        Legend(study.size(r), Pen(COLOURS["muted"], MARKERS[k % len(MARKERS)], hollow=True))
        for k, r in enumerate(sizes_of(own))
    ]


def any_hollow(curves: list[ErrorCurve]) -> bool:
    """Whether any point is drawn outlined."""
    return any(c.hollow is not None and c.hollow.any() for c in curves)


def best_chart(study: RoundoffData, quantity: str) -> Panel | None:
    """Chart of the smallest error of an orbit over all methods, steps and tolerances, against size."""
    own = rows_of(study.tables.best, quantity=quantity)
    least = own.loc[own.groupby(["coordinates", "arithmetic", "ratio"])["median"].idxmin()] if len(own) else own
    curves = [
        error_curve(f"{c}, {a}", part, "ratio", replace(PENS[c], dash=DASHES[a]), "settled")
        for c, a in product(COORDINATE_DASHES, (SINGLE, DOUBLE))
        if len(part := rows_of(least, coordinates=c, arithmetic=a))
    ]
    word, y_label = QUANTITIES[quantity]
    axes = Axes(f"roundoff-best-{quantity}", f"{word}: smallest error of an orbit", SIZE_LABEL, y_label, study.named)
    hollow = "Hollow: at the finest setting, may decrease further. " * any_hollow(curves)
    return error_chart(axes, curves, f"Over all methods, steps and tolerances. {hollow}{SHADED}")


def growth_chart(study: RoundoffData, quantity: str) -> Panel | None:
    """Chart of one quantity's error against time."""
    own = rows_of(study.tables.growth, quantity=quantity)
    curves = [
        error_curve("", part, "orbits", run_pen(c, k), "known") for (c, _), k, part in by_pair(own, "coordinates")
    ]
    word, y_label = QUANTITIES[quantity]
    ticks = tuple(2.0**k for k in range(-3, 8))
    axes = Axes(
        f"roundoff-growth-{quantity}", f"{word}: error growth in time", X_LABELS["orbits"], y_label, ticks=ticks
    )
    return error_chart(axes, curves, HOLLOW * any_hollow(curves), run_legend(study, own))


def library_charts(study: RoundoffData) -> list[Panel]:
    """Errors of other libraries' evaluations against size, in each frame: formulations named ``library (frame)``."""
    words = dict.fromkeys(map(str, study.tables.evaluation.formulation))
    pairs = {name: (m[1], m[2]) for name in words if (m := re.fullmatch(r"(\S+) \((.+)\)", name))}
    names, frames = (list(dict.fromkeys(part)) for part in zip(*pairs.values(), strict=True)) if pairs else ([], [])
    pens = {name: frame_pen(f, frames, MARKERS[names.index(n) % len(MARKERS)]) for name, (n, f) in pairs.items()}
    return drawn(
        by_size(study, f"roundoff-libraries-{k}", f"One evaluation by other libraries: {state}",
                [(name, pen, {"formulation": name, "state": state}) for name, pen in pens.items()])
        for k, state in enumerate((GENERIC, STRAIGHT))
    )  # fmt: skip


def frame_pen(frame: str, frames: list[str], marker: str = "") -> Pen:
    """Pen of a frame: the inertial frame has the colour of absolute coordinates."""
    if frame == INERTIAL:
        return Pen(COLOURS["s3"], marker)
    k = [f for f in frames if f != INERTIAL].index(frame)
    return Pen(COLOURS[("s2", "s4", "s7", "s5")[k % 4]], marker, OTHER_DASHES[1 + k % 3])


def engine_charts(study: RoundoffData, quantity: str) -> list[Panel]:
    """One chart of errors against step for each engine, and one of the smallest error of all engines against size."""
    own = rows_of(study.tables.engines, quantity=quantity)
    own = own[own["median"].astype(float) > 0.0]
    word, y_label = QUANTITIES.get(quantity, (quantity.capitalize(), "error"))
    found = [
        engine_chart(study, part, str(engine), quantity, (f"{word}: {engine}", y_label))
        for engine, part in own.groupby("engine", sort=False)
    ]
    least = own[np.isfinite(own["median"].astype(float))]
    if len(least):
        least = least.loc[least.groupby(["engine", "frame", "ratio"], sort=False)["median"].idxmin()]
    names = list(dict.fromkeys(map(str, least.engine)))
    curves = [
        error_curve(f"{e}, {f}", part, "ratio",
                    replace(engine_pen(names.index(str(e)) + 2), dash=() if f == INERTIAL else OTHER_DASHES[2]))
        for (e, f), part in least.groupby(["engine", "frame"], sort=False) if len(part) > 1
    ]  # fmt: skip
    axes = Axes(
        f"roundoff-engines-{quantity}", f"{word}: smallest error of each engine", SIZE_LABEL, y_label, study.named
    )
    return drawn([*found, error_chart(axes, curves, f"Over all steps and tolerances. {SHADED}")])


def engine_chart(
    study: RoundoffData, own: pd.DataFrame, engine: str, quantity: str, words: tuple[str, str]
) -> Panel | None:
    """Chart of one engine's errors against its step, or its tolerance with step control; `words`: title, unit."""
    column = "rtol" if own.steps_per_orbit.isna().all() else "steps_per_orbit"
    own = own[own[column].notna()]
    frames = sorted(set(map(str, own.frame)), key=lambda f: (f != INERTIAL, f))
    curves = [
        error_curve("", part, column, frame_pen(f, frames, MARKERS[k % len(MARKERS)]), "known")
        for (f, _), k, part in by_pair(own, "frame")
    ]
    title, y_label = words
    axes = Axes(f"roundoff-engine-{engine}-{quantity}", title, X_LABELS[column], y_label, reverse=column == "rtol")
    legend = (*(Legend(f"{f} frame", frame_pen(f, frames)) for f in frames), *size_legend(study, own))
    return error_chart(axes, curves, HOLLOW * any_hollow(curves), legend)
