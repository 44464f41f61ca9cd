"""Round-off study as its chapter reads it: series of errors, digits at a size, lengths of bars, numbers as text."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from reports.text.numerals import prefixed, short, typed, typographic

if TYPE_CHECKING:
    import pandas as pd

    from reports.results.files import StudyTables

USUAL: dict[str, Any] = {
    "arithmetic": "float64", "state": "generic", "bars": 5, "source": "both", "yardstick": "reaction",
}  # fmt: skip
"""Series of an evaluation that is shown unless another is named: of the paper's number of bars"""
SMALLEST, LARGEST = 1e-40, 1e40  # stand-ins of zero and infinity, whose logarithms are numbers
LARGEST_PLAIN = 1e4
QUANTITIES = {  # title, vertical axis
    "attitude": ("Attitude", "error, rad"),
    "reaction": ("Reactions", "error / largest reaction"),
    "gap": ("Joint gaps", "gap / bar's length"),
    "com": ("Centre of mass", "error / bar's length"),
}
METHODS = {"rk4": "RK4", "dop853": "DOP853 at equal steps", "dop853, chosen steps": "DOP853 with step control"}


class Digits(NamedTuple):
    """Significant decimal digits: of the error's 95 % quantile, its median, and its 5 % quantile."""

    low: float
    median: float
    high: float


class Roundoff:
    """Tables of a round-off study, and queries of them."""

    def __init__(self, tables: StudyTables) -> None:
        self.tables = tables
        objects = sorted(tables.record.get("objects") or (), key=lambda o: -o["ratio"])
        self.named: list[tuple[str, float]] = [(o["name"], o["ratio"]) for o in objects]
        """Named objects and their size ratios, from the longest"""
        self.radius_m: float | None = objects[0]["length_m"] / objects[0]["ratio"] if objects else None
        """Length of a bar of size ratio 1; None without named objects"""
        self.units: dict[str, float] = tables.record.get("unit_roundoff") or {}
        """Unit round-off of each arithmetic"""

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
        return f"ε = {spelled(ratio)}" if self.radius_m is None else length(ratio * self.radius_m)


def rows_of(table: pd.DataFrame, **key: Any) -> pd.DataFrame:
    """Rows of a table with these values in these columns."""
    kept = np.ones(len(table), bool)
    for name, value in key.items():
        kept &= (table[name] == value).to_numpy(bool)
    return table[kept]


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
