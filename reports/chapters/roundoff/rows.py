"""Rows of the round-off chapter's tables, with numbers as text."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.chapters.roundoff.chart_parts import QUANTITIES
from reports.chapters.roundoff.run_charts import METHODS
from reports.chapters.roundoff.series import (
    ABSOLUTE,
    BARS,
    BOTH,
    DOUBLE,
    GENERIC,
    HORIZONTAL,
    LOST,
    ORDINARY,
    POSITIONS,
    REACTION,
    RELATIVE,
    RELATIVE_POSITIONS,
    SINGLE,
    SPIN,
    STRAIGHT,
    UNEQUAL,
    Digits,
    ErrorLaw,
    FittedExponent,
    Key,
    fit_of,
    law_of,
    number_or_none,
    signed,
)  # fmt: skip
from reports.chapters.roundoff.words import size, unit_text
from reports.text.numerals import as_given
from reports.text.ratios import span_text

if TYPE_CHECKING:
    from reports.chapters.roundoff.series import NamedObject, RoundoffData

STATES = (GENERIC, STRAIGHT, SPIN, UNEQUAL, HORIZONTAL)
DIGIT_COLUMNS: tuple[tuple[str, Key], ...] = (
    ("generic: relative, float32", Key(RELATIVE, SINGLE)),
    ("generic: relative, float64", Key(RELATIVE)),
    ("generic: absolute, float32", Key(ABSOLUTE, SINGLE)),
    ("generic: absolute, float64", Key(ABSOLUTE)),
    ("horizontal: relative, float64", Key(RELATIVE, state=HORIZONTAL)),
    ("horizontal: absolute, float64", Key(ABSOLUTE, state=HORIZONTAL)),
    ("80°: from relative positions, float64", Key(RELATIVE_POSITIONS, state=STRAIGHT)),
    ("80°: from absolute positions, float64", Key(POSITIONS, state=STRAIGHT)),
)
FIRST_FORMULATIONS = (RELATIVE, ABSOLUTE, RELATIVE_POSITIONS, POSITIONS)
FIRST_NAMES = ("state", "formulation", "arithmetic", "yardstick")
ALL_NAMES = ("state", "formulation", "bars", "arithmetic", "source", "yardstick")
LEAST_SIZES = 3  # of a power law with an interval
DRIFT = 2.0  # exponent of position errors under a steady drift of the rates
BEYOND = "†"  # after a size that lies beyond the measured ones


@dataclass(frozen=True)
class DigitRow:
    """Digits left of the reactions of one named object."""

    thing: NamedObject
    cells: tuple[Digits | None, ...]


@dataclass(frozen=True)
class LawRow:
    """One fitted law and its subject."""

    of: tuple[str, ...]
    fit: FittedExponent
    constant: str = ""
    last_digit: str = ""
    span: str = ""

    @property
    def expected(self) -> str:
        """``−1``."""
        return as_given(number_or_none(self.fit.expected)).replace("-", "\N{MINUS SIGN}")

    @property
    def remark(self) -> str:
        """Reason for a missing fit, or a note on an unexpected exponent."""
        return self.fit.remark or ("not as expected" if self.fit.off else "")


def digit_columns(study: RoundoffData) -> tuple[tuple[str, Key], ...]:
    """Columns of the table of digits that were measured at the size of a named object."""
    return tuple((words, key) for words, key in DIGIT_COLUMNS if any(study.digits(key, o.ratio) for o in study.named))


def digit_rows(study: RoundoffData) -> tuple[DigitRow, ...]:
    """One row for each named object whose size lies between measured ones."""
    keys = [key for _, key in digit_columns(study)]
    found = (DigitRow(o, tuple(study.digits(k, o.ratio) for k in keys)) for o in study.named)
    return tuple(row for row in found if any(row.cells))


def law_rows(study: RoundoffData) -> tuple[tuple[LawRow, ...], tuple[LawRow, ...]]:
    """Laws of one evaluation: those shown first, and further ones; none of fewer sizes than a law needs."""
    order = {state: k for k, state in enumerate(STATES)}
    known = [r for r in study.tables.laws.to_dict("records") if not few_sizes(study, r)]
    found = sorted(known, key=lambda r: order.get(r["state"], len(order)))
    shown = [law_row(study, r, FIRST_NAMES) for r in found if first(r)]
    return tuple(shown), tuple(law_row(study, r, ALL_NAMES) for r in found if not first(r))


def few_sizes(study: RoundoffData, row: dict[Any, Any]) -> bool:
    """Whether a series was measured, but at fewer than :data:`LEAST_SIZES` sizes."""
    table = study.tables.evaluation
    if not len(table):
        return False
    own = np.logical_and.reduce([table[name] == row[name] for name in ALL_NAMES])
    return int(table.ratio[own].nunique()) < LEAST_SIZES


def first(row: dict[Any, Any]) -> bool:
    """Whether a law is shown first: errors of formula and input together, in common arithmetics."""
    vanishing = row["state"] == HORIZONTAL and row["yardstick"] == ORDINARY
    return (
        row["source"] == BOTH and row["bars"] == BARS and row["arithmetic"] in (SINGLE, DOUBLE)
        and row["formulation"] in FIRST_FORMULATIONS and (row["yardstick"] == REACTION or vanishing)
    )  # fmt: skip


def law_row(study: RoundoffData, row: dict[Any, Any], names: tuple[str, ...]) -> LawRow:
    """One law of laws.csv."""
    law = law_of(row)
    last = last_digit(study, law.last_digit_ratio)
    return LawRow(tuple(str(row[k]) for k in names), law, constant_of(law), last, span_of(study, row))


def constant_of(law: ErrorLaw) -> str:
    """Error in units of u."""
    return unit_text(law) if law.constant is not None else ""


def span_of(study: RoundoffData, row: dict[Any, Any]) -> str:
    """``0.64 m … 64 km``."""
    ends = [number_or_none(row.get(k)) for k in ("first", "last")]
    return " … ".join(size(study, e) for e in ends if e is not None)


def best_law_rows(study: RoundoffData) -> tuple[LawRow, ...]:
    """Laws of the smallest errors of runs, fitted ones first."""
    found = (best_law_row(study, r) for r in study.tables.best_laws.to_dict("records"))
    return tuple(sorted(found, key=lambda r: r.fit.exponent is None))


def best_law_row(study: RoundoffData, row: dict[Any, Any]) -> LawRow:
    """Law of one row of best_laws.csv."""
    law = law_of(row)
    last = last_digit_ratio(law, study.unit_roundoff(str(row["arithmetic"])))
    named = (word_of(row["quantity"]), row["coordinates"], row["arithmetic"], METHODS.get(row["method"], row["method"]))
    return LawRow(named, law, constant_of(law), last_digit(study, last), span_of(study, row))


def last_digit_ratio(law: ErrorLaw, unit_roundoff: float | None) -> float | None:
    """Size ratio at which an error that falls with the size leaves no digit."""
    if not law.constant or not unit_roundoff or not law.expected < 0.0:
        return None
    return float((LOST / (law.constant * unit_roundoff)) ** (1.0 / law.expected))


def last_digit(study: RoundoffData, ratio: float | None) -> str:
    """Length of a bar at which the last digit is lost, marked if extrapolated."""
    return size(study, ratio) + BEYOND * (ratio is not None and not study.measured(ratio))


def word_of(quantity: str) -> str:
    """Word of a quantity."""
    return QUANTITIES.get(quantity, (quantity, ""))[0].lower()


def growth_rows(study: RoundoffData) -> tuple[LawRow, ...]:
    """Exponents in time."""
    found = []
    for r in study.tables.growth_laws.to_dict("records"):
        fit = fit_of(r)
        named = (word_of(r["quantity"]), r["coordinates"], r["arithmetic"], size(study, float(r["ratio"])))
        found.append(LawRow(named, replace(fit, remark=fit.remark or growth_words(fit))))
    return tuple(found)


def growth_words(fit: FittedExponent) -> str:
    """Classification of an unexpected exponent of growth."""
    if not fit.off or fit.exponent is None:
        return ""
    if fit.exponent < fit.expected:
        return "slower than a random walk of the rates"
    if fit.expected == 0.0:
        return "rises, as the running maximum of a steady noise does"
    return "faster than a random walk of the rates" + ", slower than their drift" * (fit.exponent < DRIFT)


def engine_rows(study: RoundoffData) -> tuple[LawRow, ...]:
    """Exponents of other engines' errors."""
    found = []
    for r in study.tables.engine_laws.to_dict("records"):
        against = str(r["against"]).replace("_", " ")
        named = (r["engine"], r["frame"], size(study, number_or_none(r["ratio"])), word_of(r["quantity"]), against)
        found.append(LawRow(named, fit_of(r)))
    return tuple(found)


