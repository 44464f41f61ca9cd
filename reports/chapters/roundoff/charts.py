"""Charts of errors of one evaluation against the size ratio and the number of bars."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.roundoff.axes import ErrorCurve, Sheet, panel
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
    MINIMAL,
    ORDINARY,
    POSITIONS,
    REACTION,
    RELATIVE,
    RELATIVE_POSITIONS,
    SINGLE,
    STRAIGHT,
    Key,
    other,
)  # fmt: skip
from reports.plotting.palette import COLOURS, Pen
from reports.plotting.panels import Legend, Panel
from reports.text.ratios import decade

if TYPE_CHECKING:
    from collections.abc import Callable

    from reports.chapters.roundoff.series import RoundoffData
    from reports.plotting.series import Array

HUES = {
    RELATIVE: ("s2", "o"), ABSOLUTE: ("s3", "s"), MINIMAL: ("s4", "^"),
    ACCELERATIONS: ("s6", "D"), POSITIONS: ("s8", "v"), RELATIVE_POSITIONS: ("s7", "P"),
}  # fmt: skip
DASHES: dict[str, tuple[float, ...]] = {DOUBLE: (), SINGLE: (6, 2), LONG: (2, 1.6)}
SOURCE_DASHES: dict[str, tuple[float, ...]] = {FORMULA: (), INPUT: (2, 1.6)}
SIZE_LABEL = "bar's length / Earth's radius"
OF_REACTION, OF_ORDINARY = "error / largest reaction", "error / (m n² l)"
SHADED = "Grey area: no digit left."
FITTED = "Coloured area: 5 to 95 % of the states; thin lines: fitted laws."
COMPARED_AT = 1e-8  # size at which digits are set against the number of bars


def pen(formulation: str, dash: tuple[float, ...] = ()) -> Pen:
    """Colour and marker of a formulation."""
    hue, marker = HUES[formulation]
    return Pen(COLOURS[hue], marker, dash)


def evaluation_panels(study: RoundoffData) -> tuple[Panel, ...]:
    """Charts of one evaluation shown at once."""
    found = (generic(study), horizontal(study, REACTION), horizontal(study, ORDINARY), differenced(study, DOUBLE),
             sources(study), against_bars(study))  # fmt: skip
    return tuple(p for p in found if p)


def further_panels(study: RoundoffData) -> tuple[Panel, ...]:
    """Charts of one evaluation in further states and arithmetics."""
    found = (several(study, f"roundoff-{k}", f"One evaluation: {state}", state, REACTION)
             for k, state in enumerate((STRAIGHT, "fast spin", "unequal masses")))  # fmt: skip
    return tuple(p for p in (*found, differenced(study, SINGLE)) if p)


def generic(study: RoundoffData) -> Panel | None:
    """Chart of both formulations in three arithmetics, in a generic state."""
    return several(study, "roundoff-generic", "One evaluation in a generic state", GENERIC, REACTION)


def horizontal(study: RoundoffData, yardstick: str) -> Panel | None:
    """Chart of both formulations for the horizontal chain."""
    over, name = (
        ("relative to its vanishing reaction", "own") if yardstick == REACTION else ("relative to m n² l", "ordinary")
    )
    title = f"Horizontal chain: error {over}"
    return several(study, f"roundoff-horizontal-{name}", title, HORIZONTAL, yardstick)


def several(study: RoundoffData, name: str, title: str, state: str, yardstick: str) -> Panel | None:
    """Chart of both formulations in three arithmetics."""
    keys = [Key(f, a, state, yardstick=yardstick) for f in (ABSOLUTE, RELATIVE) for a in (SINGLE, DOUBLE, LONG)]
    return by_size(study, name, title, keys, lambda k: pen(k.formulation, DASHES[k.arithmetic]),
                   lambda k: f"{k.formulation}, {k.arithmetic}")  # fmt: skip


def differenced(study: RoundoffData, arithmetic: str) -> Panel | None:
    """Chart of reactions computed from known motion, beside those solved for."""
    names = (POSITIONS, ACCELERATIONS, ABSOLUTE, RELATIVE_POSITIONS, RELATIVE)
    words = {POSITIONS: "from absolute positions", ACCELERATIONS: "from absolute accelerations",
             ABSOLUTE: "solved, absolute", RELATIVE_POSITIONS: "from relative positions",
             RELATIVE: "solved, relative"}  # fmt: skip
    title = f"Reactions from known motion: 80° chain, {arithmetic}"
    keys = [Key(n, arithmetic, STRAIGHT) for n in names]
    return by_size(study, f"roundoff-read-off-{arithmetic}", title, keys, lambda k: pen(k.formulation),
                   lambda k: words[k.formulation])  # fmt: skip


def sources(study: RoundoffData) -> Panel | None:
    """Chart of the formula's error beside the error from rounding its input."""
    keys = [Key(f, source=s) for f in (ABSOLUTE, RELATIVE) for s in (FORMULA, INPUT)]
    words = {FORMULA: "formula", INPUT: "rounded input"}
    title = "Sources of error: generic state, float64"
    return by_size(study, "roundoff-sources", title, keys, lambda k: pen(k.formulation, SOURCE_DASHES[k.source]),
                   lambda k: f"{k.formulation}, {words[k.source]}")  # fmt: skip


