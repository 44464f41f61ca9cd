"""The production judge's verdict on a trial, rated as right or wrong: cells of the random campaign, and their rates."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.stats import binomtest

from barchain.judge.scales import scales
from barchain.judge.verdict import Verdict
from barchain.metrics.quantities import differences
from barchain.runs.call import CallLateError
from barchain.studies.selftest.trial import FIRST, judged
from reports.results.faults.campaign import ALL, CellClass
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
UNMODIFIED = (CellClass.PASS, CellClass.LIMITED, CellClass.FALSE_ALARM)
"""Classes of unmodified engines that ran"""
TRIED = (CellClass.CAUGHT, CellClass.MISSED)
"""Classes of faults that a verdict has to detect"""
LOST = 1.0  # of a quantity's scale: what a sample that is missing counts as
MEASURED = {channel.name: channel.array for channel in DRIFTING if channel.array}
CONFIDENCE = 0.95
MOST_FALSE_ALARMS = 0.005
"""Share of verdicts on unmodified engines that may be false alarms"""


class DetectionLimit(NamedTuple):
    """Smallest error that a verdict states it would detect."""

    share: float
    """Of the quantity's scale"""
    until_s: float
    """End of the comparison with the reference solution, s"""


Limits = dict[str, DetectionLimit]
"""By quantity"""


@dataclass(frozen=True)
class CampaignCell:
    """One engine on one scene, as it is or with a fault in it; a row of the table."""

    scene: str
    engine: str
    fault: str
    """Empty: the engine as it is"""
    outcome: str = ""
    """The judge's; empty where nothing was judged"""
    kind: CellClass = CellClass.NOTHING
    quantity: str = ""
    """Quantity that is rejected, or that the fault changes most"""
    reason: str = ""
    size: float | None = None
    """Largest change of the quantity, over its scale"""
    limit: float | None = None
    """Smallest detectable change by the unmodified engine's verdict"""
    own_limit: float | None = None
    """Smallest detectable change by the faulty engine's own verdict, which a user would read"""
    seconds: float = 0.0
    """Time of its own runs"""
    limits: Limits = field(default_factory=dict, compare=False)
    """Detection limits that its verdict states; no column of the table"""

    @property
    def is_finding(self) -> bool:
        """Whether it speaks against the judge."""
        return self.kind in (CellClass.MISSED, CellClass.FALSE_ALARM)

    def row(self) -> dict[str, Any]:
        """Row of the table."""
        renamed = {"kind": "class", "limit": "detection_limit"}
        return {renamed.get(name, name): value for name, value in vars(self).items() if name != "limits"}


def rated(
    scene: SceneRuns, trial: Trial, solution: ReferenceSolution, before: CampaignCell | None = None
) -> Case[CampaignCell]:
    """Run a trial, and rate its verdict; where the first runs do not decide it, after those that it asks for besides.

    Parameters
    ----------
    scene : SceneRuns
    trial : Trial
    solution : ReferenceSolution
    before : CampaignCell, optional
        The unmodified engine; needed for a fault.
    """
    runs = yield from scene.runs_of(trial, solution)
    nothing = None if before is None else unjudged(runs)
    if nothing is not None:
        return nothing
    verdict = yield from judged(runs)
    if isinstance(verdict, Verdict) and verdict.further_runs:
        runs = yield from scene.further_runs_of(runs, verdict.further_runs)
        verdict = yield from judged(runs)
    if isinstance(verdict, Verdict):
        return unmodified_cell(runs, verdict) if before is None else fault_cell(runs, verdict, before)
    kind = CellClass.BROKEN if trial.fault else CellClass.FALSE_ALARM  # a mistake in the campaign
    outcome = Outcome.NOTHING_COMPARED if isinstance(verdict, CallLateError) else Outcome.FAILED
    said = f"no verdict: {verdict}"
    return CampaignCell(trial.scene.name, trial.engine, trial.fault, str(outcome), kind, reason=said)


def unjudged(runs: TrialRuns) -> CampaignCell | None:
    """Cell of a fault that changes nothing, or whose runs fail; None where there is something to judge."""
    trial, fault = runs.trial, runs.trial.inserted_fault
    cell = CampaignCell(trial.scene.name, trial.engine, trial.fault, seconds=runs.seconds)
    failed = next((runs.results[role] for role in FIRST if runs.results[role].outcome in UNRUN), None)
    if failed:
        return replace(cell, kind=CellClass.BROKEN, outcome=str(failed.outcome), reason=failed.reason)
    alike = (same(runs.unmodified_trajectory(role), runs.results[role].trajectory) for role in FIRST)
    if fault and not fault.declares and all(alike):
        return replace(cell, reason="it changes nothing there")
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


def unmodified_cell(runs: TrialRuns, verdict: Verdict) -> CampaignCell:
    """Cell of an unmodified engine."""
    outcome = verdict.outcome
    if not outcome.ok:
        late = outcome is Outcome.TIMED_OUT
        return cell_of(runs, verdict, CellClass.LATE if late else CellClass.FALSE_ALARM, *rejection(verdict))
    kinds = dict.fromkeys(UNJUDGED, CellClass.UNSUPPORTED) | {Outcome.ROUNDOFF_LIMITED: CellClass.LIMITED}
    kind = kinds.get(outcome, CellClass.PASS)
    said = next((row["reason"] for row in verdict.rows if row["outcome"] == outcome), "")
    return cell_of(runs, verdict, kind, "", "" if kind is CellClass.PASS else said)


