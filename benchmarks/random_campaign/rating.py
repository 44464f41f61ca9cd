"""The production judge's verdict on a trial, rated as right or wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import StrEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from barchain.judge.evidence import follow_up_jobs
from barchain.judge.scales import scales
from barchain.judge.verdict import Verdict
from barchain.metrics.quantities import differences
from barchain.runs.call import CallLateError
from barchain.studies.selftest.trial import FIRST, judged, with_runs
from reports.results.outcome import Outcome
from scenarios.channels import DRIFTING

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array, Trajectory
    from barchain.runs.cases import Case
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.trial import SceneRuns, Trial, TrialRuns

DETECTION_LIMIT = "detection_limit"
UNRUN = (Outcome.FAILED, Outcome.TIMED_OUT, Outcome.MISSING)
"""Outcomes of a run that say nothing of a fault in it"""
UNJUDGED = (Outcome.UNSUPPORTED, Outcome.TOO_COARSE)
"""Outcomes that are neither a pass nor a rejection"""
LOST = 1.0  # of a quantity's scale: what a sample that is missing counts as
MEASURED = {channel.name: channel.array for channel in DRIFTING if channel.array}


class Rating(StrEnum):
    """Rating of a trial."""

    PASS = "pass"
    """An unmodified engine that the judge accepts"""
    LIMITED = "limited"
    """An unmodified engine that round-off limits, by the verdict"""
    FALSE_ALARM = "false alarm"
    """An unmodified engine that the judge rejects"""
    UNSUPPORTED = "unsupported"
    """An engine that does not support the scene"""
    LATE = "timed out"
    """An engine whose run reaches its time limit: no verdict"""
    CAUGHT = "caught"
    """A faulty engine that the judge rejects"""
    MISSED = "missed"
    """An undetected fault above the detection limit of the verdict"""
    BELOW = "below the limit"
    """An undetected fault below the detection limit of the verdict"""
    BEYOND = "beyond the predictability limit"
    """An undetected fault above the detection limit only where the verdict compares nothing with the reference"""
    NOTHING = "not applicable"
    """A fault that changes nothing in the scene, or can't be inserted"""
    BROKEN = "broken"
    """A faulty engine that fails where it should run: the fault is not inserted as meant"""


class DetectionLimit(NamedTuple):
    """Smallest error that a verdict states it would detect."""

    share: float
    """Of the quantity's scale"""
    until_s: float
    """End of the comparison with the reference solution, s"""


Limits = dict[str, DetectionLimit]
"""By quantity"""


@dataclass(frozen=True)
class RatedTrial:
    """One engine on one scene, as it is or with a fault in it."""

    scene: str
    engine: str
    fault: str
    """Empty: the engine as it is"""
    outcome: str = ""
    """The judge's; empty where nothing was judged"""
    rating: Rating = Rating.NOTHING
    quantity: str = ""
    """Quantity that is rejected, or that the fault changes most"""
    reason: str = ""
    size: float | None = None
    """Largest change of the quantity, over its scale"""
    limit: float | None = None
    """Smallest detectable change by the unmodified engine's verdict"""
    limits: Limits = field(default_factory=dict, compare=False)
    """Detection limits that its verdict states"""

    @property
    def is_finding(self) -> bool:
        """Whether it speaks against the judge."""
        return self.rating in (Rating.MISSED, Rating.FALSE_ALARM)


def rated(
    scene: SceneRuns, trial: Trial, solution: ReferenceSolution, before: RatedTrial | None = None
) -> Case[RatedTrial]:
    """Run a trial, and rate its verdict; where the first runs do not decide it, after those that it asks for besides.

    Parameters
    ----------
    scene : SceneRuns
    trial : Trial
    solution : ReferenceSolution
    before : RatedTrial, optional
        The unmodified engine; needed for a fault.
    """
    runs = yield from scene.runs_of(trial, solution)
    nothing = None if before is None else unjudged(runs)
    if nothing is not None:
        return nothing
    verdict = yield from judged(runs)
    if isinstance(verdict, Verdict) and verdict.further_runs:
        jobs = follow_up_jobs(
            trial.scene, trial.engine, trial.registration, trial.host, trial.setting, verdict.further_runs
        )
        made = yield [scene.run_of(job) for job in jobs]
        runs = with_runs(runs, jobs, made)
        verdict = yield from judged(runs)
    if isinstance(verdict, Verdict):
        return rated_unmodified(runs, verdict) if before is None else rated_fault(runs, verdict, before)
    rating = Rating.BROKEN if trial.fault else Rating.FALSE_ALARM
    outcome = Outcome.NOTHING_COMPARED if isinstance(verdict, CallLateError) else Outcome.FAILED
    said = f"no verdict: {verdict}"
    return RatedTrial(trial.scene.name, trial.engine, trial.fault, str(outcome), rating, reason=said)


def unjudged(runs: TrialRuns) -> RatedTrial | None:
    """Rating of a fault that changes nothing, or whose runs fail; None where there is something to judge."""
    trial, fault = runs.trial, runs.trial.inserted_fault
    found = RatedTrial(trial.scene.name, trial.engine, trial.fault)
    failed = next((runs.results[role] for role in FIRST if runs.results[role].outcome in UNRUN), None)
    if failed:
        return replace(found, rating=Rating.BROKEN, outcome=str(failed.outcome), reason=failed.reason)
    alike = (same(runs.unmodified_trajectory(role), runs.results[role].trajectory) for role in FIRST)
    if fault and not fault.declares and all(alike):
        return replace(found, reason="it changes nothing there")
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


