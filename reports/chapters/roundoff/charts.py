"""Charts of the round-off chapter: of one evaluation, of an orbit, of other engines."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.chapters.roundoff.study import METHODS, QUANTITIES, USUAL, rows_of
from reports.plotting.errors import LOST, Axes, ErrorCurve, error_chart
from reports.plotting.palette import COLOURS, DASHES, MARKERS, Pen, engine_pen
from reports.plotting.panels import Legend
from reports.text.numerals import decade

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    import pandas as pd

    from reports.chapters.roundoff.study import Roundoff
    from reports.plotting.panels import Panel
    from reports.plotting.series import Array

    Series = tuple[str, Pen, dict[str, Any]]  # label, pen, key of a series of an evaluation

PENS = {
    "relative": Pen(COLOURS["s2"], "o"),
    "absolute": Pen(COLOURS["s3"], "s"),
    "minimal": Pen(COLOURS["s4"], "^"),
    "absolute accelerations": Pen(COLOURS["s6"], "D"),
    "absolute positions": Pen(COLOURS["s8"], "v"),
    "relative positions": Pen(COLOURS["s7"], "P"),
}
ARITHMETICS: dict[str, tuple[float, ...]] = {"float32": (6, 2), "float64": (), "long double": (2, 1.6)}
COORDINATES: dict[str, tuple[float, ...]] = {"absolute": (), "relative": (6, 2), "minimal": (2, 1.6)}
"""Dashes of arithmetics and of sets of coordinates"""
MOTION = {
    "absolute positions": "from absolute positions",
    "absolute accelerations": "from absolute accelerations",
    "absolute": "solved, absolute",
    "relative positions": "from relative positions",
    "relative": "solved, relative",
}
"""Formulations of reactions from known motion, beside those solved for"""
INERTIAL = "inertial"
SIZE_LABEL = "bar's length / Earth's radius"
X_LABELS = {"steps_per_orbit": "steps per orbit", "rtol": "relative tolerance", "orbits": "orbits"}
SHADED = "Grey area: no digit left."
RINGED = "Ring: smallest error; finer steps only add round-off."
HOLLOW = "Hollow: below the error of the reference solution."
COMPARED_AT = 1e-8  # size at which digits are set against the number of bars


def evaluation_charts(study: Roundoff) -> tuple[list[Panel], list[Panel]]:
    """Errors of one evaluation against the size ratio and the number of bars: shown at once, and further ones."""

    def forms(state: str, yardstick: str = "reaction") -> list[Series]:
        return [
            (f"{f}, {a}", replace(PENS[f], dash=dash), {"formulation": f, "arithmetic": a} | {"state": state}
             | {"yardstick": yardstick})
            for f, (a, dash) in product(("absolute", "relative"), ARITHMETICS.items())
        ]  # fmt: skip

    def known_motion(arithmetic: str) -> Panel | None:
        key = {"arithmetic": arithmetic, "state": "80°"}
        series: list[Series] = [(words, PENS[f], key | {"formulation": f}) for f, words in MOTION.items()]
        title = f"Reactions from known motion: 80° chain, {arithmetic}"
        return by_size(study, f"roundoff-read-off-{arithmetic}", title, series)

    sources: list[Series] = [
        (f"{f}, {word}", replace(PENS[f], dash=dash), {"formulation": f, "source": source})
        for f, (source, word, dash) in product(
            ("absolute", "relative"), (("formula", "formula", ()), ("input", "rounded input", (2, 1.6)))
        )
    ]
    vanishing, ordinary = forms("horizontal"), forms("horizontal", "m n² l")
    first = [
        by_size(study, "roundoff-generic", "One evaluation in a generic state", forms("generic")),
        by_size(
            study, "roundoff-horizontal-own", "Horizontal chain: error relative to its vanishing reaction", vanishing
        ),
        by_size(study, "roundoff-horizontal-ordinary", "Horizontal chain: error relative to m n² l", ordinary),
        known_motion("float64"),
        by_size(study, "roundoff-sources", "Sources of error: generic state, float64", sources),
        against_bars(study),
    ]
    further = [
        by_size(study, f"roundoff-{k}", f"One evaluation: {state}", forms(state))
        for k, state in enumerate(("80°", "fast spin", "unequal masses"))
    ]
    return drawn(first), drawn([*further, known_motion("float32")])


def drawn(panels: Iterable[Panel | None]) -> list[Panel]:
    """Charts with something to show."""
    return [p for p in panels if p]


def by_size(study: Roundoff, name: str, title: str, series: Sequence[Series]) -> Panel | None:
    """Chart of errors against the size ratio, with laws and named objects."""
    curves = [
        error_curve(label, own, "ratio", pen, fit=law_line(study, key, own.ratio.min(), own.ratio.max()))
        for label, pen, key in series
        if len(own := study.errors(**key))
    ]
    ordinary = bool(series) and series[0][2].get("yardstick") == "m n² l"
    unit = "error / (m n² l)" if ordinary else QUANTITIES["reaction"][1]
    fitted = "; thin lines: fitted laws" * any(c.fit is not None for c in curves)
    note = f"Coloured area: 5 to 95 % of the states{fitted}. {SHADED}"
    return error_chart(Axes(name, title, SIZE_LABEL, unit, study.named), curves, note)


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


def law_line(study: Roundoff, key: dict[str, Any], least: float, largest: float) -> tuple[Array, Array] | None:
    """Fitted line between two sizes, up to an error of 1; None without a fit."""
    laws, u = rows_of(study.tables.laws, **USUAL | key), study.units.get(key.get("arithmetic", "float64"))
    if not len(laws) or u is None or not np.isfinite(laws.iloc[0][["exponent", "constant"]].astype(float)).all():
        return None
    across = np.geomspace(least, largest, 60)
    y = float(laws.iloc[0].constant) * u * across ** float(laws.iloc[0].expected)
    return across[y <= 1.0], y[y <= 1.0]


def against_bars(study: Roundoff) -> Panel | None:
    """Chart of digits against the number of bars, at one size."""
    curves = []
    dashes: tuple[tuple[str, tuple[float, ...]], ...] = (("generic", ()), ("80°", (6, 2)))
    for (state, dash), f in product(dashes, ("absolute", "relative")):
        counts = sorted({int(n) for n in rows_of(study.tables.evaluation, state=state, source="both").bars})
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


def by_step(
    study: Roundoff,
    axes: Axes,
    own: pd.DataFrame,
    kinds: tuple[str, Callable[[str], Pen]],
    column: str,
    ringed: Callable[[str, float], Sequence[float]] = lambda *_: (),
    words: str = "{}",
) -> Panel | None:
    """Chart of errors against step, tolerance or time: a colour for each kind of run, a marker for each size.

    Parameters
    ----------
    study : Roundoff
    axes : Axes
    own : DataFrame
        Rows of one quantity.
    kinds : tuple of str and callable
        Column that tells the kinds apart, and the pen of each.
    column : str
        Column of the horizontal axis.
    ringed : callable
        Abscissas of a kind and a size that round-off bounds.
    words : str
        Of a kind in the legend.
    """
    name, pen_of = kinds
    sizes = sorted({float(r) for r in own.ratio}, reverse=True)
    curves = [
        error_curve("", part, column, replace(pen_of(kind), marker=MARKERS[k % len(MARKERS)]), "known",
                    ringed=ringed(kind, ratio))
        for kind in sorted(set(map(str, own[name]))) for k, ratio in enumerate(sizes)
        if len(part := rows_of(own, **{name: kind, "ratio": ratio}))
    ]  # fmt: skip
    order = {kind: k for k, kind in enumerate((INERTIAL, *COORDINATES))}
    legend = [
        Legend(words.format(kind), pen_of(kind))
        for kind in sorted(set(map(str, own[name])), key=lambda kind: (order.get(kind, len(order)), kind))
    ]
    legend += [
        Legend(study.size(r), Pen(COLOURS["muted"], MARKERS[k % len(MARKERS)], hollow=True))
        for k, r in enumerate(sizes)
    ]
    rings = any(c.ringed is not None and c.ringed.any() for c in curves)
    return error_chart(axes, curves, " ".join([RINGED] * rings + [HOLLOW] * any_hollow(curves)), tuple(legend))


def any_hollow(curves: list[ErrorCurve]) -> bool:
    """Whether any point is drawn outlined."""
    return any(c.hollow is not None and c.hollow.any() for c in curves)


def coordinates_pen(coordinates: str) -> Pen:
    """Colour and dashes of a set of coordinates."""
    return Pen(PENS[coordinates].colour, "", COORDINATES[coordinates])


def run_charts(study: Roundoff, arithmetic: str, quantities: tuple[str, ...]) -> list[Panel]:
    """Errors of an orbit against step or tolerance, one chart for each quantity and method."""
    found = []
    for quantity, (k, method) in product(quantities, enumerate(METHODS)):
        key = {"arithmetic": arithmetic, "quantity": quantity, "method": method}
        own, best = rows_of(study.tables.trajectories, **key), rows_of(study.tables.best, **key)
        best = best[best.settled & (best["median"] < LOST)]  # leaves a digit, not at the finest setting
        column = "rtol" if own.steps_per_orbit.isna().all() else "steps_per_orbit"
        word, unit = QUANTITIES[quantity]
        title = f"{word}, {METHODS[method]}{'' if arithmetic == 'float64' else f', {arithmetic}'}"
        ticks = () if column == "rtol" else tuple(float(4**n) for n in range(1, 12))
        axes = Axes(
            f"roundoff-run-{quantity}-{arithmetic}-{k}", title, X_LABELS[column], unit, ticks=ticks,
            reverse=column == "rtol",
        )  # fmt: skip

        def ringed(coordinates: str, ratio: float, best: pd.DataFrame = best, column: str = column) -> Sequence[float]:
            return rows_of(best, coordinates=coordinates, ratio=ratio)[column].to_list()

        found.append(by_step(study, axes, own, ("coordinates", coordinates_pen), column, ringed))
    return drawn(found)


def least_and_growth(study: Roundoff, quantities: tuple[str, ...]) -> list[Panel]:
    """Charts of the smallest errors of an orbit over all methods and steps, then of their growth in time."""
    best, growths = [], []
    for quantity in quantities:
        word, unit = QUANTITIES[quantity]
        own = rows_of(study.tables.best, quantity=quantity)
        least = own.loc[own.groupby(["coordinates", "arithmetic", "ratio"])["median"].idxmin()] if len(own) else own
        curves = [
            error_curve(f"{c}, {a}", part, "ratio", replace(PENS[c], dash=ARITHMETICS[a]), "settled")
            for c, a in product(COORDINATES, ("float32", "float64"))
            if len(part := rows_of(least, coordinates=c, arithmetic=a))
        ]
        hollow = "Hollow: at the finest setting, may decrease further. " * any_hollow(curves)
        title = f"{word}: smallest error of an orbit"
        axes = Axes(f"roundoff-best-{quantity}", title, SIZE_LABEL, unit, study.named)
        best.append(error_chart(axes, curves, f"Over all methods, steps and tolerances. {hollow}{SHADED}"))
        grown = rows_of(study.tables.growth, quantity=quantity)
        axes = Axes(
            f"roundoff-growth-{quantity}", f"{word}: error growth in time", X_LABELS["orbits"], unit,
            ticks=tuple(2.0**k for k in range(-3, 8)),
        )  # fmt: skip
        growths.append(by_step(study, axes, grown, ("coordinates", coordinates_pen), "orbits"))
    return drawn([*best, *growths])


def library_charts(study: Roundoff) -> list[Panel]:
    """Errors of other libraries' evaluations against size, in each frame: formulations named ``library (frame)``."""
    words = dict.fromkeys(map(str, study.tables.evaluation.formulation))
    pairs = {name: (m[1], m[2]) for name in words if (m := re.fullmatch(r"(\S+) \((.+)\)", name))}
    names, frames = (list(dict.fromkeys(part)) for part in zip(*pairs.values(), strict=True)) if pairs else ([], [])
    pens = {
        name: replace(frame_pen(f, frames), marker=MARKERS[names.index(n) % len(MARKERS)])
        for name, (n, f) in pairs.items()
    }
    return drawn(
        by_size(study, f"roundoff-libraries-{k}", f"One evaluation by other libraries: {state}",
                [(name, pen, {"formulation": name, "state": state}) for name, pen in pens.items()])
        for k, state in enumerate(("generic", "80°"))
    )  # fmt: skip