def fault_cell(runs: TrialRuns, verdict: Verdict, before: CampaignCell) -> CampaignCell:
    """Cell of a fault: detected, or smaller or larger than the stated detection limit.

    Where the unmodified engine passes, a fault that is then limited by round-off is detected.
    """
    stated, own = before.limits, limits_of(verdict)
    whole = fault_sizes(runs)
    limited = verdict.outcome is Outcome.ROUNDOFF_LIMITED and before.kind is CellClass.PASS
    if limited or not verdict.outcome.ok or verdict.outcome in UNJUDGED:  # none of these is a pass
        return cell_of(runs, verdict, CellClass.CAUGHT, *rejection(verdict), whole, stated)
    # a fault that differs from run to run makes the engine's error estimate larger, and its own verdict says so
    limits = {name: max(limit, own.get(name, limit), key=lambda each: each.share) for name, limit in stated.items()}
    compared = fault_sizes(runs, stated)
    quantity, excess = worst(limits, compared)
    if excess > 1.0:
        return cell_of(runs, verdict, CellClass.MISSED, quantity, "", compared, stated)
    quantity, excess = worst(limits, whole)
    kind = CellClass.BEYOND if excess > 1.0 else CellClass.BELOW
    return cell_of(runs, verdict, kind, quantity, "", whole, stated)


def rejection(verdict: Verdict) -> tuple[str, str]:
    """Quantity that a verdict rejects, and its first reason."""
    row = next(r for r in verdict.rows if r["outcome"] == verdict.outcome)
    return row["quantity"], row["reason"] or row["metric"]


def cell_of(
    runs: TrialRuns,
    verdict: Verdict,
    kind: CellClass,
    quantity: str,
    reason: str,
    found: Mapping[str, float] = MappingProxyType({}),
    stated: Mapping[str, DetectionLimit] = MappingProxyType({}),
) -> CampaignCell:
    """Cell of a trial: the size of its fault in one quantity, of sizes `found`, and the limits of that."""
    trial, own = runs.trial, limits_of(verdict)
    limit, own_limit = (limits[quantity].share if quantity in limits else None for limits in (stated, own))
    return CampaignCell(
        trial.scene.name, trial.engine, trial.fault, str(verdict.outcome), kind, quantity, reason,
        found.get(quantity), limit, own_limit, runs.seconds, own,
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


def rates(cells: list[CampaignCell]) -> list[dict[str, Any]]:
    """Rates of false alarms and of missed faults, those over everything first: rows of the tables of rates."""
    unmodified = [c for c in cells if not c.fault and c.kind in UNMODIFIED]
    tried = [c for c in cells if c.fault and c.kind in TRIED]
    faulty = [c for c in cells if c.fault and c.kind in (*TRIED, CellClass.BELOW, CellClass.BEYOND)]
    alarms = [c for c in unmodified if c.kind is CellClass.FALSE_ALARM]
    found = [
        rate(kind, ALL, ALL, among) for kind, among in ((CellClass.FALSE_ALARM, unmodified), (CellClass.MISSED, tried))
    ]
    for outcome in dict.fromkeys(c.outcome for c in alarms):
        counted = sum(c.outcome == outcome for c in alarms)
        found.append(rate(CellClass.FALSE_ALARM, "outcome", outcome, unmodified, counted))
    for kind, among, by in (
        (CellClass.FALSE_ALARM, unmodified, "engine"),
        (CellClass.LIMITED, unmodified, "engine"),
        (CellClass.MISSED, tried, "engine"),
        (CellClass.MISSED, tried, "fault"),
        (CellClass.BELOW, faulty, "fault"),
        (CellClass.BEYOND, faulty, "fault"),
    ):
        names = dict.fromkeys(getattr(c, by) for c in among)
        found += [rate(kind, by, name, [c for c in among if getattr(c, by) == name]) for name in names]
    return found


def rate(kind: CellClass, by: str, name: str, among: list[CampaignCell], count: int | None = None) -> dict[str, Any]:
    """Rate of a class of cells, or of so many cells, with Wilson's score interval of 95 %.

    The interval covers its confidence on average, and holds for counts of zero. A rate of nothing is not a number.
    """
    n, counted = len(among), sum(c.kind is kind for c in among) if count is None else count
    low, high = binomtest(counted, n).proportion_ci(CONFIDENCE, method="wilson") if n else (0.0, 1.0)
    said = {"what": str(kind), "by": by, "name": name, "n": n, "count": counted, "why": "" if n else "none tried"}
    return said | {"rate": counted / n if n else math.nan, "low": float(low), "high": float(high)}


def passed(cells: list[CampaignCell]) -> bool:
    """Whether no fault above its detection limit is missed, and false alarms are as rare as they have to be."""
    false, missed = rates(cells)[:2]
    return bool(missed["count"] == 0 and false["count"] <= math.ceil(MOST_FALSE_ALARMS * false["n"]))