def rated_unmodified(runs: TrialRuns, verdict: Verdict) -> RatedTrial:
    """Rating of an unmodified engine."""
    outcome = verdict.outcome
    if not outcome.ok:
        late = outcome is Outcome.TIMED_OUT
        return rated_as(runs, verdict, Rating.LATE if late else Rating.FALSE_ALARM, *rejection(verdict))
    ratings = dict.fromkeys(UNJUDGED, Rating.UNSUPPORTED) | {Outcome.ROUNDOFF_LIMITED: Rating.LIMITED}
    rating = ratings.get(outcome, Rating.PASS)
    said = next((row["reason"] for row in verdict.rows if row["outcome"] == outcome), "")
    return rated_as(runs, verdict, rating, "", "" if rating is Rating.PASS else said)


def rated_fault(runs: TrialRuns, verdict: Verdict, before: RatedTrial) -> RatedTrial:
    """Rating of a fault: detected, or smaller or larger than the stated detection limit.

    Where the unmodified engine passes, a fault that is then limited by round-off is detected.
    """
    stated, own = before.limits, limits_of(verdict)
    whole = fault_sizes(runs)
    limited = verdict.outcome is Outcome.ROUNDOFF_LIMITED and before.rating is Rating.PASS
    if limited or not verdict.outcome.ok or verdict.outcome in UNJUDGED:  # none of these is a pass
        return rated_as(runs, verdict, Rating.CAUGHT, *rejection(verdict), whole, stated)
    # a fault that differs from run to run makes the engine's error estimate larger, and its own verdict says so
    limits = {name: max(limit, own.get(name, limit), key=lambda each: each.share) for name, limit in stated.items()}
    compared = fault_sizes(runs, stated)
    quantity, excess = worst(limits, compared)
    if excess > 1.0:
        return rated_as(runs, verdict, Rating.MISSED, quantity, "", compared, stated)
    quantity, excess = worst(limits, whole)
    rating = Rating.BEYOND if excess > 1.0 else Rating.BELOW
    return rated_as(runs, verdict, rating, quantity, "", whole, stated)


def rejection(verdict: Verdict) -> tuple[str, str]:
    """Quantity that a verdict rejects, and its first reason."""
    row = next(r for r in verdict.rows if r["outcome"] == verdict.outcome)
    return row["quantity"], row["reason"] or row["metric"]


def rated_as(
    runs: TrialRuns,
    verdict: Verdict,
    rating: Rating,
    quantity: str,
    reason: str,
    found: Mapping[str, float] = MappingProxyType({}),
    stated: Mapping[str, DetectionLimit] = MappingProxyType({}),
) -> RatedTrial:
    """Trial with its rating: the size of its fault in one quantity, of sizes `found`, and the limit of that."""
    trial, limit = runs.trial, stated[quantity].share if quantity in stated else None
    return RatedTrial(
        trial.scene.name, trial.engine, trial.fault, str(verdict.outcome), rating, quantity, reason,
        found.get(quantity), limit, limits_of(verdict),
    )  # fmt: skip


def limits_of(verdict: Verdict) -> Limits:
    """Detection limits that a verdict states."""
    return {
        row["quantity"]: DetectionLimit(
            float(row["value"]), math.inf if row["limit_s"] is None else float(row["limit_s"])
        )
        for row in verdict.rows
        if row["metric"] == DETECTION_LIMIT
    }


def fault_sizes(runs: TrialRuns, limits: Limits | None = None) -> dict[str, float]:
    """Largest change in the main or the finer run; up to the end of a comparison with these limits, or overall."""
    until = None if limits is None else {name: limit.until_s for name, limit in limits.items()}
    scale, found = scales(runs.solution), dict[str, float]()
    for role in FIRST:
        unmodified, faulty = runs.unmodified_trajectory(role), runs.results[role].trajectory
        if unmodified is not None and faulty is not None:
            one = sizes(unmodified, faulty, scale, until)
            found = {name: max(found.get(name, 0.0), one.get(name, 0.0)) for name in {**found, **one}}
    return found


def worst(limits: Limits, found: dict[str, float]) -> tuple[str, float]:
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


def sizes(
    unmodified: Trajectory, faulty: Trajectory, scale: Mapping[str, float], until_s: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Largest relative change that a fault makes in each quantity.

    Parameters
    ----------
    unmodified, faulty : Trajectory
        The same run without the fault and with it.
    scale : mapping
        Size of each quantity in the scene, SI units, see `barchain.judge.scales`.
    until_s : mapping, optional
        For each quantity, the last instant that counts, s; the whole run by default.

    Returns
    -------
    dict
        Shares of the scales. A sample that only one of the runs has counts as the whole scale.
    """
    found = {}
    for name, change in changes(unmodified, faulty).items():
        lost = np.full(abs(len(unmodified.t_s) - len(faulty.t_s)), LOST)
        t_s = max(unmodified.t_s, faulty.t_s, key=len)
        share = np.concatenate([change / scale[name] if scale[name] else np.where(change > 0.0, np.inf, 0.0), lost])
        counts = t_s <= (until_s or {}).get(name, np.inf)
        found[name] = float(share[counts].max(initial=0.0))
    return found


def changes(unmodified: Trajectory, faulty: Trajectory) -> dict[str, Array]:
    """Largest change over bars or joints at each common sample, (n,) for each quantity, SI units."""
    n = min(len(unmodified.t_s), len(faulty.t_s))
    found = differences(unmodified, faulty)
    for name, measured in MEASURED.items():
        mine, theirs = getattr(unmodified, measured), getattr(faulty, measured)
        if mine is not None and theirs is not None and mine.size:
            found[name] = np.abs(mine[:n] - theirs[:n]).reshape(n, -1).max(axis=1)
    return found
