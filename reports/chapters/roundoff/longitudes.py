"""Dependence of errors on the longitude."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.series import ABSOLUTE, FORMULA, INPUT, RELATIVE, number_or_none
from reports.chapters.roundoff.words import between, listed, size, spelled

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


def longitudes_sentences(rows: tuple[LongitudeRow, ...]) -> tuple[str, ...]:
    """Sentences on the tests, of formulas and of their inputs."""
    formula = [r for r in rows if r.of.get("source", FORMULA) == FORMULA]
    return (*formula_sentences(formula), *input_sentences([r for r in rows if r.of.get("source") == INPUT]))


def formula_sentences(rows: list[LongitudeRow]) -> tuple[str, ...]:
    """Sentence on the formulas: no dependence is expected."""
    if not rows:
        return ()
    parted, outside, count = sum(r.differs for r in rows), sum(not r.inside for r in rows), len(rows)
    chance = f"and {SIGNIFICANT * count:.1f} are expected by chance"
    said = (
        f"Errors of the formulas should not depend on it either: {parted} of {count} tests have p below "
        f"{SIGNIFICANT:g}, {chance}"
    )
    where = "The median of every sector lies inside"
    if outside:
        where = f"In {outside} tests the median of a sector lies outside"
    return (f"{said}. {where} the range of a typical sector.",)


def input_sentences(rows: list[LongitudeRow]) -> tuple[str, ...]:
    """Sentence on the input: a dependence is possible."""
    if not rows:
        return ()
    each = [f"{sum(r.differs for r in own)} of {len(own)} in {name} coordinates" for name in (RELATIVE, ABSOLUTE)
            if (own := [r for r in rows if r.of["formulation"] == name])]  # fmt: skip
    return (
        f"Errors from rounding the input may depend on it; p is small in {listed(each)}. The unit in the last place of "
        "an inertial angle grows with the longitude.",
    )
