"""Round-off study as its chapter reads it: series of errors, digits at a size, lengths of bars, numbers as text."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from reports.text.numerals import number, prefixed, short, typed, typographic
from reports.text.record import mapping, rows

if TYPE_CHECKING:
    import pandas as pd

    from reports.tables.files import StudyTables

RELATIVE, ABSOLUTE, MINIMAL = "relative", "absolute", "minimal"
ACCELERATIONS, POSITIONS, RELATIVE_POSITIONS = "absolute accelerations", "absolute positions", "relative positions"
SINGLE, DOUBLE, LONG = "float32", "float64", "long double"
GENERIC, STRAIGHT, HORIZONTAL, SPIN, UNEQUAL = "generic", "80°", "horizontal", "fast spin", "unequal masses"
FORMULA, INPUT, BOTH = "formula", "input", "both"
REACTION, ORDINARY = "reaction", "m n² l"
BARS = 5  # the paper's number, shown first
USUAL = {"arithmetic": DOUBLE, "state": GENERIC, "bars": BARS, "source": BOTH, "yardstick": REACTION}
"""Series of an evaluation that is shown unless another is named"""
LOST = 0.1  # an error from here on leaves no digit
SMALLEST, LARGEST = 1e-40, 1e40  # stand-ins of zero and infinity, whose logarithms are numbers
LARGEST_PLAIN = 1e4
QUANTITIES = {  # title, vertical axis
    "attitude": ("Attitude", "error, rad"),
    "reaction": ("Reactions", "error / largest reaction"),
    "gap": ("Joint gaps", "gap / bar's length"),
    "com": ("Centre of mass", "error / bar's length"),
}
METHODS = {"rk4": "RK4", "dop853": "DOP853 at equal steps", "dop853, chosen steps": "DOP853 with step control"}


class NamedObject(NamedTuple):
    """Named object of a given size."""

    name: str
    ratio: float
    length_m: float


class Digits(NamedTuple):
    """Significant decimal digits: of the error's 95 % quantile, its median, and its 5 % quantile."""

    low: float
    median: float
    high: float


@dataclass(frozen=True)
class RoundoffData:
    """Tables of a round-off study, and queries of them."""

    tables: StudyTables

    @property
    def named(self) -> list[NamedObject]:
        """Named objects, from the longest."""
        found = [(str(o.get("name") or ""), number(o.get("ratio")), number(o.get("length_m"))) for o in
                 rows(self.tables.record.get("objects"))]  # fmt: skip
        return sorted((NamedObject(n, r, m) for n, r, m in found if n and r and m), key=lambda o: -o.ratio)

    @property
    def body_radius_m(self) -> float | None:
        """Length of a bar of size ratio 1; None without named objects."""
        named = self.named
        return named[0].length_m / named[0].ratio if named else None

    def unit_roundoff(self, arithmetic: str) -> float | None:
        """Unit round-off of an arithmetic."""
        return number_or_none(mapping(self.tables.record.get("unit_roundoff")).get(arithmetic))

    def errors(self, **key: Any) -> pd.DataFrame:
        """Errors of one evaluation of a series (:data:`USUAL` where the key says nothing), by size."""
        return rows_of(self.tables.evaluation, **USUAL | key).sort_values("ratio")

    def digits(self, ratio: float, **key: Any) -> Digits | None:
        """Digits left at a size, interpolated on log-log axes; None outside the measured sizes."""
        own = self.errors(**key)
        if not len(own) or not own.ratio.min() * (1 - 1e-9) <= ratio <= own.ratio.max() * (1 + 1e-9):
            return None
        across = np.log10(own.ratio.to_numpy(float))
        ends = [np.log10(own[q].to_numpy(float).clip(SMALLEST, LARGEST)) for q in ("q95", "median", "q05")]
        return Digits(*(max(0.0, -float(np.interp(math.log10(ratio), across, end))) for end in ends))

    def size(self, ratio: float | None) -> str:
        """Length of a bar of a size ratio: ``64 m``; the ratio itself without named objects."""
        if ratio is None:
            return ""
        metres = self.body_radius_m
        return f"ε = {spelled(ratio)}" if metres is None else length(ratio * metres)


def rows_of(table: pd.DataFrame, **key: Any) -> pd.DataFrame:
    """Rows of a table with these values in these columns."""
    kept = np.ones(len(table), bool)
    for name, value in key.items():
        kept &= (table[name] == value).to_numpy(bool)
    return table[kept]


def number_or_none(value: object) -> float | None:
    """A cell's number; None where it is empty or infinite."""
    found = number(value)
    return found if found is not None and math.isfinite(found) else None


def spelled(value: float | None, digits: int = 2) -> str:
    """``5.7×10⁻¹²``; ``0.57``; ``350``: the same in HTML and in plain text."""
    if value is None:
        return ""
    text = typed(value, digits)
    if "e" not in text:
        return text.replace("-", "\N{MINUS SIGN}")
    if 1.0 <= abs(value) < LARGEST_PLAIN:
        return f"{float(text):.0f}"
    return typographic(text)


def length(metres: float) -> str:
    """``24 m``; ``0.15 mm``."""
    factor, unit = prefixed(metres, "m")
    return f"{short(metres * factor)}\N{NO-BREAK SPACE}{unit}"
