"""Parts that charts of runs share: quantities, labels, groups of rows."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

    from reports.chapters.roundoff.axes import ErrorCurve

QUANTITIES = {  # title, vertical axis
    "attitude": ("Attitude", "error, rad"),
    "reaction": ("Reactions", "error / largest reaction"),
    "gap": ("Joint gaps", "gap / bar's length"),
    "com": ("Centre of mass", "error / bar's length"),
}
STEPS_LABEL, RTOL_LABEL = "steps per orbit", "relative tolerance"
HOLLOW = "Hollow: below the error of the reference solution."


def has_unresolved(curves: list[ErrorCurve]) -> bool:
    """Whether any point is below the error of the reference solution."""
    return any(c.blurred is not None and c.blurred.any() for c in curves)


def by_pair(table: pd.DataFrame, name: str) -> list[tuple[tuple[str, float], pd.DataFrame]]:
    """Parts of a table by a word and a size."""
    found = {(str(word), float(ratio)) for word, ratio in zip(table[name], table.ratio, strict=True)}
    order = sorted(found, key=lambda pair: (pair[0], -pair[1]))
    return [((word, r), table[(table[name] == word) & (table.ratio == r)]) for word, r in order]


def sizes_of(table: pd.DataFrame) -> list[float]:
    """Size ratios, from the longest."""
    return sorted({float(r) for r in table.ratio}, reverse=True)