def stops(study: RoundoffData) -> tuple[tuple[str, str, str, str], ...]:
    """Engine, frame, outcome and reason of skipped and failed runs, each once."""
    table = study.tables.engines
    bad = table[table.reason.astype(str) != ""] if len(table) else table
    found = ((str(r["engine"]), str(r["frame"]), str(r["outcome"]).replace("_", " "), str(r["reason"]))
             for r in bad.to_dict("records"))  # fmt: skip
    return tuple(dict.fromkeys(found))


def time_rows(study: RoundoffData) -> tuple[tuple[str, ...], ...]:
    """Times of an evaluation in relative and absolute coordinates."""
    return tuple(
        (
            str(r["code"]), str(r["arithmetic"]), as_given(r["bars"]), span_text(number_or_none(r["relative_s"])),
            span_text(number_or_none(r["absolute_s"])), times(r),
        )
        for r in study.tables.times.to_dict("records")
    )  # fmt: skip


def times(row: dict[Any, Any]) -> str:
    """``1.30 (1.29 to 1.31)``; empty without a measurement."""
    ratio, low, high = (number_or_none(row.get(k)) for k in ("ratio", "low", "high"))
    if ratio is None:
        return ""
    return signed(ratio) if low is None or high is None else f"{signed(ratio)} ({signed(low)} to {signed(high)})"
