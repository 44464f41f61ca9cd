"""Results of each check on a faulty engine, and the outcome of the fault."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.faults.catalogue import find
from barchain.faults.fault import FaultGroup
from barchain.studies.selftest.invisible import moved_beyond_rounding
from reports.tables.faults.selftest import FaultOutcome
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from barchain.faults.fault import Fault
    from barchain.judge.verdict import Row, Verdict
    from barchain.studies.selftest.trial import Trial, TrialCase
    from barchain.studies.selftest.trial_runner import TrialRunner

CHECKS = {
    "normalised_error": "normalised_error",
    "bound_ratio": "bound",
    "finer_bound_ratio": "bound",
    "restart_ratio": "restarted",
    "own_state_ratio": "own_state",
    "extrapolation_ratio": "extrapolated",
    "drift": "drift",
    "judged_share": "judged_share",
}
"""Metrics that judge, and the names of their checks; `max` is judged as `bound_ratio`"""


@dataclass(frozen=True)
class Reading:
    """One quantity under one check."""

    quantity: str
    check: str
    ratio: float
    """Ratio of the value found to the allowed one; infinite where a check knows no more or less"""
    killed: bool
    reason: str


@dataclass(frozen=True)
class FaultCell:
    """Outcome of one fault in one scene."""

    fault: Fault
    scene: str
    fate: FaultOutcome
    reason: str
    """Reason why it survives, is invisible or changes nothing"""
    readings: tuple[Reading, ...] = ()

    @property
    def worst(self) -> Reading | None:
        """Check with the largest ratio, of those that detect the fault if there are any."""
        return max(self.readings, key=lambda r: (r.killed, r.quantity == "run", r.ratio), default=None)

    def rows(self) -> list[dict[str, Any]]:
        """Rows of the table."""
        shared = {"fault": self.fault.name, "scene": self.scene, "fate": str(self.fate), "why": self.reason}
        if not self.readings:
            return [shared | {"quantity": "", "check": "", "ratio": None, "killed": False, "reason": ""}]
        return [shared | vars(r) for r in self.readings]


def readings(verdict: Verdict) -> tuple[Reading, ...]:
    """Results of all production checks."""
    found = (reading(row) for row in verdict.rows)
    return tuple(r for r in found if r is not None)


def reading(row: Row) -> Reading | None:
    """Result of one row; None of rows that do not judge."""
    outcome = Outcome(row["outcome"])
    killed = not outcome.ok or outcome is Outcome.TOO_COARSE
    if row["metric"] == "outcome":
        return Reading(row["quantity"], str(outcome), np.inf if killed else 0.0, killed, row["reason"])
    if row["metric"] not in CHECKS or row["value"] is None:
        return None
    if row["metric"] == "judged_share":  # a lower bound, and no measure of how near a fault is to its detection
        return Reading(row["quantity"], CHECKS[row["metric"]], np.inf, True, row["reason"]) if killed else None
    value, allowed = float(row["value"]), float(row["tolerance"])
    ratio = 0.0 if value == 0.0 else value / allowed if allowed else np.inf
    return Reading(row["quantity"], CHECKS[row["metric"]], ratio, killed, row["reason"])


def tried(trials: Iterable[Trial], runner: TrialRunner) -> Iterator[FaultCell]:
    """Results of trials, each as soon as its runs are there."""
    for trial in runner.ready(trials):
        yield cell(runner.case(trial))
        runner.forget(trial)


def cell(case: TrialCase) -> FaultCell:
    """Result of a trial."""
    verdict = case.verdict(case.results)
    found = readings(verdict)
    fate, reason = fate_of(case, verdict, found)
    return FaultCell(find(case.trial.fault), case.trial.scene.name, fate, reason, found)


def fate_of(case: TrialCase, verdict: Verdict, found: tuple[Reading, ...]) -> tuple[FaultOutcome, str]:
    """Outcome of a trial, with the reason where no check detects the fault."""
    fault = find(case.trial.fault)
    killed = any(r.killed for r in found)
    if verdict.outcome is Outcome.FAILED and not fault.expected_failure:
        return FaultOutcome.BROKEN, next(r.reason for r in found)
    if fault.group is FaultGroup.CONTROL:
        return (FaultOutcome.FALSE_ALARM if killed else FaultOutcome.CLEAN), ""
    if killed:
        return FaultOutcome.KILLED, ""
    return unseen(case, fault, found)


def unseen(case: TrialCase, fault: Fault, found: tuple[Reading, ...]) -> tuple[FaultOutcome, str]:
    """Outcome of a fault that no check detects: whether it changes anything."""
    near = max(found, key=lambda r: r.ratio)
    said = f"uses at most {near.ratio:.2g} of what is allowed ({near.quantity.replace('_', ' ')}, {near.check})"
    if not fault.invisible:
        return FaultOutcome.SURVIVES, said
    moved = moved_beyond_rounding(case.solution, fault, case.trial.inserted_size)
    if moved > 1.0:
        return FaultOutcome.SURVIVES, f"{said}; not invisible: changes the equations by {moved:.2g} of their rounding"
    return (
        FaultOutcome.INVISIBLE,
        f"{fault.invisible}; measured: at most {moved:.2g} of the equations' own rounding",
    )
