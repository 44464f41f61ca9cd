"""Dependence of errors on the longitude."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.series import FORMULA, number_or_none
from reports.chapters.roundoff.words import between, size, spelled

if TYPE_CHECKING:
    import pandas as pd

    from reports.chapters.roundoff.series import RoundoffData

SIGNIFICANT = 0.05  # p below which sectors are said to differ
COLUMNS = ("state", "formulation", "arithmetic", "source", "ratio")


@dataclass(frozen=True)
class LongitudeRow:
    """Errors by sector of the longitude, of one formulation in one arithmetic."""

    of: dict[str, str]
    """In the order of :data:`COLUMNS`"""
    medians: str
    bound: str
    inside: bool
    """Whether every sector's median lies in the 5 to 95 % range of a typical sector"""
    p: float | None
    """Probability of at least these differences between equal sectors"""

    @property
    def p_text(self) -> str:
        """``0.87``."""
        return spelled(self.p)

    @property
    def of_input(self) -> bool:
        """Whether the errors are those of rounding the input, which may depend on the longitude."""
        return self.of.get("source", FORMULA) != FORMULA

    @property
    def differs(self) -> bool:
        """Whether sectors are said to differ."""
        return self.p is not None and self.p < SIGNIFICANT


def longitude_rows(study: RoundoffData) -> tuple[LongitudeRow, ...]:
    """One row for each test."""
    table = study.tables.longitudes
    by = [c for c in COLUMNS if c in table]
    parts = table.groupby(by, sort=False)
    return tuple(longitude_row(study, dict(zip(by, key, strict=True)), own) for key, own in parts)


def longitude_row(study: RoundoffData, key: dict[str, Any], own: pd.DataFrame) -> LongitudeRow:
    """Medians of the sectors beside the range of a typical sector."""
    low, high = float(own.q05.median()), float(own.q95.median())
    medians = [float(v) for v in own["median"]]
    named = {k: size(study, float(v)) if k == "ratio" else str(v) for k, v in key.items()}
    inside = low <= min(medians) and max(medians) <= high
    return LongitudeRow(named, between(medians), between((low, high)), inside, number_or_none(own.p_value.iloc[0]))
