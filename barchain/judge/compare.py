"""Comparison of one engine with the judging solution of one scene: all checks, and the verdict of their findings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from barchain.judge.checks.beyond_limit import findings_beyond_limit
from barchain.judge.checks.drifts import ABOUT_COM, WHOLE, carried, drift_bounds, drift_findings
from barchain.judge.checks.more_judged import until_share
from barchain.judge.checks.up_to_limit import difference_findings, extrapolation_finding, finer_findings
from barchain.judge.checks.whole_run import fault_of_run
from barchain.judge.error_model import ErrorModel
from barchain.judge.residuals import Residuals, worst
from barchain.judge.scales import NORM_SLACK, too_noisy
from barchain.judge.verdict import JUDGED_METRICS, MIN_JUDGED_SHARE, CheckFinding, Verdict, no_verdict
from barchain.metrics.quantities import TRACK
from barchain.runs.job import ROUNDOFF_ROLES, Role
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array
    from barchain.judge.checks.restart import RestartSegment
    from barchain.judge.evidence import Evidence
    from barchain.solutions.reference import ReferenceSolution

MAX_DOUBTED_RATIO = 100.0
"""Largest ratio of an error to its tolerance that a slowly converging method may cause"""
DRIFTING = ("attitude", "rate", "com")
"""Quantities whose errors show in energy and angular momentum"""
DOUBTED = {Outcome.INCONSISTENT, Outcome.EXCEEDS_BOUND}
"""Outcomes that round-off or slow convergence may cause"""


def judge(
    name: str,
    engine: Declarations,
    setting: Setting,
    evidence: Evidence,
    solution: ReferenceSolution,
    errors: ErrorModel | None = None,
) -> Verdict:
    """Compare an engine's runs with the judging solution.

    Samples that arithmetic fails on cost their engine's verdict, not the comparison of all engines. Where the evidence
    does not settle the verdict, it names the runs that would (:attr:`Verdict.further_runs`).

    Parameters
    ----------
    name : str
        Of the engine.
    engine : Declarations
    setting : Setting
        Of the main run.
    evidence : Evidence
    solution : ReferenceSolution
    errors : ErrorModel, optional
        Of the engine at this setting for its main run, if already built.

    Returns
    -------
    Verdict
    """
    scene = solution.scene
    for role, result in (("", evidence.main), (" (at its finer setting)", evidence.finer)):
        if result.outcome is not Outcome.PASS or result.trajectory is None:
            return no_verdict(scene.name, name, setting, result.outcome, result.reason + role)
    assert evidence.main.trajectory is not None
    try:
        model = errors or ErrorModel(engine, setting, solution, evidence.main.trajectory)
        return verdict_on(name, Residuals(model, evidence))
    except Exception as error:
        said = f"could not be compared: {type(error).__name__}: {error}"
        return no_verdict(scene.name, name, setting, Outcome.FAILED, said)


def verdict_on(name: str, run: Residuals) -> Verdict:
    """Verdict on the engine called `name`: all findings, the series for plots, further runs that would settle it."""
    drift = run.drifts(run.main)
    bound = drift_bounds(run.errors, drift, run.drifts(run.finer))
    segments: list[RestartSegment] = []
    fault = fault_of_run(run)
    found = [] if fault is None else [fault]
    for quantity in run.difference:
        found += difference_findings(run, quantity)
    found += drift_findings(run, drift, bound) + finer_findings(run)
    if run.restarts and all(f.outcome.ok for f in found):  # a setting that is too coarse still answers for its states
        beyond, segments = findings_beyond_limit(run)
        told = {(f.quantity, f.metric) for f in found}
        found += [f for f in beyond if (f.quantity, f.metric) not in told]
    found += [extrapolation_finding(run, quantity) for quantity in run.extrapolated]
    if fault is None:
        found.append(judged_share(run, segments, found))
    further = further_runs(run, found)
    wait = further and run.engine.coordinates.absolute  # round-off may turn out to limit the run
    reason = None if wait else declared_limitation(run, found)
    if reason is not None:
        return no_verdict(run.scene.name, name, run.setting, Outcome.UNSUPPORTED, reason)
    end_s = float(run.t[-1])
    limits_s = [end_s if run.com_only or f.quantity in TRACK else run.limit_s for f in found]
    rows = [f.row(run.scene.name, name, run.setting, s) for f, s in zip(found, limits_s, strict=True)]
    return Verdict(rows, series(run, drift, bound), further)


def judged_share(run: Residuals, segments: list[RestartSegment], found: list[CheckFinding]) -> CheckFinding:
    """Share of the run that was judged: up to the limit, and in segments beyond it."""
    last = len(run.solution.amplification) - 1  # of the judging solution, not of what the engine's runs have
    if run.com_only or last == 0:
        return CheckFinding("run", "judged_share", 1.0)
    judged = run.t <= run.limit_s
    for s in segments:
        judged[s.first + 1 : s.last + 1] = True
    share = float(np.count_nonzero(judged[1:]) / last)
    if share >= MIN_JUDGED_SHARE or any(not f.outcome.ok for f in found):
        return CheckFinding("run", "judged_share", share, MIN_JUDGED_SHARE)
    advice = until_share(run.errors, run.limit_s, share, MIN_JUDGED_SHARE)
    reason = f"{share:.0%} of the run can be judged at {run.setting}, required: {MIN_JUDGED_SHARE:.0%}{advice}"
    return CheckFinding("run", "judged_share", share, MIN_JUDGED_SHARE, Outcome.TOO_COARSE, reason)


def further_runs(run: Residuals, found: list[CheckFinding]) -> tuple[Role, ...]:
    """Further runs that would tell round-off and slow convergence from wrong physics, if not yet made.

    Empty where the errors are too large for either cause.
    """
    doubted = [f for f in found if f.outcome in DOUBTED and f.metric in JUDGED_METRICS]
    absolute = run.engine.coordinates.absolute
    if not doubted or run.com_only:
        return ()
    roundoff = all(may_be_roundoff(run, f.quantity) for f in doubted)
    if absolute and not roundoff:
        return ()
    further: list[Role] = []
    near = all((f.value or 0.0) <= MAX_DOUBTED_RATIO * (f.tolerance or 0.0) for f in doubted)
    if run.evidence.finest is None and (near or absolute):
        further.append(Role.FINEST)
    if not run.evidence.perturbed and roundoff:
        further += ROUNDOFF_ROLES
    return tuple(further)


def may_be_roundoff(run: Residuals, quantity: str) -> bool:
    """Whether a difference is no larger than round-off can make it in the engine's coordinates."""
    if quantity not in run.residual:
        return True  # drifts of conserved quantities: rounding is all that there is
    most = run.max_roundoff[quantity] + run.errors.unbounded_floor[quantity]
    return explained_besides(run, quantity, run.residual[quantity], most)


