"""Round-off chapter: digits of named objects, charts of errors, fitted laws, dependence on the longitude, times."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.charts import (
    best_chart,
    drawn,
    engine_charts,
    evaluation_charts,
    growth_chart,
    library_charts,
    run_charts,
)
from reports.chapters.roundoff.series import (
    ABSOLUTE,
    BARS,
    BOTH,
    DOUBLE,
    FORMULA,
    GENERIC,
    HORIZONTAL,
    LOST,
    METHODS,
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
    RoundoffData,
    length,
    number_or_none,
    rows_of,
    spelled,
)
from reports.tables.roundoff import read_roundoff
from reports.tables.rows import records
from reports.text.numerals import as_given, span_text
from reports.text.record import is_complete, mapping, rows

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import pandas as pd

    from reports.plotting.panels import Panel

STATES = (GENERIC, STRAIGHT, SPIN, UNEQUAL, HORIZONTAL)
DIGIT_COLUMNS: dict[str, dict[str, str]] = {
    "generic: relative, float32": {"formulation": RELATIVE, "arithmetic": SINGLE},
    "generic: relative, float64": {"formulation": RELATIVE},
    "generic: absolute, float32": {"formulation": ABSOLUTE, "arithmetic": SINGLE},
    "generic: absolute, float64": {"formulation": ABSOLUTE},
    "horizontal: relative, float64": {"formulation": RELATIVE, "state": HORIZONTAL},
    "horizontal: absolute, float64": {"formulation": ABSOLUTE, "state": HORIZONTAL},
    "80°: from relative positions, float64": {"formulation": RELATIVE_POSITIONS, "state": STRAIGHT},
    "80°: from absolute positions, float64": {"formulation": POSITIONS, "state": STRAIGHT},
}
FIRST, FURTHER = ("attitude", "reaction"), ("gap", "com")
FIRST_FORMULATIONS = (RELATIVE, ABSOLUTE, RELATIVE_POSITIONS, POSITIONS)
FIRST_NAMES = ("state", "formulation", "arithmetic", "yardstick")
ALL_NAMES = ("state", "formulation", "bars", "arithmetic", "source", "yardstick")
SECTORS = ("state", "formulation", "arithmetic", "source", "ratio")
LEAST_SIZES = 3  # of a power law with an interval
SLACK = 0.05  # of an exponent: resolution of fits over a few decades of scattered medians
SIGNIFICANT = 0.05  # p below which sectors are said to differ
POWERS = {-3.0: "/ε³", -2.0: "/ε²", -1.0: "/ε", 0.0: ""}
BEYOND = "†"  # after a size that lies beyond the measured ones


def view_roundoff(folder: Path) -> SimpleNamespace:
    """Contents of the chapter, from the study in a result folder."""
    study = RoundoffData(read_roundoff(folder))
    tables, record = study.tables, study.tables.record
    measured = {words: key for words, key in DIGIT_COLUMNS.items()
                if any(study.digits(o.ratio, **key) for o in study.named)}  # fmt: skip
    digits = [(o.name, [study.digits(o.ratio, **key) for key in measured.values()]) for o in study.named]
    laws, further = evaluation_laws(study)
    longitudes = [sectors(study, key, own) for key, own in tables.longitudes.groupby(list(SECTORS), sort=False)]
    sizes, radius_m = tables.evaluation.ratio, study.body_radius_m
    parts = list(mapping(record.get("parts")).values()) or [record]
    return SimpleNamespace(
        record=record,
        finished=is_complete(record),
        sizes=[length(float(end) * radius_m) for end in (sizes.min(), sizes.max())] if len(sizes) and radius_m else [],
        digit_columns=list(measured),
        digits=[(name, cells) for name, cells in digits if any(cells)],
        charts=charts(study),
        laws=laws,
        further_laws=further,
        best_laws=[best_law(study, r) for r in fitted_first(tables.best_laws)],
        growths=[law(study, r, (word_of(r), r["coordinates"], r["arithmetic"], study.size(float(r["ratio"]))))
                 for r in records(tables.growth_laws)],
        engines=[law(study, r, (r["engine"], r["frame"], study.size(number_or_none(r["ratio"])), word_of(r),
                                str(r["against"]).replace("_", " "))) for r in records(tables.engine_laws)],
        stops=list(dict.fromkeys((r["engine"], r["frame"], str(r["outcome"]).replace("_", " "), r["reason"])
                                 for r in records(tables.engines) if r["reason"])),
        longitudes=longitudes,
        differing=[differing(longitudes, of_formula=of_formula) for of_formula in (True, False)],
        times=[times(r) for r in records(tables.times)],
        units=[(name, spelled(float(u), 3)) for name, u in mapping(record.get("unit_roundoff")).items()],
        failed=[task for part in parts for task in rows(mapping(part).get("failed"))],
        made=[made for k, made in enumerate(parts) if made.get("created") and made not in parts[:k]],
    )  # fmt: skip


def fitted_first(laws: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of a table of laws, those without a fit last."""
    return sorted(records(laws), key=lambda r: number_or_none(r["exponent"]) is None)


