"""Whether errors know of the longitude, which no reaction does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.series import ABSOLUTE, FORMULA, INPUT, RELATIVE, number_or_none
from reports.chapters.roundoff.words import between, listed, size, spelled

if TYPE_CHECKING:
    import pandas as pd

    from reports.chapters.roundoff.series import RoundoffStudy

PARTED = 0.05  # a chance below which sectors are said to differ
COLUMNS = ("state", "formulation", "arithmetic", "source", "ratio")


@dataclass(frozen=True)
class LongitudeRow:
    """Errors around the circle, of one formulation in one arithmetic."""

    of: dict[str, str]
    """In the order of :data:`COLUMNS`"""
    medians: str
    bound: str
    inside: bool
    """Whether every sector's median lies in the band of a typical sector"""
    p: float | None
    """Chance that sectors that are all alike look as different as these"""

    @property
    def p_text(self) -> str:
        """``0.87``."""
        return spelled(self.p)

    @property
    def parted(self) -> bool:
        """Whether sectors are said to differ."""
        return self.p is not None and self.p < PARTED


def longitude_rows(study: RoundoffStudy) -> tuple[LongitudeRow, ...]:
    """One row for each test."""
    table = study.tables.longitudes
    by = [c for c in COLUMNS if c in table]
    parts = table.groupby(by, sort=False)
    return tuple(longitude_row(study, dict(zip(by, key, strict=True)), own) for key, own in parts)


def longitude_row(study: RoundoffStudy, key: dict[str, Any], own: pd.DataFrame) -> LongitudeRow:
    """Sectors' medians beside the band of a typical sector."""
    low, high = float(own.q05.median()), float(own.q95.median())
    medians = [float(v) for v in own["median"]]
    named = {k: size(study, float(v)) if k == "ratio" else str(v) for k, v in key.items()}
    inside = low <= min(medians) and max(medians) <= high
    return LongitudeRow(named, between(medians), between((low, high)), inside, number_or_none(own.p_value.iloc[0]))


def longitudes_say(rows: tuple[LongitudeRow, ...]) -> tuple[str, ...]:
    """What the tests say, of formulas and of their inputs."""
    formula = [r for r in rows if r.of.get("source", FORMULA) == FORMULA]
    return (*formula_says(formula), *input_says([r for r in rows if r.of.get("source") == INPUT]))


def formula_says(rows: list[LongitudeRow]) -> tuple[str, ...]:
    """Of the formulas, which should not differ."""
    if not rows:
        return ()
    parted, outside, count = sum(r.parted for r in rows), sum(not r.inside for r in rows), len(rows)
    chance = f"where chance alone would put {PARTED * count:.1f}"
    said = f"Errors of the formulas should not know of it: {parted} of {count} tests have p below {PARTED:g}, {chance}"
    bounds = "and every sector’s median lies inside the band of a typical one"
    return (
        f"{said}, {bounds if not outside else f'but {outside} have a sector whose median lies outside the bound'}.",
    )


def input_says(rows: list[LongitudeRow]) -> tuple[str, ...]:
    """Of the input, which may."""
    if not rows:
        return ()
    each = [f"{sum(r.parted for r in own)} of {len(own)} in {name} coordinates" for name in (RELATIVE, ABSOLUTE)
            if (own := [r for r in rows if r.of["formulation"] == name])]  # fmt: skip
    return (
        f"Errors of rounding the input may know of it, and do where p is small: {listed(each)}. An inertial angle is "
        "the larger, and so is the unit in its last place, the further round the circle a chain lies.",
    )
