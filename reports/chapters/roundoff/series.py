"""Queries of a round-off study's tables: series of errors, digits at a size, fitted laws."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.text.numerals import number
from reports.text.record import mapping, rows

if TYPE_CHECKING:
    import pandas as pd

    from reports.tables.roundoff import RoundoffTables

RELATIVE, ABSOLUTE, MINIMAL = "relative", "absolute", "minimal"
ACCELERATIONS, POSITIONS, RELATIVE_POSITIONS = "absolute accelerations", "absolute positions", "relative positions"
PRODUCTION = ("reference", "reference-fast")
SINGLE, DOUBLE, LONG = "float32", "float64", "long double"
GENERIC, STRAIGHT, HORIZONTAL, SPIN, UNEQUAL = "generic", "80°", "horizontal", "fast spin", "unequal masses"
FORMULA, INPUT, BOTH = "formula", "input", "both"
REACTION, ORDINARY = "reaction", "m n² l"
BARS = 5  # the paper's number, shown first
LOST = 0.1  # an error from here on leaves no digit
SLACK = 0.05  # of an exponent: resolution of fits over a few decades of scattered medians
SMALLEST, LARGEST = 1e-40, 1e40  # stand-ins of zero and infinity, whose logarithms are numbers


@dataclass(frozen=True)
class Key:
    """Key of a series of evaluation.csv and of its law."""

    formulation: str
    arithmetic: str = DOUBLE
    state: str = GENERIC
    bars: int = BARS
    source: str = BOTH
    yardstick: str = REACTION

    def of(self, table: pd.DataFrame) -> pd.DataFrame:
        """Own rows of a table, by size where it has sizes."""
        kept = np.ones(len(table), bool)
        for name in ("formulation", "arithmetic", "state", "bars", "source", "yardstick"):
            kept &= (table[name] == getattr(self, name)).to_numpy(bool)
        own = table[kept]
        return own.sort_values("ratio") if "ratio" in own else own


@dataclass(frozen=True)
class Spread:
    """An error's median, and its quantiles at 5 and 95 %."""

    low: float
    median: float
    high: float

    @property
    def digits(self) -> Digits:
        """Digits that the error leaves."""
        few, middle, many = (max(0.0, -math.log10(v)) for v in (self.high, self.median, self.low))
        return Digits(few, middle, many)


@dataclass(frozen=True)
class Digits:
    """Significant decimal digits: of the median error, and of the 95 % and 5 % quantiles."""

    low: float
    median: float
    high: float

    @property
    def lost(self) -> bool:
        """Whether no digit is left."""
        return self.median < -math.log10(LOST)

    @property
    def text(self) -> str:
        """``11.4``, or ``none``."""
        return "none" if self.lost else f"{self.median:.1f}"

    @property
    def spread(self) -> str:
        """``11.1 to 11.8``; empty if none are left."""
        return "" if self.lost else f"{self.low:.1f} to {self.high:.1f}"


@dataclass(frozen=True)
class FittedExponent:
    """Fitted exponent with its interval, and its expected value."""

    exponent: float | None
    low: float | None
    high: float | None
    expected: float
    """NaN without an expectation"""
    points: int
    remark: str

    @property
    def off(self) -> bool:
        """Whether the interval excludes the expected value by more than :data:`SLACK`."""
        if self.low is None or self.high is None:
            return False
        return self.low - SLACK > self.expected or self.high + SLACK < self.expected

    @property
    def text(self) -> str:
        """``−1.01 (−1.03 to −0.99)``; empty if there were too few points."""
        if self.exponent is None or self.low is None or self.high is None:
            return ""
        value, low, high = (signed(v) for v in (self.exponent, self.low, self.high))
        return f"{value} ({low} to {high})"


@dataclass(frozen=True)
class ErrorLaw(FittedExponent):
    """A power law of an error: ``constant`` u ratio^``expected``."""

    constant: float | None
    last_digit_ratio: float | None = None


def signed(value: float, digits: int = 2) -> str:
    """``−1.01``: a true minus, and none before zero."""
    return f"{value:z.{digits}f}".replace("-", "\N{MINUS SIGN}")


def fit_of(row: dict[Any, Any]) -> FittedExponent:
    """Exponent of a table's row."""
    exponent, low, high = (number_or_none(row.get(k)) for k in ("exponent", "low", "high"))
    expected, points = number_or_none(row.get("expected")), number_or_none(row.get("points"))
    wanted = math.nan if expected is None else expected
    return FittedExponent(exponent, low, high, wanted, int(points or 0), str(row.get("remark") or ""))


def law_of(row: dict[Any, Any]) -> ErrorLaw:
    """Law of a row of laws.csv or best_laws.csv."""
    fit = fit_of(row)
    constant, last = (number_or_none(row.get(k)) for k in ("constant", "last_digit_ratio"))
    return ErrorLaw(fit.exponent, fit.low, fit.high, fit.expected, fit.points, fit.remark, constant, last)


def number_or_none(value: object) -> float | None:
    """A cell's number; None where it is empty or infinite."""
    found = number(value)
    return found if found is not None and math.isfinite(found) else None


@dataclass(frozen=True)
class NamedObject:
    """Named object of a given size."""

    name: str
    ratio: float
    length_m: float


@dataclass(frozen=True)
class RoundoffData:
    """Tables of a round-off study, and queries of them."""

    tables: RoundoffTables

    @property
    def named(self) -> tuple[NamedObject, ...]:
        """Named objects, from the longest."""
        found = [(str(o.get("name") or ""), number(o.get("ratio")), number(o.get("length_m"))) for o in
                 rows(self.tables.record.get("objects"))]  # fmt: skip
        return tuple(sorted((NamedObject(n, r, m) for n, r, m in found if n and r and m), key=lambda o: -o.ratio))

    @property
    def metres(self) -> float | None:
        """Length of a bar of size ratio 1: the body's radius."""
        named = self.named
        return named[0].length_m / named[0].ratio if named else None

    def unit_roundoff(self, arithmetic: str) -> float | None:
        """Unit round-off of an arithmetic."""
        return number_or_none(mapping(self.tables.record.get("unit_roundoff")).get(arithmetic))

    def law(self, key: Key) -> ErrorLaw | None:
        """Law of a series; None if it has none or no constant."""
        own = key.of(self.tables.laws)
        found = law_of(own.iloc[0].to_dict()) if len(own) else None
        return found if found and found.constant is not None else None

    def error(self, key: Key, ratio: float) -> Spread | None:
        """Errors at a size, interpolated on log-log axes; None outside the measured sizes."""
        own = key.of(self.tables.evaluation)
        if not len(own) or not own.ratio.min() * (1 - 1e-9) <= ratio <= own.ratio.max() * (1 + 1e-9):
            return None
        across = np.log(own.ratio.to_numpy(float))
        ends = [np.log(own[q].to_numpy(float).clip(SMALLEST, LARGEST)) for q in ("q05", "median", "q95")]
        low, median, high = (float(np.exp(np.interp(np.log(ratio), across, end))) for end in ends)
        return Spread(low, median, high)

    def digits(self, key: Key, ratio: float) -> Digits | None:
        """Digits left at a size."""
        found = self.error(key, ratio)
        return found.digits if found else None

    def measured(self, ratio: float) -> bool:
        """Whether a size lies between measured sizes."""
        sizes = self.tables.evaluation.ratio
        return bool(len(sizes)) and float(sizes.min()) <= ratio <= float(sizes.max())


def other(key: Key, **changes: Any) -> Key:
    """Key with some of its names replaced."""
    return replace(key, **changes)
