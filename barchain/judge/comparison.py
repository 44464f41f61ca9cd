"""One engine against the truth on one scene: rows of metrics, and differences over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.engine import Coordinates, EngineError
from barchain.judge.checks.between import OF_A_STATE, wrong_between
from barchain.judge.checks.digits import rounded_values
from barchain.judge.checks.extrapolation import FIELDS
from barchain.judge.checks.relative_energy import BLOWN_UP, kinetic_ratio
from barchain.judge.checks.restart import Stretch, can_restart, stretches
from barchain.judge.declared_noise import too_noisy
from barchain.judge.drift_bounds import drift_bounds
from barchain.judge.landing import ended_elsewhen
from barchain.judge.residuals import FINEST_NOISE, HALVED, Residuals, worst
from barchain.judge.roundoff_limit import coarsest_roundoff
from barchain.judge.run_end import ended_differently
from barchain.judge.tolerances import NORM_SLACK
from barchain.metrics.quantities import drifts
from barchain.run.job import PERTURBED_ROLES, Role
from barchain.solutions.reference import PARTED_RAD, TRACK
from reports.tables.crossval import QUANTITY_UNITS
from reports.tables.outcome import Outcome, gravest

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.evidence import Evidence
    from barchain.solutions.reference import ReferenceSolution

LEAST_JUDGED = 0.1  # of the run: agreement over less says nothing about the scene
MOST_EMPTY = 0.75  # share of the stretches beyond the limit that may predict no sample; in manoeuvres most do not
HOPELESS = 100.0  # times what is allowed: no slowly converging method is behind that
ASKED = frozenset({"normalised_error", "bound_used", "finer_bound_used", "drift", "offset_used"})
"""Metrics that are judged by their tolerance"""
OF_TWO_SETTINGS = frozenset({"offset_used", "finer_bound_used"})
"""Metrics that need the second run to be the finer one"""
DOUBTED = {Outcome.INCONSISTENT, Outcome.EXCEEDS_BOUND}
"""Outcomes that round-off or slow convergence may be behind"""
END_SLACK = 1e-6  # of an orbit: a sample meant to be at its end is in it

UNITLESS = frozenset(
    {"normalised_error", "bound_used", "finer_bound_used", "detection_limit", "judged_share", "offset_used", "between"}
)
"""Metrics that are ratios, whatever their quantity's unit"""

Row = dict[str, Any]


@dataclass(frozen=True)
class Verdict:
    """Outcome of one engine on one scene."""

    rows: list[Row]
    """Rows of the metrics table"""
    series: pd.DataFrame | None = None
    """Differences over time; None where nothing was compared"""
    asks: tuple[Role, ...] = ()
    """Roles of further runs that would settle an outcome; none where it is settled"""

    @property
    def outcome(self) -> Outcome:
        """Gravest outcome of all rows."""
        return gravest(Outcome(row["outcome"]) for row in self.rows)


def no_verdict(scene: str, engine: str, setting: Setting | None, outcome: Outcome, reason: str) -> Verdict:
    """One row for a whole run that gave nothing to compare."""
    return Verdict([row(scene, engine, setting, "run", "outcome", None, None, outcome, reason, None)])


def row(
    scene: str,
    engine: str,
    setting: Setting | None,
    quantity: str,
    metric: str,
    value: float | None,
    tolerance: float | None,
    outcome: Outcome,
    reason: str,
    limit_s: float | None,
) -> Row:
    """One row of the metrics table."""
    unit = "1" if metric in UNITLESS else QUANTITY_UNITS[quantity]
    return {
        "scene": scene,
        "engine": engine,
        "setting": "" if setting is None else str(setting),
        "quantity": quantity,
        "metric": metric,
        "value": value,
        "unit": unit,
        "tolerance": tolerance,
        "outcome": str(outcome),
        "reason": reason,
        "limit_s": limit_s,
    }


