"""Cells of the kill matrix, for the page and the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.faults.selftest import FaultOutcome
from reports.tables.outcome import Outcome
from reports.text.numerals import significant

if TYPE_CHECKING:
    import pandas as pd

CHECKS = {
    "normalised_error": "≠",
    "bound": "▲",
    "drift": "≈",
    "restarted": "↻",
    "own_state": "↔",
    "extrapolated": "½",
    "judged_share": "○",
    Outcome.INCONSISTENT: "≠",
    Outcome.INCOMPLETE: "◐",
    Outcome.NOT_FINITE: "?",
    Outcome.JOINTS_IGNORED: "¦",
    Outcome.NOTHING_COMPARED: "○",
    Outcome.TOO_COARSE: "○",
    Outcome.EXCEEDS_BOUND: "▲",
    Outcome.MALFORMED: "#",
    Outcome.MISSING: "✗",
    Outcome.FAILED: "✗",
    Outcome.TIMED_OUT: "◷",
}
"""Sign of each check"""
CHECK_WORDS = {
    "normalised_error": "normalised error above 1",
    "bound": "error above the expected-error bound",
    "drift": "drift of a conserved quantity above its bound",
    "restarted": "deviation from the reference restarted at the engine's own sample",
    "own_state": "reactions or torques that do not belong to the engine's own state",
    "extrapolated": "error above that of the two runs' Richardson extrapolation",
    "judged_share": "too small a share of the run can be judged",
    Outcome.INCONSISTENT: "instant of surface contact unexplained by both errors",
    Outcome.INCOMPLETE: "channel, sample, instant or reason of the end missing or wrong",
    Outcome.NOT_FINITE: "NaN or infinity",
    Outcome.JOINTS_IGNORED: "open joints",
    Outcome.NOTHING_COMPARED: "nothing of the run can be compared",
    Outcome.TOO_COARSE: "too little of the run can be predicted at the setting",
    Outcome.EXCEEDS_BOUND: "error of the whole run above its bound",
    Outcome.MALFORMED: "values with too few digits, or undeclared channels",
    Outcome.MISSING: "engine that does not import",
    Outcome.FAILED: "failure of the engine",
    Outcome.TIMED_OUT: "run ended at its time limit",
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
class Detection:
    """Check that rejects a faulty engine, or comes closest to a rejection."""

    quantity: str
    check: str
    ratio: float
    reason: str

    @property
    def name(self) -> str:
        """``reaction``; empty if the whole run is rejected."""
        return "" if self.quantity == WHOLE else self.quantity.replace("_", " ")

    @property
    def text(self) -> str:
        """``≠ reaction``, ``◐ incomplete``."""
        whole = LANDING if self.check == Outcome.INCONSISTENT else self.check.replace("_", " ")
        return f"{CHECKS[self.check]} {self.name or whole}".strip()


@dataclass(frozen=True)
class MatrixCell:
    """One fault in one scene."""

    fault: str
    scene: str
    fate: FaultOutcome
    detections: tuple[Detection, ...]
    """Largest ratio first"""
    reason: str

    @property
    def text(self) -> str:
        """Text of the cell."""
        if self.fate is not FaultOutcome.KILLED:
            return FATES[self.fate]
        return self.detections[0].text

    @property
    def further(self) -> int:
        """Number of further quantities whose checks detect the fault."""
        return len({k.quantity for k in self.detections}) - 1

    @property
    def kind(self) -> str:
        """Class of its colour."""
        return KINDS[self.fate]

    @property
    def title(self) -> str:
        """All checks with their ratios, in words."""
        said = [f"{k.name or 'run'}: {k.check}{amount(k)}" for k in self.detections]
        return "; ".join(said) or self.reason


def amount(detection: Detection) -> str:
    """Ratio to the allowed value, or the reason of a rejected run."""
    if detection.quantity == WHOLE:
        return f" ({detection.reason})" if detection.reason else ""
    return f", {significant(detection.ratio, 2)} times the allowed value"


def cells(table: pd.DataFrame) -> dict[tuple[str, str], MatrixCell]:
    """Cells by fault and scene, in the table's order."""
    groups: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in table.to_dict("records"):
        groups.setdefault((row["fault"], row["scene"]), []).append({str(k): v for k, v in row.items()})
    return {key: matrix_cell(key, rows) for key, rows in groups.items()}


def matrix_cell(key: tuple[str, str], rows: list[dict[str, Any]]) -> MatrixCell:
    """Cell from its rows: rejections of the whole run first, then by ratio."""
    fate = FaultOutcome(rows[0]["fate"])
    detections = [
        Detection(r["quantity"], r["check"], float(r["ratio"]), r["reason"]) for r in rows if bool(r["killed"])
    ]
    detections.sort(key=lambda k: (k.quantity != WHOLE, -k.ratio))
    return MatrixCell(*key, fate, tuple(detections), rows[0]["why"])
