"""Cells of a kill matrix as the page and the terminal see them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.outcome import Outcome
from reports.tables.selftest import FaultOutcome
from reports.text.numerals import significant

if TYPE_CHECKING:
    import pandas as pd

CHECKS = {
    "normalised_error": "≠",
    "bound": "▲",
    "drift": "≈",
    Outcome.INCONSISTENT: "≠",
    Outcome.INCOMPLETE: "◐",
    Outcome.NOT_FINITE: "?",
    Outcome.JOINTS_IGNORED: "¦",
    Outcome.NOTHING_COMPARED: "○",
    Outcome.FAILED: "✗",
    Outcome.TIMED_OUT: "◷",
}
"""Sign of each check"""
CHECK_WORDS = {
    "normalised_error": "differs from the truth by more than both errors explain",
    "bound": "outside the band that method and setting promise",
    "drift": "what should stay drifts out of its band",
    Outcome.INCONSISTENT: "a bar reaches the surface at another instant than both errors explain",
    Outcome.INCOMPLETE: "a channel, a sample, an instant or the reason for the end is missing or wrong",
    Outcome.NOT_FINITE: "not a number",
    Outcome.JOINTS_IGNORED: "joints are open",
    Outcome.NOTHING_COMPARED: "two settings part too early to be compared",
    Outcome.FAILED: "the engine fails",
    Outcome.TIMED_OUT: "the engine does not come to an end",
}
FATES = {
    FaultOutcome.SURVIVES: "survives",
    FaultOutcome.INVISIBLE: "invisible",
    FaultOutcome.NOTHING: "–",
    FaultOutcome.CLEAN: "✓ clean",
    FaultOutcome.FALSE_ALARM: "false alarm",
    FaultOutcome.BROKEN: "broken",
}
KINDS = {
    FaultOutcome.KILLED: "pass",
    FaultOutcome.CLEAN: "pass",
    FaultOutcome.SURVIVES: "fail",
    FaultOutcome.FALSE_ALARM: "fail",
    FaultOutcome.BROKEN: "fail",
    FaultOutcome.INVISIBLE: "gone",
    FaultOutcome.NOTHING: "aside",
}
WHOLE = "run"
LANDING = "landing"


@dataclass(frozen=True)
class Kill:
    """One check that refuses a spoilt engine, or comes nearest to it."""

    quantity: str
    check: str
    ratio: float
    reason: str

    @property
    def name(self) -> str:
        """``reaction``; nothing where the whole run is refused."""
        return "" if self.quantity == WHOLE else self.quantity.replace("_", " ")

    @property
    def text(self) -> str:
        """``≠ reaction``, ``◐ incomplete``."""
        whole = LANDING if self.check == Outcome.INCONSISTENT else self.check.replace("_", " ")
        return f"{CHECKS.get(self.check, '')} {self.name or whole}".strip()


@dataclass(frozen=True)
class MatrixCell:
    """One fault in one scene."""

    fault: str
    scene: str
    fate: FaultOutcome
    kills: tuple[Kill, ...]
    """Worst first"""
    reason: str

    @property
    def text(self) -> str:
        """What the cell says."""
        if self.fate is not FaultOutcome.KILLED:
            return FATES[self.fate]
        return self.kills[0].text

    @property
    def further(self) -> int:
        """Number of other quantities whose checks kill it too."""
        return len({k.quantity for k in self.kills}) - 1

    @property
    def kind(self) -> str:
        """Class of its colour."""
        return KINDS[self.fate]

    @property
    def title(self) -> str:
        """All that is known, in words."""
        said = [f"{k.name or 'run'}: {k.check}{amount(k)}" for k in self.kills]
        return "; ".join(said) or self.reason


def amount(kill: Kill) -> str:
    """How far outside, where that is a matter of size."""
    if kill.quantity == WHOLE:
        return f" ({kill.reason})" if kill.reason else ""
    return f", {significant(kill.ratio, 2)} times what is allowed"


def cells(table: pd.DataFrame) -> dict[tuple[str, str], MatrixCell]:
    """Cells by fault and scene, in the table's order."""
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in table.to_dict("records"):
        groups.setdefault((row["fault"], row["scene"]), []).append({str(k): v for k, v in row.items()})
    return {key: matrix_cell(key, rows) for key, rows in groups.items()}


def matrix_cell(key: tuple[str, str], rows: list[dict[str, Any]]) -> MatrixCell:
    """Cell from its rows: refusals of the whole run first, then by how far outside."""
    fate = FaultOutcome(rows[0]["fate"])
    kills = [Kill(r["quantity"], r["check"], float(r["ratio"]), r["reason"]) for r in rows if bool(r["killed"])]
    kills.sort(key=lambda k: (k.quantity != WHOLE, -k.ratio))
    return MatrixCell(*key, fate, tuple(kills), rows[0]["why"])