def judge(
    name: str, engine: type[Engine], setting: Setting, evidence: Evidence, solution: ReferenceSolution
) -> Verdict:
    """Compare an engine's runs with the reference solution.

    Samples that arithmetic fails on cost their engine's verdict, not the run that it is part of. Where the evidence
    does not settle the verdict, it names the further runs that would (:attr:`Verdict.asks`).

    Parameters
    ----------
    name : str
        Of the engine.
    engine : type
    setting : Setting
        Of the main run.
    evidence : Evidence
    truth : Truth

    Returns
    -------
    Verdict
    """
    scene = solution.scene
    for role, result in (("", evidence.main), (" (at its finer setting)", evidence.finer)):
        if result.outcome is not Outcome.PASS or result.trajectory is None:
            return no_verdict(scene.name, name, setting, result.outcome, result.reason + role)
    try:
        return Comparison(name, engine, setting, evidence, solution).verdict()
    except Exception as error:
        said = f"could not be compared: {type(error).__name__}: {error}"
        return no_verdict(scene.name, name, setting, Outcome.FAILED, said)


class Comparison(Residuals):
    """Rows of the verdict on one engine in one scene."""

    def __init__(
        self, name: str, engine: type[Engine], setting: Setting, evidence: Evidence, solution: ReferenceSolution
    ) -> None:
        super().__init__(engine, setting, evidence, solution)
        self.name = name
        self.drift_bound = drift_bounds(self.errors, self.main, self.finer)
        self.stretches: list[Stretch] = []

    def verdict(self) -> Verdict:
        """All rows, the series for plots, and what further runs would settle."""
        early = self.early_fault()
        rows = [] if early is None else [early]
        for quantity in self.found:
            rows += self.pointwise(quantity)
        rows += self.drift_rows() + self.finer_rows()
        if early is None and all(Outcome(r["outcome"]).ok for r in rows):
            rows += self.beyond_rows()
        rows += self.offset_rows()
        rows += [self.share_row(rows)] if early is None else []
        asks = self.asks(rows)
        wait = asks and self.engine.coordinates is Coordinates.ABSOLUTE  # which may turn out limited by round-off
        declined = None if wait else self.declined(rows)
        if declined is not None:
            return no_verdict(self.scene.name, self.name, self.setting, Outcome.UNSUPPORTED, declined)
        return Verdict(rows, self.series(), asks)

    def declined(self, rows: list[Row]) -> str | None:
        """Why the engine can't be compared by its own account: it declares too much noise, and that explains all.

        Noise that is declared is a stated limit of the engine as long as it is behind every refusal; it makes no pass.
        """
        rejected = [r for r in rows if not Outcome(r["outcome"]).ok]
        said = too_noisy(self.errors.declared_noise, self.solution) if rejected else None
        if said is None or not all(r["metric"] in (*ASKED, "max") and self.is_noise(r) for r in rejected):
            return None
        return said

    def is_noise(self, rejected: Row) -> bool:
        """Whether declared noise explains what a row refuses."""
        quantity, finer = rejected["quantity"], rejected["metric"] == "finer_bound_used"
        found = (self.finer_residual if finer else self.residual).get(quantity)
        if found is None or rejected["metric"] == "drift":
            return False
        model = self.finer_errors if finer else self.errors
        n = min(self.n, len(found))
        allowed = np.maximum(self.tolerance(quantity), self.margin(quantity))[:n]
        allowed = allowed + NORM_SLACK * model.unbounded_floor[quantity][:n]
        return worst(found[:n], allowed, self.inside(quantity)[:n])[0] <= 1.0

    def early_fault(self) -> Row | None:
        """First thing that speaks against the run as a whole."""
        for role, run in (("", self.main), (" (at its finer setting)", self.finer)):
            other_end = ended_differently(run, self.solution)
            if other_end is not None:
                return self.row("run", "outcome", None, None, Outcome.INCOMPLETE, other_end + role)
        other_instant = ended_elsewhen(self)
        if other_instant is not None:
            return self.row("run", "outcome", None, None, Outcome.INCONSISTENT, other_instant)
        return self.compared_too_little() or self.malformed()

    def asks(self, rows: list[Row]) -> tuple[Role, ...]:
        """Further runs that would tell round-off and slow convergence from wrong physics, if they are still to come.

        None where the errors are so far outside that neither could be behind them.
        """
        doubted = [r for r in rows if Outcome(r["outcome"]) in DOUBTED and r["metric"] in ASKED]
        absolute = self.engine.coordinates is Coordinates.ABSOLUTE
        if not doubted or self.com_only or (absolute and not all(self.may_be_roundoff(r["quantity"]) for r in doubted)):
            return ()
        asked = []
        near = all(r["value"] <= HOPELESS * r["tolerance"] for r in doubted)
        if self.evidence.finest is None and (near or absolute):
            asked.append(Role.FINEST)
        if not self.evidence.perturbed and all(self.may_be_roundoff(r["quantity"]) for r in doubted):
            asked += PERTURBED_ROLES
        return tuple(asked)

    def compared_too_little(self) -> Row | None:
        """A fault if nothing after the start can be compared."""
        if self.com_only or np.count_nonzero(self.t <= self.limit_s) > 1 or len(self.solution.amplification) == 1:
            return None
        reason = (
            f"the next sample is beyond what {self.setting} can predict: the expected error of the attitude reaches "
            f"{PARTED_RAD:g} rad before t = {self.t[1]:.4g} s"
        )
        return self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, reason)

    def malformed(self) -> Row | None:
        """A fault if values have a form that no integration gives them."""
        said = rounded_values(self.main, self.solution)
        return None if said is None else self.row("run", "outcome", None, None, Outcome.MALFORMED, said)

    def row(
        self,
        quantity: str,
        metric: str,
        value: float | None,
        tolerance: float | None,
        outcome: Outcome,
        reason: str = "",
    ) -> Row:
        """One row of the metrics table for this engine and scene."""
        limit_s = float(self.t[-1]) if quantity in TRACK else self.limit_s
        return row(
            self.scene.name, self.name, self.setting, quantity, metric, value, tolerance, outcome, reason, limit_s
        )

    def pointwise(self, quantity: str) -> list[Row]:
        """Size of the difference up to the limit, whether it is explained, and whether it is good enough."""
        inside = self.inside(quantity)
        size = self.found[quantity][inside]
        normalised_error, good = self.checks(quantity)
        model = self.left_out(quantity)
        allowed = self.margin(quantity)[inside] + model.size[inside]
        return [
            self.row(
                quantity, "max", float(size.max()), float(allowed[int(np.argmax(size))]), good.outcome, good.words
            ),
            self.row(quantity, "rms", float(np.sqrt(np.mean(size**2))), None, Outcome.REPORTED),
            self.row(quantity, "final", float(size[-1]), None, Outcome.REPORTED),
            *self.first_orbit(quantity),
            self.row(quantity, "detection_limit", self.detection_limit(quantity), None, Outcome.REPORTED),
            self.row(quantity, "bound_used", good.ratio, 1.0, good.outcome, ""),
            self.row(
                quantity,
                "normalised_error",
                normalised_error.ratio,
                1.0,
                normalised_error.outcome,
                normalised_error.words,
            ),
        ]

    def first_orbit(self, quantity: str) -> list[Row]:
        """Largest difference up to one orbit: on a chaotic scene that at the limit says little."""
        early = self.inside(quantity) & (self.t <= self.scene.period_s * (1.0 + END_SLACK))
        if early.sum() == self.n or self.limit_s < self.scene.period_s * (1.0 - END_SLACK):
            return []
        return [self.row(quantity, "first_orbit", float(self.found[quantity][early].max()), None, Outcome.REPORTED)]

    def drift_rows(self) -> list[Row]:
        """Drifts over the whole run."""
        bound = self.drift_bound
        rows = []
        for quantity, drift in drifts(self.scene, self.main).items():
            n = min(len(drift), len(bound[quantity]))
            allowed = bound[quantity][:n]
            if quantity in self.roundoff:  # joints and sums of places: rounding is all that there is
                allowed = allowed + np.minimum(self.roundoff[quantity][:n], NORM_SLACK * allowed)
            used, at = worst(drift[:n], allowed, np.ones(n, bool))
            good = Outcome.PASS if used <= 1.0 else Outcome.EXCEEDS_BOUND
            reason = "" if used <= 1.0 else f"{used:.3g} times the band at t = {self.main.t_s[at]:.6g} s"
            top = int(np.argmax(drift[:n]))
            rows.append(self.row(quantity, "drift", float(drift[top]), float(allowed[top]), good, reason))
        return rows

    def finer_rows(self) -> list[Row]:
        """Whether the finer run is inside the main one's bounds: it may not part, and so hide, what the main run does.

        The finer run takes more steps and so may make more round-off than the main one.
        """
        rows = []
        for quantity, residual in self.finer_residual.items():
            inside = self.inside(quantity)[: len(residual)]
            margin = self.margin(quantity)[: len(residual)] + self.finer_floor(quantity)[: len(residual)]
            margin = margin + HALVED * self.limiting_noise(quantity)[: len(residual)]
            margin = margin + self.granted_finer(quantity)[: len(residual)]
            used, at = worst(residual, margin, inside)
            if used > 1.0:
                reason = f"{used:.3g} times the expected-error bound at t = {self.t[at]:.6g} s at its finer setting"
                rows.append(self.row(quantity, "finer_bound_used", used, 1.0, Outcome.EXCEEDS_BOUND, reason))
        return rows

    def beyond_rows(self) -> list[Row]:
        """Rows on what is judged beyond the predictability limit."""
        first = int(np.count_nonzero(self.t <= self.limit_s)) - 1
        if first >= self.n - 1 or self.com_only:
            return []
        rows = [self.energy_row()]
        if not can_restart(self.main):
            said = f"no rates: nothing can be judged beyond the predictability limit, {self.limit_s:.4g} s"
            return [*rows, self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, said)]
        try:
            self.stretches = stretches(self.errors, self.main, first)
        except (EngineError, ArithmeticError) as error:
            said = f"the reference can't be restarted from the engine's states: {error}"
            return [*rows, self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, said)]
        rows += self.stretch_rows(self.stretches) + self.empty_rows(self.stretches)
        return rows + (self.between_rows(first) if all(Outcome(r["outcome"]).ok for r in rows) else [])

    def between_rows(self, first: int) -> list[Row]:
        """A fault if samples that no stretch covers contradict themselves or each other (`barchain.between`)."""
        seen = (self.errors, self.main, self.stretches, first)
        wrong = wrong_between(*seen, room={})
        if wrong is None:
            return []
        quantity, used, said = wrong
        good = Outcome.EXCEEDS_BOUND
        if self.engine.coordinates is Coordinates.ABSOLUTE:
            alone = np.ones(self.errors.n)  # nothing grows in a state by itself
            room = {quantity: coarsest_roundoff(self.errors, quantity, alone) for quantity in OF_A_STATE}
            good = Outcome.EXCEEDS_BOUND if wrong_between(*seen, room=room) else Outcome.ROUNDOFF_LIMITED
        return [self.row(quantity, "between", used, 1.0, good, said)]

    def empty_rows(self, found: list[Stretch]) -> list[Row]:
        """A fault if most stretches could predict nothing: then what the engine gives says nothing of its motion."""
        empty = sum(s.empty for s in found)
        if not found or empty <= MOST_EMPTY * len(found):
            return []
        said = (
            f"beyond the predictability limit, {self.limit_s:.4g} s, {empty} of {len(found)} stretches can't predict "
            "the next sample: the rates are too uncertain"
        )
        return [self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, said)]

    def energy_row(self) -> Row:
        """Kinetic energy about the centre of mass over the largest that there can be."""
        unlimited = self.scene.effects.thrust or self.scene.effects.impulse or self.scene.effects.prescribed_rotation
        each = [] if unlimited else [kinetic_ratio(run, self.solution) for run in (self.main, self.finer)]
        ratio = max((r for r in each if r is not None), default=None)
        if ratio is None:
            return self.row("relative_energy", "drift", None, None, Outcome.REPORTED)
        good = Outcome.PASS if ratio <= BLOWN_UP else Outcome.EXCEEDS_BOUND
        reason = "" if ratio <= BLOWN_UP else f"{ratio:.3g} times the largest kinetic energy there can be"
        return self.row("relative_energy", "drift", ratio, BLOWN_UP, good, reason)

    def stretch_rows(self, found: list[Stretch]) -> list[Row]:
        """Largest share of its bound that each quantity uses in stretches from the engine's own states."""
        rows = []
        for quantity in found[0].found if found else ():
            each = [(*worst(s.found[quantity], s.allowed[quantity], s.everywhere), s) for s in found]
            used, at, stretch = max(each, key=lambda e: e[0])
            good = Outcome.PASS if used <= 1.0 else self.out_of_stretch(quantity, found)
            when, start = (self.main.t_s[k] for k in (stretch.first + at, stretch.first))
            reason = (
                f"{used:.3g} times the expected-error bound at t = {when:.6g} s, compared with the reference "
                f"restarted from the engine's own state at t = {start:.6g} s"
            )
            rows.append(self.row(quantity, "restarted", used, 1.0, good, "" if used <= 1.0 else reason))
        return rows

    def out_of_stretch(self, quantity: str, found: list[Stretch]) -> Outcome:
        """Outcome of a quantity that is outside in a stretch: rounding of absolute coordinates is no fault."""
        if self.engine.coordinates is not Coordinates.ABSOLUTE:
            return Outcome.EXCEEDS_BOUND
        for s in found:
            since = self.errors.amplification / self.errors.amplification[s.first]
            most = coarsest_roundoff(self.errors, quantity, since)[s.first : s.last + 1]
            if not np.all(s.found[quantity] <= s.allowed[quantity] + most):
                return Outcome.EXCEEDS_BOUND
        return Outcome.ROUNDOFF_LIMITED

    def share_row(self, rows: list[Row]) -> Row:
        """Share of the run that was judged: up to the limit, and in stretches beyond it."""
        last = len(self.solution.amplification) - 1  # of the reference solution, not of what the engine's runs have
        if self.com_only or last == 0:
            return self.row("run", "judged_share", 1.0, None, Outcome.REPORTED)
        judged = self.t <= self.limit_s
        for s in self.stretches:
            judged[s.first + 1 : s.last + 1] = True
        share = float(np.count_nonzero(judged[1:]) / last)
        if share >= LEAST_JUDGED or any(not Outcome(r["outcome"]).ok for r in rows):
            return self.row("run", "judged_share", share, LEAST_JUDGED, Outcome.REPORTED)
        reason = f"{share:.0%} of the run could be judged, allowed: {LEAST_JUDGED:.0%} or more"
        return self.row("run", "judged_share", share, LEAST_JUDGED, Outcome.NOTHING_COMPARED, reason)

    def offset_rows(self) -> list[Row]:
        """Errors that do not fall as the method's order says (`barchain.judge.checks.extrapolation`)."""
        if self.engine.order is None or self.com_only:
            return []
        return [self.offset_row(name) for name in FIELDS if name in self.found and name in self.errors.floor]

    def offset_row(self, quantity: str) -> Row:
        """Whether the extrapolation of a quantity is right; where not, a third setting must confirm it."""
        inside = self.inside(quantity)
        size, allowed = self.offset(quantity, self.main, self.finer)
        allowed = allowed + self.granted(quantity)[: len(allowed)]
        used, at = worst(size, allowed, inside[: len(size)])
        if used <= 1.0 or not self.stays(quantity, size > allowed, size):
            return self.row(quantity, "offset_used", used, 1.0, Outcome.PASS)
        noise = FINEST_NOISE * self.limiting_noise(quantity)[: len(allowed)]
        if worst(size, allowed + noise, inside[: len(size)])[0] <= 1.0:
            return self.row(
                quantity, "offset_used", used, 1.0, Outcome.ROUNDOFF_LIMITED, self.digits_words(quantity, inside)
            )
        unit = QUANTITY_UNITS[quantity]
        reason = (
            f"{size[at]:.2g} {unit} at t = {self.t[at]:.6g} s do not shrink with the step, {used:.3g} times the allowed"
        )
        return self.row(quantity, "offset_used", used, 1.0, Outcome.INCONSISTENT, reason)

    def series(self) -> pd.DataFrame:
        """Differences, tolerances, bands and drifts over time, for plots."""
        columns: dict[str, Array] = {"t_s": self.main.t_s}
        for quantity, found in self.found.items():
            shift = self.left_out(quantity).size
            columns[f"{quantity}_difference"] = padded(found, self.main)
            columns[f"{quantity}_tolerance"] = padded(self.tolerance(quantity) + shift, self.main)
            columns[f"{quantity}_bound"] = padded(self.margin(quantity) + shift, self.main)
        allowed = self.drift_bound
        for quantity, drift in drifts(self.scene, self.main).items():
            columns[f"{quantity}_drift"] = drift
            columns[f"{quantity}_bound"] = padded(allowed[quantity], self.main)
        return pd.DataFrame(columns)


def padded(values: Array, like: Trajectory) -> Array:
    """`values` with NaN for the samples of `like` beyond them."""
    n = len(like.t_s)
    return np.concatenate([values[:n], np.full(n - min(len(values), n), np.nan)])
