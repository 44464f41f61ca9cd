"""Verdict on one engine in one scene: rows of metrics, and differences from the judging solution over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from adapters.engine import Coordinates
from barchain.judge.checks.digits import rounded_values
from barchain.judge.checks.run_end import end_event_fault
from barchain.judge.comparison.beyond_limit import BeyondLimit
from barchain.judge.comparison.verdict import JUDGED_METRICS, MIN_JUDGED_SHARE, Verdict, no_verdict
from barchain.judge.declared_noise import too_noisy
from barchain.judge.drift_bounds import drift_bounds, drift_rounding
from barchain.judge.error_model import ErrorModel
from barchain.judge.error_units import NORM_SLACK
from barchain.judge.landing import end_instant_fault
from barchain.judge.residuals import FINEST_NOISE, HALVED_STEP_NOISE, worst
from barchain.metrics.quantities import drifts
from barchain.run.job import ROUNDOFF_ROLES, Role
from reports.tables.crossval import PARTED_RAD, QUANTITY_UNITS, ROUNDING
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.comparison.verdict import Row
    from barchain.judge.evidence import Evidence
    from barchain.solutions.reference import ReferenceSolution

MAX_DOUBTED_RATIO = 100.0
"""Largest ratio of an error to its tolerance that a slowly converging method may cause"""
DOUBTED = {Outcome.INCONSISTENT, Outcome.EXCEEDS_BOUND}
"""Outcomes that round-off or slow convergence may cause"""
END_SLACK = 1e-6
"""Slack of an orbit's end, relative to the orbit: a sample meant to be at its end is in it"""


