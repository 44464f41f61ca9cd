"""The production judge's verdict on a trial, and what it says of the judge."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from barchain.campaign.cells import Cell, Kind
from barchain.campaign.sizes import larger, sizes
from barchain.campaign.trial import FIRST, Case, Limit, verdict_of
from barchain.scales import scales
from reports.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Trajectory
    from barchain.comparison import Verdict
    from barchain.job import Role, RunResult

DETECTION_LIMIT = "detection_limit"
UNRUN = (Outcome.FAILED, Outcome.TIMED_OUT, Outcome.MISSING)
"""Outcomes of a run that say nothing of a fault in it"""


class Judged(NamedTuple):
    """A trial's cell, and what its verdict leaves to be done."""

    cell: Cell
    limits: dict[str, Limit]
    """What the verdict says that it would detect"""
    asks: tuple[Role, ...]
    """Further runs that would settle it"""


def judged(case: Case) -> Judged:
    """Cell of a trial."""
    results = case.results
    if case.trial.fault:
        nothing = unjudged(case, results)
        if nothing:
            return Judged(nothing, {}, ())
    verdict = verdict_of(case, results)
    cell = fault_cell(case, results, verdict) if case.trial.fault else sound_cell(case, verdict)
    return Judged(cell, limits_of(verdict), verdict.asks)


def limits_of(verdict: Verdict) -> dict[str, Limit]:
    """Detection limits that a verdict states."""
    return {
        row["quantity"]: Limit(float(row["value"]), math.inf if row["horizon_s"] is None else float(row["horizon_s"]))
        for row in verdict.rows
        if row["metric"] == DETECTION_LIMIT
    }


def unjudged(case: Case, results: dict[Role, RunResult]) -> Cell | None:
    """Cell of a fault that changes nothing, or whose runs fail; None where there is something to judge."""
    failed = next((results[role] for role in FIRST if results[role].outcome in UNRUN), None)
    if failed:
        return new_cell(case, Kind.BROKEN, outcome=str(failed.outcome), reason=failed.reason)
    fault = case.trial.planted
    if fault and not fault.declares and all(same(case.sound_trajectory(r), results[r].trajectory) for r in FIRST):
        return new_cell(case, Kind.NOTHING, reason="it changes nothing there")
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


def sound_cell(case: Case, verdict: Verdict) -> Cell:
    """Cell of a sound engine."""
    outcome = verdict.outcome
    if outcome is Outcome.TIMED_OUT:
        return refused(case, verdict, Kind.LATE)
    if not outcome.ok:
        return refused(case, verdict, Kind.FALSE_ALARM)
    kinds = {Outcome.UNSUPPORTED: Kind.UNSUPPORTED, Outcome.ROUNDOFF_LIMITED: Kind.LIMITED}
    kind = kinds.get(outcome, Kind.PASS)
    said = next((row["reason"] for row in verdict.rows if row["outcome"] == outcome), "")
    return new_cell(case, kind, outcome=str(outcome), reason="" if kind is Kind.PASS else said)


def fault_cell(case: Case, results: dict[Role, RunResult], verdict: Verdict) -> Cell:
    """Cell of a fault: whether it is caught, and if not, whether it is as small as is said."""
    whole, compared = (fault_sizes(case, results, to_horizon=inside) for inside in (False, True))
    told = verdict.outcome is Outcome.ROUNDOFF_LIMITED and case.passes
    if told or not verdict.outcome.ok or verdict.outcome is Outcome.UNSUPPORTED:  # none of these is a pass
        return refused(case, verdict, Kind.CAUGHT, whole)
    limits = stated(case.limits, limits_of(verdict))
    quantity, excess = worst(limits, compared)
    if excess > 1.0:
        return compared_cell(case, verdict, Kind.MISSED, quantity, compared)
    quantity, excess = worst(limits, whole)
    return compared_cell(case, verdict, Kind.BEYOND if excess > 1.0 else Kind.BELOW, quantity, whole)


def fault_sizes(case: Case, results: dict[Role, RunResult], *, to_horizon: bool) -> dict[str, float]:
    """Largest change in the main or the finer run; up to where the sound verdict compares, or in all of the run."""
    until = {name: limit.until_s for name, limit in case.limits.items()} if to_horizon else None
    scale, found = scales(case.truth), dict[str, float]()
    for role in FIRST:
        sound, spoilt = case.sound_trajectory(role), results[role].trajectory
        if sound is not None and spoilt is not None:
            found = larger(found, sizes(sound, spoilt, scale, until))
    return found


def stated(sound: dict[str, Limit], own: dict[str, Limit]) -> dict[str, Limit]:
    """Limits that a fault is held against: the larger share of those in the sound verdict and in the fault's own.

    A fault that differs from run to run makes the engine's error estimate larger, and its own verdict says so.
    """
    return {name: max(limit, own.get(name, limit), key=lambda each: each.share) for name, limit in sound.items()}


def worst(limits: dict[str, Limit], found: dict[str, float]) -> tuple[str, float]:
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


def refused(case: Case, verdict: Verdict, kind: Kind, found: dict[str, float] | None = None) -> Cell:
    """Cell of a run that the judge refuses: what it says first."""
    row = next(r for r in verdict.rows if r["outcome"] == verdict.outcome)
    reason = row["reason"] or row["metric"]
    return compared_cell(case, verdict, kind, row["quantity"], found or {}, reason=reason)


def compared_cell(
    case: Case, verdict: Verdict, kind: Kind, quantity: str, found: dict[str, float], *, reason: str = ""
) -> Cell:
    """Cell of a fault with its size in one quantity, and the limits of that."""
    limit, own = (
        limits[quantity].share if quantity in limits else None for limits in (case.limits, limits_of(verdict))
    )
    return new_cell(
        case, kind, outcome=str(verdict.outcome), quantity=quantity, reason=reason, size=found.get(quantity),
        limit=limit, own_limit=own,
    )  # fmt: skip


def new_cell(case: Case, kind: Kind, **known: Any) -> Cell:
    """Cell of a trial, with the time that its own runs took."""
    trial = case.trial
    own = case.made.values() if not trial.fault or not trial.replays else ()
    seconds = sum(sum(result.seconds.values()) for _, result in own)
    return Cell(trial.scene.name, trial.engine, trial.fault, kind, seconds=seconds, **known)
