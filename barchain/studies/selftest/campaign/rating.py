"""The production judge's verdict on a trial, and its rating as right or wrong."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from barchain.judge.scales import scales
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.campaign.sizes import larger, sizes
from barchain.studies.selftest.trial import FIRST, DetectionLimit, TrialCase
from reports.tables.faults.campaign import CellClass
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.judge.verdict import Verdict
    from barchain.runs.job import Role, RunResult

DETECTION_LIMIT = "detection_limit"
UNRUN = (Outcome.FAILED, Outcome.TIMED_OUT, Outcome.MISSING)
"""Outcomes of a run that say nothing of a fault in it"""
UNJUDGED = (Outcome.UNSUPPORTED, Outcome.TOO_COARSE)
"""Outcomes that are neither a pass nor a rejection"""


class Judged(NamedTuple):
    """A trial's cell, and the further runs that its verdict needs."""

    cell: CampaignCell
    limits: dict[str, DetectionLimit]
    """Detection limits that the verdict states, by quantity"""
    further_runs: tuple[Role, ...]
    """Further runs that would settle it"""


def judged(case: TrialCase) -> Judged:
    """Cell of a trial."""
    results = case.results
    if case.trial.fault:
        nothing = unjudged(case, results)
        if nothing:
            return Judged(nothing, {}, ())
    verdict = case.verdict(results)
    cell = fault_cell(case, results, verdict) if case.trial.fault else unmodified_cell(case, verdict)
    return Judged(cell, limits_of(verdict), verdict.further_runs)


def limits_of(verdict: Verdict) -> dict[str, DetectionLimit]:
    """Detection limits that a verdict states."""
    return {
        row["quantity"]: DetectionLimit(
            float(row["value"]), math.inf if row["limit_s"] is None else float(row["limit_s"])
        )
        for row in verdict.rows
        if row["metric"] == DETECTION_LIMIT
    }


def unjudged(case: TrialCase, results: dict[Role, RunResult]) -> CampaignCell | None:
    """Cell of a fault that changes nothing, or whose runs fail; None where there is something to judge."""
    failed = next((results[role] for role in FIRST if results[role].outcome in UNRUN), None)
    if failed:
        return new_cell(case, CellClass.BROKEN, outcome=str(failed.outcome), reason=failed.reason)
    fault = case.trial.inserted_fault
    if fault and not fault.declares and all(same(case.unmodified_trajectory(r), results[r].trajectory) for r in FIRST):
        return new_cell(case, CellClass.NOTHING, reason="it changes nothing there")
    return None


def same(a: Trajectory | None, b: Trajectory | None) -> bool:
    """Whether two runs show the same, bit for bit."""
    if a is None or b is None:
        return a is b
    mine, theirs = vars(a), vars(b)
    return all(
        np.array_equal(mine[k], theirs[k]) if isinstance(mine[k], np.ndarray) else mine[k] is theirs[k] or
        mine[k] == theirs[k]
        for k in mine
    )  # fmt: skip


def unmodified_cell(case: TrialCase, verdict: Verdict) -> CampaignCell:
    """Cell of an unmodified engine."""
    outcome = verdict.outcome
    if outcome is Outcome.TIMED_OUT:
        return rejected(case, verdict, CellClass.LATE)
    if not outcome.ok:
        return rejected(case, verdict, CellClass.FALSE_ALARM)
    kinds = dict.fromkeys(UNJUDGED, CellClass.UNSUPPORTED) | {Outcome.ROUNDOFF_LIMITED: CellClass.LIMITED}
    kind = kinds.get(outcome, CellClass.PASS)
    said = next((row["reason"] for row in verdict.rows if row["outcome"] == outcome), "")
    return new_cell(case, kind, outcome=str(outcome), reason="" if kind is CellClass.PASS else said)


def fault_cell(case: TrialCase, results: dict[Role, RunResult], verdict: Verdict) -> CampaignCell:
    """Cell of a fault: detected, or smaller or larger than the stated detection limit."""
    whole, compared = (fault_sizes(case, results, to_limit=inside) for inside in (False, True))
    limited = verdict.outcome is Outcome.ROUNDOFF_LIMITED and case.passes
    if limited or not verdict.outcome.ok or verdict.outcome in UNJUDGED:  # none of these is a pass
        return rejected(case, verdict, CellClass.CAUGHT, whole)
    limits = stated(case.limits, limits_of(verdict))
    quantity, excess = worst(limits, compared)
    if excess > 1.0:
        return compared_cell(case, verdict, CellClass.MISSED, quantity, compared)
    quantity, excess = worst(limits, whole)
    return compared_cell(case, verdict, CellClass.BEYOND if excess > 1.0 else CellClass.BELOW, quantity, whole)


def fault_sizes(case: TrialCase, results: dict[Role, RunResult], *, to_limit: bool) -> dict[str, float]:
    """Largest change in the main or the finer run; up to the end of the unmodified verdict's comparison, or overall."""
    until = {name: limit.until_s for name, limit in case.limits.items()} if to_limit else None
    scale, found = scales(case.solution), dict[str, float]()
    for role in FIRST:
        unmodified, faulty = case.unmodified_trajectory(role), results[role].trajectory
        if unmodified is not None and faulty is not None:
            found = larger(found, sizes(unmodified, faulty, scale, until))
    return found


def stated(unmodified: dict[str, DetectionLimit], own: dict[str, DetectionLimit]) -> dict[str, DetectionLimit]:
    """Detection limits for a fault: the larger share of the unmodified and of the faulty engine's verdict.

    A fault that differs from run to run makes the engine's error estimate larger, and its own verdict says so.
    """
    return {name: max(limit, own.get(name, limit), key=lambda each: each.share) for name, limit in unmodified.items()}


def worst(limits: dict[str, DetectionLimit], found: dict[str, float]) -> tuple[str, float]:
    """Quantity whose change is largest over its detection limit, and that ratio; 0 where nothing with a limit changes.

    A limit that is not a number is none.
    """
    ratios = {
        name: size / limits[name].share if limits[name].share > 0.0 else math.inf
        for name, size in found.items()
        if name in limits and size > 0.0
    }
    quantity = max(ratios, key=lambda name: ratios[name], default="")
    return quantity, ratios.get(quantity, 0.0)


def rejected(case: TrialCase, verdict: Verdict, kind: CellClass, found: dict[str, float] | None = None) -> CampaignCell:
    """Cell of a run that the judge rejects, with its first reason."""
    row = next(r for r in verdict.rows if r["outcome"] == verdict.outcome)
    reason = row["reason"] or row["metric"]
    return compared_cell(case, verdict, kind, row["quantity"], found or {}, reason=reason)


def compared_cell(
    case: TrialCase, verdict: Verdict, kind: CellClass, quantity: str, found: dict[str, float], *, reason: str = ""
) -> CampaignCell:
    """Cell of a fault with its size in one quantity, and the limits of that."""
    limit, own = (
        limits[quantity].share if quantity in limits else None for limits in (case.limits, limits_of(verdict))
    )
    return new_cell(
        case, kind, outcome=str(verdict.outcome), quantity=quantity, reason=reason, size=found.get(quantity),
        limit=limit, own_limit=own,
    )  # fmt: skip


def new_cell(case: TrialCase, kind: CellClass, **known: Any) -> CampaignCell:
    """Cell of a trial, with the time that its own runs took."""
    trial = case.trial
    own = case.made.values() if not trial.fault or not trial.replays else ()
    seconds = sum(sum(result.seconds.values()) for _, result in own)
    return CampaignCell(trial.scene.name, trial.engine, trial.fault, kind, seconds=seconds, **known)