def declared_limitation(run: Residuals, found: list[CheckFinding]) -> str | None:
    """Say why the engine can't be compared, if it declares too much noise and that noise explains all rejections.

    Declared noise is a stated limit of the engine as long as it explains every rejection; it makes no pass.
    """
    rejected = [f for f in found if not f.outcome.ok] if run.errors.noise_is_bounded else []
    reason = too_noisy(run.errors.declared_noise, run.scale) if rejected else None
    return reason if reason is not None and all(noise_explains(run, f) for f in rejected) else None


def noise_explains(run: Residuals, rejected: CheckFinding) -> bool:
    """Whether declared noise explains the rejection of a difference."""
    quantity, finer = rejected.quantity, rejected.metric == "finer_bound_ratio"
    if quantity in (*WHOLE, *ABOUT_COM):
        assert rejected.value is not None
        assert rejected.tolerance is not None
        return rejected.value <= rejected.tolerance + noisy_drift(run, quantity)
    residual = (run.finer_residual if finer else run.residual).get(quantity)
    if residual is None or rejected.metric not in (JUDGED_METRICS | {"max"}) - {"drift"}:
        return False
    floor = (run.finer_errors if finer else run.errors).unbounded_floor[quantity]
    return explained_besides(run, quantity, residual, NORM_SLACK * floor)


def noisy_drift(run: Residuals, name: str) -> float:
    """Largest drift of an invariant by declared noise, relative.

    Noise of samples is no drift. Noise of states is: round-off in the engine's coordinates bounds its size.
    """
    floor = run.errors.unbounded_floor
    noise = {q: np.minimum(NORM_SLACK * floor[q], run.max_roundoff[q]) for q in DRIFTING}
    return float(carried(run.errors, name, noise).max())


def explained_besides(run: Residuals, quantity: str, residual: Array, noise: Array) -> bool:
    """Whether `noise` besides the larger of both tolerances of a quantity explains a residual, each (n,)."""
    n = min(run.n, len(residual))
    allowed = np.maximum(run.tolerance[quantity], run.margin[quantity])[:n] + noise[:n]
    return worst(residual[:n], allowed, run.inside(quantity)[:n])[0] <= 1.0


def series(run: Residuals, drift: dict[str, Array], drift_bound: dict[str, Array]) -> pd.DataFrame:
    """Differences, explained errors, bounds and drifts over time, for plots; NaN beyond the last compared sample."""
    n = len(run.main.t_s)

    def padded(values: Array) -> Array:
        return np.concatenate([values[:n], np.full(n - min(len(values), n), np.nan)])

    columns: dict[str, Array] = {"t_s": run.main.t_s}
    for quantity, difference in run.difference.items():
        shift = run.model_size.get(quantity, 0.0)
        columns[f"{quantity}_difference"] = padded(difference)
        columns[f"{quantity}_tolerance"] = padded(run.tolerance[quantity] + shift)
        columns[f"{quantity}_bound"] = padded(run.margin[quantity] + shift)
    for quantity, values in drift.items():
        columns[f"{quantity}_drift"] = values
        columns[f"{quantity}_bound"] = padded(drift_bound[quantity])
    return pd.DataFrame(columns)