def frame_pen(frame: str, frames: list[str]) -> Pen:
    """Pen of a frame: the inertial frame has the colour of absolute coordinates."""
    if frame == INERTIAL:
        return Pen(COLOURS["s3"])
    k = [f for f in frames if f != INERTIAL].index(frame)
    return Pen(COLOURS[("s2", "s4", "s7", "s5")[k % 4]], "", DASHES[1 + k % 3])


def engine_charts(study: Roundoff, quantity: str) -> list[Panel]:
    """One chart of errors against step for each engine, and one of the smallest error of all engines against size."""
    own = rows_of(study.tables.engines, quantity=quantity)
    own = own[own["median"].astype(float) > 0.0]
    word, unit = QUANTITIES.get(quantity, (quantity.capitalize(), "error"))
    found = []
    for engine, part in own.groupby("engine", sort=False):
        column = "rtol" if part.steps_per_orbit.isna().all() else "steps_per_orbit"
        run = part[part[column].notna()]
        frames = sorted(set(map(str, run.frame)))
        axes = Axes(
            f"roundoff-engine-{engine}-{quantity}", f"{word}: {engine}", X_LABELS[column], unit,
            reverse=column == "rtol",
        )  # fmt: skip
        kinds = ("frame", lambda frame, frames=frames: frame_pen(frame, frames))
        found.append(by_step(study, axes, run, kinds, column, words="{} frame"))
    least = own[np.isfinite(own["median"].astype(float))]
    if len(least):
        least = least.loc[least.groupby(["engine", "frame", "ratio"], sort=False)["median"].idxmin()]
    names = list(dict.fromkeys(map(str, least.engine)))
    curves = [
        error_curve(f"{e}, {f}", part, "ratio",
                    replace(engine_pen(names.index(str(e)) + 2), dash=() if f == INERTIAL else DASHES[2]))
        for (e, f), part in least.groupby(["engine", "frame"], sort=False) if len(part) > 1
    ]  # fmt: skip
    title = f"{word}: smallest error of each engine"
    axes = Axes(f"roundoff-engines-{quantity}", title, SIZE_LABEL, unit, study.named)
    return drawn([*found, error_chart(axes, curves, f"Over all steps and tolerances. {SHADED}")])
