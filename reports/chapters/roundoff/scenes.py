"""Round-off of scenes: digits over time in both sets of coordinates, and the floors of engines."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, NamedTuple

from reports.chapters.roundoff.charts import ARITHMETICS, PENS, SHADED, X_LABELS, drawn, error_curve
from reports.chapters.roundoff.study import LARGEST, SMALLEST, rows_of
from reports.plotting.errors import Axes, ErrorCurve, error_chart
from reports.plotting.palette import DASHES, engine_pen
from reports.results.rows import plain
from reports.text.numerals import powers_in
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    import pandas as pd

    from reports.plotting.panels import Panel

PRECISIONS = {"float32": "single", "float64": "double", "long double": "long double", "quadruple": "quadruple"}
QUANTITIES = {  # title, vertical axis
    "reaction": ("Reactions", "error / largest reaction"),
    "attitude": ("Angles", "error, rad"),
    "com": ("Track", "error / distance from the centre"),
}
COORDINATES = ("relative", "absolute")
TICKS = tuple(digit * 10.0**k for k in range(-4, 5) for digit in (1, 2, 5))


class DigitsLeft(NamedTuple):
    """Digits of the median error: the fewest of the run, and those at its end."""

    least: float
    end: float


def digits_of(scene: str, own: pd.DataFrame) -> SimpleNamespace:
    """Headline, table and charts of one scene, from rows of the table `digits`."""
    shown = [q for q in QUANTITIES if len(rows_of(own, quantity=q))]
    columns = [(q, c) for q in shown for c in COORDINATES]
    lines = {
        word: [digits_left(rows_of(own, quantity=q, coordinates=c, arithmetic=p)) for q, c in columns]
        for p, word in PRECISIONS.items() if len(rows_of(own, arithmetic=p))
    }  # fmt: skip
    orbits = round(float(own.orbits.max()), 9)
    relative, absolute, *_ = lines.get("double", [None, None])
    headline = "" if not relative or not absolute else (
        f"{QUANTITIES[shown[0]][0]} of {scene} keep {relative.least:.1f} digits in relative and {absolute.least:.1f} "
        f"in absolute coordinates in double precision, over {orbits:.3g} orbit{'' if orbits == 1.0 else 's'}"
    )  # fmt: skip
    return SimpleNamespace(
        scene=scene, headline=headline, heads=[f"{QUANTITIES[q][0]}, {c}" for q, c in columns], lines=lines.items(),
        charts=drawn(digits_chart(scene, q, rows_of(own, quantity=q)) for q in shown),
    )  # fmt: skip


def digits_left(own: pd.DataFrame) -> DigitsLeft | None:
    """Digits of one series over time; None without one."""
    if not len(own):
        return None
    median = own.sort_values("orbits")["median"].to_numpy(float).clip(SMALLEST, LARGEST)
    return DigitsLeft(*(max(0.0, -math.log10(value)) for value in (median.max(), median[-1])))


def digits_chart(scene: str, quantity: str, own: pd.DataFrame) -> Panel | None:
    """Chart of errors over time: each decade is a digit."""
    dashes = ARITHMETICS | {"quadruple": DASHES[3]}
    curves = [
        error_curve(f"{c}, {word}", part, "orbits", replace(PENS[c], marker="", dash=dashes[p]))
        for p, word in PRECISIONS.items() for c in COORDINATES
        if len(part := rows_of(own, coordinates=c, arithmetic=p))
    ]  # fmt: skip
    title, unit = QUANTITIES[quantity]
    axes = Axes(f"digits-{scene}-{quantity}", f"{title}: digits over time", X_LABELS["orbits"], unit, ticks=TICKS)
    return error_chart(axes, curves, f"Each decade is a digit. Coloured area: 5 to 95 % of the turned starts. {SHADED}")


def floors_of(scene: str, floors: pd.DataFrame, spread: pd.DataFrame) -> SimpleNamespace:
    """Sentences, table and charts of one scene, from rows of the tables `floors` and `spread`."""
    of_engines = [sentence(own) for _, own in floors.groupby(["engine", "setting"], sort=False)]
    lines = [
        line | {"title": (channel := CHANNELS[line["quantity"]]).shown_title, "unit": channel.unit}
        for line in plain(floors)
    ]  # fmt: skip
    charts = (floor_chart(scene, q, rows_of(floors, quantity=q), rows_of(spread, quantity=q)) for q in QUANTITIES)
    return SimpleNamespace(scene=scene, headlines=of_engines, lines=lines, charts=drawn(charts))


def sentence(own: pd.DataFrame) -> str:
    """What is told of one engine, from its rows of `floors`."""
    row = own.iloc[0]
    known = row["class"] in ("single", "double")
    kind = f"computes in {row['class']} precision" if known else "computes in a precision that is not told"
    bits = "other numbers" if own.repeats.any() else "the same numbers"
    return f"{row.engine} at {row.setting} {kind}: {powers_in(row.reason)}. The same run again gives {bits}."


def floor_chart(scene: str, quantity: str, floors: pd.DataFrame, spread: pd.DataFrame) -> Panel | None:
    """Chart of the spread of each engine over time, relative to the size of the channel; angles in rad."""
    curves: list[ErrorCurve] = []
    for k, line in enumerate(plain(floors)):
        own = rows_of(spread, engine=line["engine"], setting=line["setting"]).sort_values("orbits")
        x, grown, *y = (own[c].to_numpy(float) for c in ("orbits", "grown", "median", "q05", "q95"))
        middle, low, high, amplified = (v / line["scale"] for v in (*y, line["floor"] * grown))
        curves.append(ErrorCurve(line["engine"], engine_pen(k + 2), x, middle, low, high, (x, amplified)))
    channel = CHANNELS[quantity]
    unit = "spread, rad" if quantity == "attitude" else f"spread / size of the {channel.words}"
    title = f"{channel.shown_title}: spread of the variants"
    axes = Axes(f"floor-{scene}-{quantity}", title, X_LABELS["orbits"], unit, ticks=TICKS)
    note = f"Coloured area: 5 to 95 % of the variants; thin lines: floor times what the scene amplifies. {SHADED}"
    return error_chart(axes, curves, note)