def judge(
    name: str,
    engine: type[Engine],
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
    engine : type
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
        return Comparison(name, model, evidence).verdict()
    except Exception as error:
        said = f"could not be compared: {type(error).__name__}: {error}"
        return no_verdict(scene.name, name, setting, Outcome.FAILED, said)


class Comparison(BeyondLimit):
    """Rows of the verdict on one engine in one scene."""

    def __init__(self, name: str, errors: ErrorModel, evidence: Evidence) -> None:
        """Prepare the rows of the engine called `name`; the other arguments are those of `Residuals`."""
        super().__init__(name, errors, evidence)
        self.drifts = drifts(self.scene, self.main)
        self.drift_bound = drift_bounds(errors, self.drifts, drifts(self.scene, self.finer))

    def verdict(self) -> Verdict:
        """All rows, the series for plots, and the further runs that would settle the verdict."""
        early = self.early_fault()
        rows = [] if early is None else [early]
        for quantity in self.difference:
            rows += self.pointwise(quantity)
        rows += self.drift_rows() + self.finer_rows()
        if all(Outcome(r["outcome"]).ok for r in rows):  # a setting that is too coarse still answers for its states
            rows += self.rows_beyond_limit()
        rows += self.extrapolation_rows()
        rows += [self.share_row(rows)] if early is None else []
        further = self.further_runs(rows)
        wait = further and self.engine.coordinates is Coordinates.ABSOLUTE  # round-off may turn out to limit the run
        reason = None if wait else self.declared_limitation(rows)
        if reason is not None:
            return no_verdict(self.scene.name, self.name, self.setting, Outcome.UNSUPPORTED, reason)
        return Verdict(rows, self.series(), further)

    def declared_limitation(self, rows: list[Row]) -> str | None:
        """Say why the engine can't be compared, if it declares too much noise and that noise explains all rejections.

        Declared noise is a stated limit of the engine as long as it explains every rejection; it makes no pass.
        """
        rejected = [r for r in rows if not Outcome(r["outcome"]).ok]
        reason = too_noisy(self.errors.declared_noise, self.scale) if rejected else None
        judged = (*JUDGED_METRICS, "max")
        if reason is None or not all(r["metric"] in judged and self.explained_by_noise(r) for r in rejected):
            return None
        return reason

    def explained_by_noise(self, rejected: Row) -> bool:
        """Whether declared noise explains the rejection of a row."""
        quantity, finer = rejected["quantity"], rejected["metric"] == "finer_bound_ratio"
        residual = (self.finer_residual if finer else self.residual).get(quantity)
        if residual is None or rejected["metric"] == "drift":
            return False
        model = self.finer_errors if finer else self.errors
        n = min(self.n, len(residual))
        allowed = np.maximum(self.tolerance[quantity], self.margin[quantity])[:n]
        allowed = allowed + NORM_SLACK * model.unbounded_floor[quantity][:n]
        return worst(residual[:n], allowed, self.inside(quantity)[:n])[0] <= 1.0

    def early_fault(self) -> Row | None:
        """First fault of the run as a whole, or None."""
        for role, run in (("", self.main), (" (at its finer setting)", self.finer)):
            other_end = end_event_fault(run, self.solution)
            if other_end is not None:
                return self.row("run", "outcome", None, None, Outcome.INCOMPLETE, other_end + role)
        other_instant = end_instant_fault(self)
        if other_instant is not None:
            return self.row("run", "outcome", None, None, Outcome.INCONSISTENT, other_instant)
        return self.too_few_samples() or self.malformed()

    def further_runs(self, rows: list[Row]) -> tuple[Role, ...]:
        """Further runs that would tell round-off and slow convergence from wrong physics, if not yet made.

        Empty where the errors are too large for either cause.
        """
        doubted = [r for r in rows if Outcome(r["outcome"]) in DOUBTED and r["metric"] in JUDGED_METRICS]
        absolute = self.engine.coordinates is Coordinates.ABSOLUTE
        if not doubted or self.com_only:
            return ()
        roundoff = all(self.may_be_roundoff(r["quantity"]) for r in doubted)
        if absolute and not roundoff:
            return ()
        further = []
        near = all(r["value"] <= MAX_DOUBTED_RATIO * r["tolerance"] for r in doubted)
        if self.evidence.finest is None and (near or absolute):
            further.append(Role.FINEST)
        if not self.evidence.perturbed and roundoff:
            further += ROUNDOFF_ROLES
        return tuple(further)

    def too_few_samples(self) -> Row | None:
        """Row of a fault if nothing after the start can be compared."""
        if self.com_only or np.count_nonzero(self.t <= self.limit_s) > 1 or len(self.solution.amplification) == 1:
            return None
        reason = (
            f"the next sample is beyond the predictability limit at {self.setting}: the expected-error bound of the "
            f"attitude reaches {PARTED_RAD:g} rad before t = {self.t[1]:.4g} s"
        )
        return self.row("run", "outcome", None, None, Outcome.TOO_COARSE, reason)

    def malformed(self) -> Row | None:
        """Row of a fault if values have a form that no integration gives them."""
        said = rounded_values(self.main, self.solution)
        return None if said is None else self.row("run", "outcome", None, None, Outcome.MALFORMED, said)

    def pointwise(self, quantity: str) -> list[Row]:
        """Rows of a quantity up to the limit: sizes of the difference, normalised error and bound ratio."""
        inside = self.inside(quantity)
        size = self.difference[quantity][inside]
        explained, bounded = self.checks(quantity)
        allowed = float((self.margin[quantity] + self.model_difference(quantity).size)[inside][int(np.argmax(size))])
        reported = {"rms": float(np.sqrt(np.mean(size**2))), "final": float(size[-1])} | self.first_orbit(quantity)
        reported["detection_limit"] = self.detection_limit(quantity)
        reported |= self.rounding(quantity)
        return [
            self.row(quantity, "max", float(size.max()), allowed, bounded.outcome, bounded.reason),
            *(self.row(quantity, name, value, None, Outcome.REPORTED) for name, value in reported.items()),
            self.row(quantity, "bound_ratio", bounded.ratio, 1.0, bounded.outcome),
            self.row(quantity, "normalised_error", explained.ratio, 1.0, explained.outcome, explained.reason),
        ]

    def rounding(self, quantity: str) -> dict[str, float]:
        """Largest share of rounding in the difference, by its metric: two machines' results may differ by twice it."""
        inside, floor = self.inside(quantity), self.errors.floor.get(quantity)
        return {} if floor is None else {ROUNDING: float(floor[: len(inside)][inside].max())}

    def first_orbit(self, quantity: str) -> dict[str, float]:
        """Largest difference up to one orbit, by its metric: on a chaotic scene the one at the limit says little."""
        early = self.inside(quantity) & (self.t <= self.scene.period_s * (1.0 + END_SLACK))
        if early.sum() == self.n or self.limit_s < self.scene.period_s * (1.0 - END_SLACK):
            return {}
        return {"first_orbit_max": float(self.difference[quantity][early].max())}

    def drift_rows(self) -> list[Row]:
        """Drifts over the whole run."""
        bound, rounding = self.drift_bound, drift_rounding(self.errors)
        rows = []
        for quantity, drift in self.drifts.items():
            n = min(len(drift), len(bound[quantity]))
            allowed = bound[quantity][:n]
            if quantity in self.roundoff:  # rounding is all that there is in joints and sums of places
                allowed = allowed + np.minimum(self.roundoff[quantity][:n], NORM_SLACK * allowed)
            used, at = worst(drift[:n], allowed, np.ones(n, bool))
            good = Outcome.PASS if used <= 1.0 else Outcome.EXCEEDS_BOUND
            reason = "" if used <= 1.0 else f"{used:.3g} times the drift's bound at t = {self.main.t_s[at]:.6g} s"
            top = int(np.argmax(drift[:n]))
            rows.append(self.row(quantity, "drift", float(drift[top]), float(allowed[top]), good, reason))
            rows.append(self.row(quantity, ROUNDING, rounding[quantity], None, Outcome.REPORTED))
        return rows

    def finer_rows(self) -> list[Row]:
        """Rows of quantities in which the finer run is outside the main run's bound.

        A finer run that is off in the same way would hide an error of the main run. It takes more steps and may make
        more round-off, which is allowed.
        """
        rows = []
        for quantity, residual in self.finer_residual.items():
            inside = self.inside(quantity)[: len(residual)]
            margin = self.margin[quantity][: len(residual)] + self.finer_floor(quantity)[: len(residual)]
            margin = margin + HALVED_STEP_NOISE * self.limiting_noise(quantity)[: len(residual)]
            margin = margin + self.granted_finer_roundoff(quantity)[: len(residual)]
            used, at = worst(residual, margin, inside)
            if used > 1.0:
                reason = f"{used:.3g} times the expected-error bound at t = {self.t[at]:.6g} s at its finer setting"
                rows.append(self.row(quantity, "finer_bound_ratio", used, 1.0, Outcome.EXCEEDS_BOUND, reason))
        return rows

    def share_row(self, rows: list[Row]) -> Row:
        """Row of the share of the run that was judged: up to the limit, and in segments beyond it."""
        last = len(self.solution.amplification) - 1  # of the judging solution, not of what the engine's runs have
        if self.com_only or last == 0:
            return self.row("run", "judged_share", 1.0, None, Outcome.REPORTED)
        judged = self.t <= self.limit_s
        for s in self.segments:
            judged[s.first + 1 : s.last + 1] = True
        share = float(np.count_nonzero(judged[1:]) / last)
        if share >= MIN_JUDGED_SHARE or any(not Outcome(r["outcome"]).ok for r in rows):
            return self.row("run", "judged_share", share, MIN_JUDGED_SHARE, Outcome.REPORTED)
        reason = f"{share:.0%} of the run can be judged at {self.setting}, required: {MIN_JUDGED_SHARE:.0%}"
        return self.row("run", "judged_share", share, MIN_JUDGED_SHARE, Outcome.TOO_COARSE, reason)

    def extrapolation_rows(self) -> list[Row]:
        """Rows of errors that fall less than the method's order says (`barchain.judge.checks.extrapolation`)."""
        if self.engine.order is None or self.com_only:
            return []
        return [self.extrapolation_row(name) for name in self.extrapolated]

    def extrapolation_row(self, quantity: str) -> Row:
        """Row of a quantity's extrapolation; an error outside its tolerance must be there at a third setting too."""
        size, allowed = self.extrapolated[quantity]
        allowed = allowed + self.granted_roundoff(quantity)[: len(allowed)]
        used, _ = worst(size, allowed, self.inside(quantity)[: len(size)])
        persisting = self.persisting(quantity, ~(size <= allowed), size)
        if not persisting.any():
            said = "" if used <= 1.0 else "an error above 1 at two settings is not there at a third"
            return self.row(quantity, "extrapolation_ratio", used, 1.0, Outcome.PASS, said)
        used, at = worst(size, allowed, persisting)
        noise = FINEST_NOISE * self.limiting_noise(quantity)[: len(allowed)]
        if worst(size, allowed + noise, persisting)[0] <= 1.0:
            left = self.digits_left(quantity, size[persisting], f"{used:.3g} times the allowed")
            return self.row(quantity, "extrapolation_ratio", used, 1.0, Outcome.ROUNDOFF_LIMITED, left)
        unit = QUANTITY_UNITS[quantity]
        reason = (
            f"{size[at]:.2g} {unit} at t = {self.t[at]:.6g} s do not shrink with the step, {used:.3g} times the allowed"
        )
        return self.row(quantity, "extrapolation_ratio", used, 1.0, Outcome.INCONSISTENT, reason)

    def series(self) -> pd.DataFrame:
        """Differences, explained errors, bounds and drifts over time, for plots."""
        columns: dict[str, Array] = {"t_s": self.main.t_s}
        for quantity, difference in self.difference.items():
            shift = self.model_difference(quantity).size
            columns[f"{quantity}_difference"] = padded(difference, self.main)
            columns[f"{quantity}_tolerance"] = padded(self.tolerance[quantity] + shift, self.main)
            columns[f"{quantity}_bound"] = padded(self.margin[quantity] + shift, self.main)
        for quantity, drift in self.drifts.items():
            columns[f"{quantity}_drift"] = drift
            columns[f"{quantity}_bound"] = padded(self.drift_bound[quantity], self.main)
        return pd.DataFrame(columns)


def padded(values: Array, like: Trajectory) -> Array:
    """Extend `values` (k,) to the samples of `like`, with NaN."""
    n = len(like.t_s)
    return np.concatenate([values[:n], np.full(n - min(len(values), n), np.nan)])