def by_size(
    study: RoundoffData,
    name: str,
    title: str,
    keys: list[Key],
    drawn: Callable[[Key], Pen],
    words: Callable[[Key], str],
) -> Panel | None:
    """Chart of errors against the size ratio, with laws and named objects."""
    found = [(k, curve) for k in keys if (curve := size_curve(study, k, drawn(k)))]
    y_label = OF_ORDINARY if keys[0].yardstick == ORDINARY else OF_REACTION
    sheet = Sheet(name, title, SIZE_LABEL, y_label, study.named)
    fitted = any(c.fit is not None for _, c in found)
    note = f"{FITTED if fitted else FITTED.partition(';')[0] + '.'} {SHADED}"
    return panel(sheet, [c for _, c in found], tuple(Legend(words(k), drawn(k)) for k, _ in found), note)


def size_curve(study: RoundoffData, key: Key, drawn: Pen) -> ErrorCurve | None:
    """Curve of one series with its law; None without measurements."""
    own = key.of(study.tables.evaluation)
    if not len(own):
        return None
    x, y, low, high = (own[c].to_numpy(float) for c in ("ratio", "median", "q05", "q95"))
    return ErrorCurve(x, y, drawn, (low, high), law_line(study, key, x))


def law_line(study: RoundoffData, key: Key, x: Array) -> tuple[Array, Array] | None:
    """Fitted line over all sizes up to an error of 1; None without a fit."""
    law, u = study.law(key), study.unit_roundoff(key.arithmetic)
    if law is None or u is None or law.exponent is None or law.constant is None:
        return None
    across = np.geomspace(x.min(), x.max(), 60)
    y = law.constant * u * across**law.expected
    return across[y <= 1.0], y[y <= 1.0]


def against_bars(study: RoundoffData) -> Panel | None:
    """Chart of digits against the number of bars."""
    ratio = COMPARED_AT
    keys = [Key(f, DOUBLE, s) for s in (GENERIC, STRAIGHT) for f in (ABSOLUTE, RELATIVE)]
    dashes: dict[str, tuple[float, ...]] = {GENERIC: (), STRAIGHT: (6, 2)}
    found = [(k, curve) for k in keys if (curve := bars_curve(study, k, pen(k.formulation, dashes[k.state]), ratio))]
    ticks = tuple(sorted({float(n) for _, c in found for n in c.x}))
    sheet = Sheet(
        "roundoff-bars", "Digits left of chains of many bars, float64", "number of bars N", "digits", ticks=ticks,
        in_digits=True,
    )  # fmt: skip
    legend = tuple(Legend(f"{k.formulation}, {k.state}", c.pen) for k, c in found)
    note = f"At a size ratio of {decade(COMPARED_AT)}, interpolated between measured sizes. {SHADED}"
    return panel(sheet, [c for _, c in found], legend, note)


def bars_curve(study: RoundoffData, key: Key, drawn: Pen, ratio: float) -> ErrorCurve | None:
    """Digits of one formulation at a size; None if fewer than two numbers of bars have them."""
    table = study.tables.evaluation
    counts = sorted({int(n) for n in table.bars[(table.state == key.state) & (table.source == BOTH)]})
    found = [(n, d) for n in counts if (d := study.digits(other(key, bars=n), ratio))]
    if len(found) < 2:
        return None
    x, y = np.array([n for n, _ in found], float), np.array([d.median for _, d in found])
    return ErrorCurve(x, y, drawn, (np.array([d.low for _, d in found]), np.array([d.high for _, d in found])))