def charts(study: RoundoffData) -> dict[str, tuple[Sequence[Panel], Sequence[Panel]]]:
    """Charts of each section: open ones, and folded ones."""
    return {
        "evaluation": evaluation_charts(study),
        "orbit": (
            run_charts(study, DOUBLE, FIRST),
            [*run_charts(study, DOUBLE, FURTHER), *run_charts(study, SINGLE, (*FIRST, *FURTHER))],
        ),
        "least": (least_and_growth(study, FIRST), least_and_growth(study, FURTHER)),
        "engines": (
            [*library_charts(study), *engine_charts(study, "reaction")],
            [p for q in ("attitude", *FURTHER) for p in engine_charts(study, q)],
        ),
    }


def least_and_growth(study: RoundoffData, quantities: tuple[str, ...]) -> list[Panel]:
    """Charts of the smallest errors of an orbit, then of their growth in time."""
    return drawn([*(best_chart(study, q) for q in quantities), *(growth_chart(study, q) for q in quantities)])


def evaluation_laws(study: RoundoffData) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Laws of one evaluation: those shown first, and further ones; none of fewer sizes than a law needs."""
    found: tuple[list[dict[str, Any]], list[dict[str, Any]]] = [], []
    order = {state: k for k, state in enumerate(STATES)}
    for r in sorted(records(study.tables.laws), key=lambda r: order.get(r["state"], len(order))):
        errors = rows_of(study.tables.evaluation, **{name: r[name] for name in ALL_NAMES})
        if len(study.tables.evaluation) and errors.ratio.nunique() < LEAST_SIZES:
            continue
        first = shown_first(r)
        names = FIRST_NAMES if first else ALL_NAMES
        found[not first].append(law(study, r, tuple(str(r[k]) for k in names), number_or_none(r["last_digit_ratio"])))
    return found


def shown_first(row: dict[str, Any]) -> bool:
    """Whether a law is shown first: errors of formula and input together, in common arithmetics."""
    vanishing = row["state"] == HORIZONTAL and row["yardstick"] == ORDINARY
    return (
        row["source"] == BOTH and row["bars"] == BARS and row["arithmetic"] in (SINGLE, DOUBLE)
        and row["formulation"] in FIRST_FORMULATIONS and (row["yardstick"] == REACTION or vanishing)
    )  # fmt: skip


def best_law(study: RoundoffData, row: dict[str, Any]) -> dict[str, Any]:
    """Law of the smallest error of runs, with the size at which an error that falls with the size leaves no digit."""
    constant, expected, u = (
        number_or_none(row["constant"]),
        row["expected"],
        study.unit_roundoff(str(row["arithmetic"])),
    )
    last = (LOST / (constant * u)) ** (1.0 / expected) if constant and u and expected < 0.0 else None
    named = (word_of(row), row["coordinates"], row["arithmetic"], METHODS.get(row["method"], row["method"]))
    return law(study, row, named, last)


def law(
    study: RoundoffData, row: dict[str, Any], of: tuple[str, ...], last_digit_ratio: float | None = None
) -> dict[str, Any]:
    """Cells of a fitted law.

    Parameters
    ----------
    row : dict
        Row of a table of laws.
    of : tuple of str
        What the law is about.
    last_digit_ratio : float, optional
        Size ratio at which the error leaves no digit; it is marked if it was extrapolated.
    """
    exponent, low, high, expected = (number_or_none(row.get(k)) for k in ("exponent", "low", "high", "expected"))
    constant, sizes = number_or_none(row.get("constant")), study.tables.evaluation.ratio
    text, off = "", False
    if exponent is not None and low is not None and high is not None:
        text = f"{signed(exponent)} ({signed(low)} to {signed(high)})"
        off = expected is not None and not low - SLACK <= expected <= high + SLACK
    beyond = last_digit_ratio is not None and not sizes.min() <= last_digit_ratio <= sizes.max()
    return {
        "of": of,
        "exponent": exponent,
        "wanted": expected,
        "expected": as_given(expected).replace("-", "\N{MINUS SIGN}"),
        "text": text,
        "off": off,
        "constant": "" if constant is None else f"{spelled(constant)}\N{NO-BREAK SPACE}u{power(row['expected'])}",
        "last_digit": study.size(last_digit_ratio) + BEYOND * beyond,
        "span": " … ".join(study.size(e) for k in ("first", "last") if (e := number_or_none(row.get(k))) is not None),
        "points": int(number_or_none(row.get("points")) or 0),
        "remark": str(row.get("remark") or ""),
    }


def power(exponent: float) -> str:
    """``/ε`` of an exponent of the size ratio."""
    return POWERS.get(exponent, f" ε^{exponent:g}")


def signed(value: float | None) -> str:
    """``−1.01``: a true minus, and none before zero."""
    return "" if value is None else f"{value:z.2f}".replace("-", "\N{MINUS SIGN}")


def word_of(row: dict[str, Any]) -> str:
    """Word of a row's quantity."""
    return QUANTITIES.get(row["quantity"], (str(row["quantity"]), ""))[0].lower()


