"""Outcome of a fault in the kill matrix: results of each check, and whether the fault changes anything at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import chain_model
from barchain.faults.catalogue import CONTROLS, UNMODIFIED, find
from barchain.faults.fault import FaultGroup
from barchain.judge.scales import MACHINE_EPSILON, ROUNDINGS
from barchain.judge.verdict import Verdict
from barchain.studies.selftest.trial import judged
from reference_impl.model import relative
from reference_impl.model.kinematics import consistent_state
from reports.tables.faults.selftest import KILLED, FaultOutcome
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array
    from barchain.faults.fault import Fault
    from barchain.judge.verdict import Row
    from barchain.runs.call import CallFailedError
    from barchain.runs.cases import Case
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.trial import SceneRuns, Trial, TrialRuns

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
COMPARED = ("com_m_s2", "angle_rad_s2", "reaction_N", "torque_N_m")
"""Results of the equations by which a fault is proven invisible"""


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

    @property
    def killer(self) -> Reading | None:
        """Check that detects the fault; None if none does."""
        return self.worst if self.fate is FaultOutcome.KILLED else None

    @property
    def row(self) -> dict[str, Any]:
        """Row of its outcome."""
        return {"fault": self.fault.name, "scene": self.scene, "fate": str(self.fate), "why": self.reason}

    def reading_rows(self) -> Iterator[dict[str, Any]]:
        """A row for each check of a quantity: of several readings the one that rejects, or else the largest."""
        worst: dict[tuple[str, str], Reading] = {}
        for one in (r for r in self.readings if r.killed or np.isfinite(r.ratio)):
            place = one.quantity, one.check
            worst[place] = max(worst.get(place, one), one, key=lambda r: (r.killed, r.ratio))
        for one in worst.values():
            named = {"fault": self.fault.name, "scene": self.scene, "quantity": one.quantity, "check": one.check}
            yield named | {"ratio": one.ratio, "killed": KILLED if one.killed else "", "reason": one.reason}


def tried(scene: SceneRuns, trial: Trial) -> Case[FaultCell]:
    """Outcome of a fault, or of a control; its verdict rests on the first runs, and takes no further ones."""
    (solution,) = yield [scene.solution]
    reason = trial.left_out(solution)
    if reason:
        return FaultCell(find(trial.fault), trial.scene.name, FaultOutcome.NOTHING, reason)
    runs = yield from scene.runs_of(trial, solution)
    verdict = yield from judged(runs)
    return cell(runs, verdict)


def cell(runs: TrialRuns, verdict: Verdict | CallFailedError) -> FaultCell:
    """Result of a trial."""
    fault, scene = find(runs.trial.fault), runs.trial.scene.name
    if not isinstance(verdict, Verdict):
        return FaultCell(fault, scene, FaultOutcome.BROKEN, f"no verdict: {verdict}")
    found = tuple(r for row in verdict.rows if (r := reading(row)) is not None)
    fate, reason = fate_of(runs, fault, verdict, found)
    return FaultCell(fault, scene, fate, reason, found)


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


def fate_of(runs: TrialRuns, fault: Fault, verdict: Verdict, found: tuple[Reading, ...]) -> tuple[FaultOutcome, str]:
    """Outcome of a trial, with the reason where no check detects the fault: whether it changes anything."""
    killed = any(r.killed for r in found)
    if verdict.outcome is Outcome.FAILED and not fault.expected_failure:
        return FaultOutcome.BROKEN, next(r.reason for r in found)
    if fault.group is FaultGroup.CONTROL:
        return (FaultOutcome.FALSE_ALARM if killed else FaultOutcome.CLEAN), ""
    if killed:
        return FaultOutcome.KILLED, ""
    near = max(found, key=lambda r: r.ratio)
    said = f"uses at most {near.ratio:.2g} of what is allowed ({near.quantity.replace('_', ' ')}, {near.check})"
    if not fault.invisible:
        return FaultOutcome.SURVIVES, said
    moved = moved_beyond_rounding(runs.solution, fault, runs.trial.inserted_size)
    if moved > 1.0:
        return FaultOutcome.SURVIVES, f"{said}; not invisible: changes the equations by {moved:.2g} of their rounding"
    return (
        FaultOutcome.INVISIBLE,
        f"{fault.invisible}; measured: at most {moved:.2g} of the equations' own rounding",
    )


def moved_beyond_rounding(solution: ReferenceSolution, fault: Fault, size: float) -> float:
    """Largest change of the equations' results by a fault, over their round-off.

    This is the numerical proof of invisibility, at every state of the reference solution. All that a run shows follows
    from the accelerations, reactions and torques of the states it goes through. Trajectories themselves tell less: the
    first steps are chosen by an error estimate that is nothing but rounding, and two runs whose equations differ in the
    last digit part by what their steps then leave.

    The control's own rounding is what it differs by from the relative formulation, beside a few units in the last
    place of the largest value: sums such as phi'' + omega'' round the parts, which are larger than the sum.
    """
    faulty, control = evaluated(solution, fault, size), evaluated(solution, CONTROLS[fault.like], 0.0)
    unmodified = evaluated(solution, CONTROLS[UNMODIFIED], 0.0)
    shares = [0.0]
    for name, right in control.items():
        allowed = ROUNDINGS * MACHINE_EPSILON * largest(right) + largest(right - unmodified[name])
        apart = largest(faulty[name] - right)
        shares.append(0.0 if apart == 0.0 else apart / allowed)
    return max(shares)


def evaluated(solution: ReferenceSolution, fault: Fault, size: float) -> dict[str, Array]:
    """Results of the equations with a fault in the code, at the reference solution's samples."""
    model, seen = chain_model(solution.scene), solution.trajectory
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    moving = zip(seen.t_s, seen.com_m, seen.com_velocity_m_s, seen.angle_rad, seen.rate_rad_s, strict=True)
    with fault.within(size):
        found = [relative.accelerations(model, t, consistent_state(model, *state)) for t, *state in moving]
    return {name: np.array([getattr(a, name) for a in found]) for name in COMPARED}


def largest(values: Array) -> float:
    """Largest absolute value; 0 for an empty array."""
    return float(np.abs(values).max(initial=0.0))