def sectors(study: RoundoffData, key: tuple[Any, ...], own: pd.DataFrame) -> dict[str, Any]:
    """Medians of the sectors of the longitude, beside the 5 to 95 % range of a typical sector."""
    *named, ratio = key
    low, high = float(own.q05.median()), float(own.q95.median())
    least, largest = float(own["median"].min()), float(own["median"].max())
    return {
        "of": (*map(str, named), study.size(float(ratio))),
        "medians": between(least, largest),
        "bound": between(low, high),
        "inside": low <= least and largest <= high,
        "p": number_or_none(own.p_value.iloc[0]),
        "p_text": spelled(number_or_none(own.p_value.iloc[0])),
    }


def between(low: float, high: float) -> str:
    """``3.4×10⁻¹⁴ to 4.3×10⁻¹⁴``, or one number if both agree."""
    first, last = spelled(low), spelled(high)
    return first if first == last else f"{first} to {last}"


def differing(longitudes: list[dict[str, Any]], *, of_formula: bool) -> tuple[int, int, float]:
    """Tests of sectors that differ, all tests, and those that differ by chance: of the formulas' errors or the input's.

    Only the input's may depend on the longitude.
    """
    own = [r["p"] for r in longitudes if (r["of"][SECTORS.index("source")] == FORMULA) is of_formula]
    return sum(p is not None and p < SIGNIFICANT for p in own), len(own), SIGNIFICANT * len(own)


def times(row: dict[str, Any]) -> tuple[str, ...]:
    """Code, arithmetic, number of bars; time of an evaluation in relative and absolute coordinates, and the ratio."""
    relative, absolute, ratio, low, high = (
        number_or_none(row.get(k)) for k in ("relative_s", "absolute_s", "ratio", "low", "high")
    )
    ends = "" if low is None or high is None else f" ({signed(low)} to {signed(high)})"
    told = "" if ratio is None else f"{signed(ratio)}{ends}"
    return row["code"], row["arithmetic"], as_given(row["bars"]), span_text(relative), span_text(absolute), told
