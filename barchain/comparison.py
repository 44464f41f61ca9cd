"""One engine against the truth on one scene: rows of metrics, and differences over time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.engine import ENDED, Observable
from barchain.beyond import beyond_limit
from barchain.checks import TIME_SLACK
from barchain.drift_bands import drift_bands
from barchain.error_model import ErrorModel
from barchain.form import rounded_values
from barchain.job import PERTURBED_ROLES, Role
from barchain.model_difference import com_displacement
from barchain.quantities import differences, drifts
from barchain.relative_energy import BLOWN_UP, kinetic_ratio
from barchain.restart import Stretch, can_restart, stretches
from barchain.roundoff_limit import coarsest_roundoff, measured_roundoff
from barchain.scales import scales
from barchain.tolerances import NORM_SLACK
from barchain.truth import PARTED_RAD, RICHARDSON, TRACK
from reports.outcome import Outcome
from reports.summary import gravest
from reports.tables import QUANTITY_UNITS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.evidence import Evidence
    from barchain.truth import Truth

LEAST_JUDGED = 0.1  # of the run: agreement over less says nothing about the scene
SHRINKS = 0.5  # of the error at the main setting, two settings finer: a method of first order leaves a quarter
HOPELESS = 100.0  # times what is allowed: no slowly converging method is behind that
ASKED = frozenset({"consistency", "band_used", "finer_band_used", "drift"})
"""Metrics that are judged by their tolerance"""
DOUBTED = {Outcome.INCONSISTENT, Outcome.OUT_OF_BAND}
"""Outcomes that round-off or slow convergence may be behind"""
END_SLACK = 1e-6  # of an orbit: a sample meant to be at its end is in it

UNITLESS = frozenset({"consistency", "band_used", "finer_band_used", "detection_limit", "judged_share"})
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
    horizon_s: float | None,
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
        "horizon_s": horizon_s,
    }


def judge(name: str, engine: type[Engine], setting: Setting, evidence: Evidence, truth: Truth) -> Verdict:
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
    scene = truth.scene
    for role, result in (("", evidence.main), (" (at its finer setting)", evidence.finer)):
        if result.outcome is not Outcome.PASS or result.trajectory is None:
            return no_verdict(scene.name, name, setting, result.outcome, result.reason + role)
    try:
        return Comparison(name, engine, setting, evidence, truth).verdict()
    except (ArithmeticError, LookupError, ValueError) as error:
        said = f"could not be compared: {type(error).__name__}: {error}"
        return no_verdict(scene.name, name, setting, Outcome.FAILED, said)


@dataclass(frozen=True)
class ModelDifference:
    """What an engine's model is predicted to leave out of one quantity; n samples, in its unit."""

    size: Array
    """(n,) never falling; added to drawn tolerances"""
    uncertainty: Array
    """(n,) of the prediction; added to the judged ones"""


class Comparison:
    """One engine, one scene: what is needed to judge it, computed once."""

    def __init__(self, name: str, engine: type[Engine], setting: Setting, evidence: Evidence, truth: Truth) -> None:
        assert evidence.main.trajectory is not None
        assert evidence.finer.trajectory is not None
        self.name, self.engine, self.setting, self.truth, self.scene = name, engine, setting, truth, truth.scene
        self.evidence = evidence
        self.main, self.finer = evidence.main.trajectory, evidence.finer.trajectory
        self.errors = ErrorModel(engine, setting, truth, self.main)
        self.n = min(self.errors.n, len(self.finer.t_s))
        self.t = self.main.t_s[: self.n]
        self.horizon_s = self.errors.limit_s
        self.scale = scales(truth)
        self.found = {k: d[: self.n] for k, d in differences(self.main, truth.trajectory).items()}
        self.residual = dict(self.found)
        self.finer_residual = {k: d[: self.n] for k, d in differences(self.finer, truth.trajectory).items()}
        self.model = self.remove_model_difference() if self.com_only else {}
        own = differences(self.main, self.finer)
        self.explained = self.errors.explained(own)
        self.band = self.errors.band
        self.beyond = beyond_limit(truth, self.t, self.horizon_s)
        self.roundoff = measured_roundoff(self.scene, (self.main, *evidence.perturbed)) if evidence.perturbed else {}
        self.drift_band = drift_bands(self.errors, self.main, self.finer)

    @property
    def com_only(self) -> bool:
        """Whether the engine follows the centre of mass as a particle."""
        return Observable.ATTITUDE not in self.engine.observables

    def inside(self, quantity: str) -> NDArray[np.bool_]:
        """Samples at which a quantity is compared, (n,): all for the centre of mass, whose track is not chaotic."""
        return np.ones(self.n, bool) if quantity in TRACK else self.t <= self.horizon_s

    def remove_model_difference(self) -> dict[str, ModelDifference]:
        """Take what the chain's centre of mass is predicted to do besides a particle's motion out of the residuals."""
        predicted = com_displacement(self.scene, self.truth.trajectory)
        return {
            "com": self.removed("com", "com_m", predicted.vector_m, predicted.uncertainty_m),
            "com_velocity": self.removed(
                "com_velocity", "com_velocity_m_s", predicted.vector_m_s, predicted.uncertainty_m_s
            ),
        }

    def removed(self, quantity: str, field: str, predicted: Array, uncertainty: Array) -> ModelDifference:
        """Set the residuals of one quantity to what its prediction leaves of them."""
        n, right = self.n, getattr(self.truth.trajectory, field)
        for residual, run in ((self.residual, self.main), (self.finer_residual, self.finer)):
            apart = right[:n] - getattr(run, field)[:n]
            residual[quantity] = np.linalg.norm(apart - predicted[:n], axis=1)
        size = np.maximum.accumulate(np.linalg.norm(predicted[:n], axis=1))
        return ModelDifference(size, uncertainty[:n])

    def verdict(self) -> Verdict:
        """All rows, the series for plots, and what further runs would settle."""
        early = self.ended_differently() or self.ended_elsewhen() or self.compared_too_little() or self.malformed()
        rows = [] if early is None else [early]
        for quantity in self.found:
            rows += self.pointwise(quantity)
        rows += self.drift_rows() + self.finer_rows()
        if early is None and all(Outcome(r["outcome"]).ok for r in rows):
            rows += self.beyond_rows()
        rows += self.offset_rows()
        rows += [self.share_row(rows)] if early is None else []
        return Verdict(rows, self.series(), self.asks(rows))

    def asks(self, rows: list[Row]) -> tuple[Role, ...]:
        """Further runs that would tell round-off and slow convergence from wrong physics, if they are still to come.

        None where the errors are so far outside that neither could be behind them.
        """
        doubted = [r for r in rows if Outcome(r["outcome"]) in DOUBTED and r["metric"] in ASKED]
        if not doubted or self.com_only:
            return ()
        asked = []
        if self.evidence.finest is None and all(r["value"] <= HOPELESS * r["tolerance"] for r in doubted):
            asked.append(Role.FINEST)
        if not self.evidence.perturbed and all(self.may_be_roundoff(r["quantity"]) for r in doubted):
            asked += PERTURBED_ROLES
        return tuple(asked)

    def may_be_roundoff(self, quantity: str) -> bool:
        """Whether a difference is no larger than round-off can make it in the engine's coordinates."""
        if quantity not in self.residual:
            return True  # drifts of what should stay: rounding is all that there is
        most = coarsest_roundoff(self.errors, quantity)[: self.n] + self.errors.unbounded_floor[quantity]
        allowed = np.maximum(self.tolerance(quantity), self.margin(quantity)) + most
        return worst(self.residual[quantity], allowed, self.inside(quantity))[0] <= 1.0

    def ended_differently(self) -> Row | None:
        """A fault if one of the two stopped at an event that the other does not know."""
        spacing = self.scene.run.duration_s / (self.scene.run.samples - 1)
        apart = abs(len(self.main.t_s) - len(self.truth.trajectory.t_s))
        if apart <= 1 and bool(self.main.ended) == bool(self.truth.trajectory.ended):
            return None
        reason = (
            f"ended {apart * spacing:.3g} s apart from the reference: "
            f"{self.main.ended or 'at its last sample'}; reference: "
            f"{self.truth.trajectory.ended or 'at its last sample'}"
        )
        return self.row("run", "outcome", None, None, Outcome.INCOMPLETE, reason)

    def ended_elsewhen(self) -> Row | None:
        """A fault if both located the instant of their end, and their errors don't explain that it is not the same."""
        mine, theirs = (float(seen.info.get(ENDED, np.nan)) for seen in (self.main, self.truth.trajectory))
        if np.isnan(mine - theirs):
            return None
        apart, allowed = abs(mine - theirs), self.landing_tolerance_s()
        if apart <= allowed:
            return None
        reason = f"ended {apart:.3g} s apart from the reference, {apart / allowed:.3g} times what is explained"
        return self.row("run", "outcome", None, None, Outcome.INCONSISTENT, reason)

    def landing_tolerance_s(self) -> float:
        """What explains a difference of the instants at which a bar reached the surface, s.

        The chain's ends are where they are to the errors of track and attitude at the last sample, and of their rates
        until the next; beyond the predictability limit a bar may point anywhere. That over the speed at which they come
        down, at least the centre of mass' less what they turn with about it. Where that is nothing, the chain grazes
        the surface, and no instant is judged but to a sample.
        """
        seen, size, last = self.truth.trajectory, self.scene.size_m, self.n - 1
        spacing = self.scene.run.duration_s / (self.scene.run.samples - 1)
        if seen.rate_rad_s is None or not {"attitude", "rate"} <= self.found.keys():
            return spacing
        place, velocity = seen.com_m[last], seen.com_velocity_m_s[last]
        turning = float(np.abs(seen.rate_rad_s[last]).max())
        down = -float(place @ velocity) / float(np.linalg.norm(place)) - size * turning
        off = {name: float(self.tolerance(name)[last]) for name in ("com", "com_velocity", "attitude", "rate")}
        if self.t[last] > self.horizon_s:
            off |= {"attitude": 1.0, "rate": turning}
        ends = off["com"] + size * off["attitude"]
        ends += spacing * (off["com_velocity"] + size * (off["rate"] + turning * off["attitude"]))
        return TIME_SLACK * self.scene.run.duration_s + ends / down if down > 0.0 else spacing

    def compared_too_little(self) -> Row | None:
        """A fault if nothing after the start can be compared."""
        if self.com_only or np.count_nonzero(self.t <= self.horizon_s) > 1 or self.n == 1:
            return None
        reason = (
            f"the next sample is beyond what {self.setting} can predict: the expected error of the attitude reaches "
            f"{PARTED_RAD:g} rad before t = {self.t[1]:.4g} s"
        )
        return self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, reason)

    def malformed(self) -> Row | None:
        """A fault if values have a form that no integration gives them."""
        said = rounded_values(self.main)
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
        limit_s = float(self.t[-1]) if quantity in TRACK else self.horizon_s
        return row(
            self.scene.name, self.name, self.setting, quantity, metric, value, tolerance, outcome, reason, limit_s
        )

    def tolerance(self, quantity: str) -> Array:
        """What explains a residual, (n,)."""
        return self.explained[quantity][: self.n] + self.left_out(quantity).uncertainty + self.apart(quantity)

    def margin(self, quantity: str) -> Array:
        """Expected-error bound of a residual, (n,): the engine's, and the reference's own error."""
        bound = self.band[quantity][: self.n] + RICHARDSON * self.truth.error[quantity][: self.n]
        return bound + self.left_out(quantity).uncertainty + self.apart(quantity)

    def apart(self, quantity: str) -> Array:
        """What attitudes that have parted may do to the track beyond the limit, (n,); of all else nothing is judged."""
        return self.beyond.get(quantity, np.zeros(self.n))

    def left_out(self, quantity: str) -> ModelDifference:
        """Declared model difference of a quantity; of most, none."""
        none = np.zeros(self.n)
        return self.model.get(quantity, ModelDifference(none, none))

    def pointwise(self, quantity: str) -> list[Row]:
        """Size of the difference up to the limit, whether it is explained, and whether it is good enough."""
        inside = self.inside(quantity)
        size = self.found[quantity][inside]
        consistency, good = self.checks(quantity)
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
            self.row(quantity, "band_used", good.ratio, 1.0, good.outcome, ""),
            self.row(quantity, "consistency", consistency.ratio, 1.0, consistency.outcome, consistency.words),
        ]

    def checks(self, quantity: str) -> tuple[Check, Check]:
        """Whether a residual is explained, and whether it is inside the expected-error bound.

        Measured round-off counts in both up to what the coordinates' own floor explains (times the slack of bands).
        Beyond that the engine is not right but limited by round-off, and that only as far as coordinates as large as
        the orbit's radius can be.
        """
        inside, residual = self.inside(quantity), self.residual[quantity]
        tolerance, margin = self.tolerance(quantity), self.margin(quantity)
        noise = self.limiting_noise(quantity)
        if self.roundoff:
            granted = np.minimum(self.roundoff[quantity][: self.n], NORM_SLACK * self.errors.floor[quantity][: self.n])
            tolerance, margin = tolerance + granted, margin + granted
        checks = []
        for allowed, verdict, words in (
            (tolerance, Outcome.INCONSISTENT, "what is explained"),
            (margin, Outcome.OUT_OF_BAND, "the expected-error bound"),
        ):
            used, at = worst(residual, allowed, inside)
            if used <= 1.0:
                checks.append(Check(used, Outcome.PASS, ""))
            elif worst(residual, allowed + noise, inside)[0] <= 1.0:
                checks.append(Check(used, Outcome.ROUNDOFF_LIMITED, self.digits_words(quantity, inside)))
            else:
                said = f"{used:.3g} times {words} at t = {self.t[at]:.6g} s"
                checks.append(Check(used, verdict, said + self.convergence_words(quantity)))
        return checks[0], checks[1]

    def limiting_noise(self, quantity: str) -> Array:
        """Noise that may be behind too large an error, (n,): measured, and no more than rounding can make.

        Perturbed runs show it. Where the error does not shrink with the setting, so do the runs at other settings:
        wrong physics is the same at each of them, and noise is not.
        """
        if not self.evidence.perturbed or self.com_only:
            return np.zeros(self.n)
        runs = [self.main, *self.evidence.perturbed]
        if self.errors_by_setting(quantity) and not self.shrinks(quantity):
            runs += [run for run in (self.finer, self.finest) if run is not None]
        noise = measured_roundoff(self.scene, runs)[quantity][: self.n] + self.errors.unbounded_floor[quantity]
        return np.minimum(noise, coarsest_roundoff(self.errors, quantity)[: self.n])

    def digits_words(self, quantity: str, inside: NDArray[np.bool_]) -> str:
        """How many digits round-off leaves of a quantity."""
        noise = float(self.residual[quantity][inside].max())
        left = max(0.0, -math.log10(noise / self.scale[quantity]))
        unit = QUANTITY_UNITS[quantity]
        return f"limited by round-off, which moves it by {noise:.2g} {unit}: {left:.1f} digits are left"

    @property
    def finest(self) -> Trajectory | None:
        """Run at the finest setting, where one was asked for and came."""
        return self.evidence.finest.trajectory if self.evidence.finest else None

    def errors_by_setting(self, quantity: str) -> tuple[float, ...]:
        """Largest errors of a quantity from the coarsest to the finest of three settings; empty without a third one."""
        finest = None if self.finest is None else differences(self.finest, self.truth.trajectory).get(quantity)
        if finest is None or self.com_only:
            return ()
        inside = self.inside(quantity)
        each = (self.residual[quantity], self.finer_residual[quantity], finest[: self.n])
        return tuple(float(r[inside[: len(r)]].max()) for r in each)

    def shrinks(self, quantity: str) -> bool:
        """Whether a quantity's error falls from the first to the last of three settings."""
        sizes = self.errors_by_setting(quantity)
        return sizes[-1] < SHRINKS * sizes[0]

    def convergence_words(self, quantity: str) -> str:
        """Errors at three settings, where the third was asked for: whether they shrink is half of the diagnosis."""
        sizes = self.errors_by_setting(quantity)
        if not sizes:
            return ""
        told = ", ".join(f"{size:.2g}" for size in sizes)
        how = "shrinks" if self.shrinks(quantity) else "does not shrink"
        return f"; the error {how} with the setting: {told} {QUANTITY_UNITS[quantity]} from coarse to fine"

    def detection_limit(self, quantity: str) -> float:
        """Smallest relative error that would have been called at any sample: the worst one's.

        An error that is the same at both settings, and larger than this share of the quantity's scale, is outside a
        tolerance wherever it is, whatever the sign of the error that the engine makes itself.
        """
        inside = self.inside(quantity)
        allowed = np.minimum(self.tolerance(quantity), self.margin(quantity)) + self.residual[quantity]
        return float(allowed[inside].max() / self.scale[quantity])

    def first_orbit(self, quantity: str) -> list[Row]:
        """Largest difference up to one orbit: on a chaotic scene that at the limit says little."""
        early = self.inside(quantity) & (self.t <= self.scene.period_s * (1.0 + END_SLACK))
        if early.sum() == self.n or self.horizon_s < self.scene.period_s * (1.0 - END_SLACK):
            return []
        return [self.row(quantity, "first_orbit", float(self.found[quantity][early].max()), None, Outcome.REPORTED)]

    def drift_rows(self) -> list[Row]:
        """Drifts over the whole run."""
        band = self.drift_band
        rows = []
        for quantity, drift in drifts(self.scene, self.main).items():
            n = min(len(drift), len(band[quantity]))
            allowed = band[quantity][:n]
            if quantity in self.roundoff:  # joints and sums of places: rounding is all that there is
                allowed = allowed + np.minimum(self.roundoff[quantity][:n], NORM_SLACK * allowed)
            used, at = worst(drift[:n], allowed, np.ones(n, bool))
            good = Outcome.PASS if used <= 1.0 else Outcome.OUT_OF_BAND
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
            margin = self.margin(quantity)[: len(residual)] + RICHARDSON * self.errors.floor[quantity][: len(residual)]
            margin = margin + RICHARDSON * self.limiting_noise(quantity)[: len(residual)]
            used, at = worst(residual, margin, inside)
            if used > 1.0:
                reason = f"{used:.3g} times the expected-error bound at t = {self.t[at]:.6g} s at its finer setting"
                rows.append(self.row(quantity, "finer_band_used", used, 1.0, Outcome.OUT_OF_BAND, reason))
        return rows

    def beyond_rows(self) -> list[Row]:
        """Rows on what is judged beyond the predictability limit."""
        first = int(np.count_nonzero(self.t <= self.horizon_s)) - 1
        self.stretches: list[Stretch] = []
        if first >= self.n - 1 or self.com_only:
            return []
        rows = [self.energy_row()]
        for role, run in (("", self.main), (" at its finer setting", self.finer)):
            if not can_restart(run):
                continue
            found = stretches(self.errors, run, first)
            self.stretches = self.stretches or found
            rows += self.stretch_rows(found, role)
        return rows

    def energy_row(self) -> Row:
        """Kinetic energy about the centre of mass over the largest that there can be."""
        unlimited = self.scene.effects.thrust or self.scene.effects.impulse or self.scene.effects.prescribed_rotation
        ratio = None if unlimited else kinetic_ratio(self.main, self.truth)
        if ratio is None:
            return self.row("relative_energy", "drift", None, None, Outcome.REPORTED)
        good = Outcome.PASS if ratio <= BLOWN_UP else Outcome.OUT_OF_BAND
        reason = "" if ratio <= BLOWN_UP else f"{ratio:.3g} times the largest kinetic energy there can be"
        return self.row("relative_energy", "drift", ratio, BLOWN_UP, good, reason)

    def stretch_rows(self, found: list[Stretch], role: str) -> list[Row]:
        """Largest share of its bound that each quantity uses in stretches from the engine's own states."""
        rows = []
        for quantity in found[0].found if found else ():
            each = [
                (*worst(s.found[quantity], s.allowed[quantity], np.ones(len(s.found[quantity]), bool)), s)
                for s in found
            ]
            used, at, stretch = max(each, key=lambda e: e[0])
            good = Outcome.PASS if used <= 1.0 else Outcome.OUT_OF_BAND
            when = self.main.t_s[stretch.first + at]
            reason = (
                ""
                if used <= 1.0
                else (
                    f"{used:.3g} times the expected-error bound at t = {when:.6g} s{role}, compared with the reference "
                    f"restarted from the engine's own state at t = {self.main.t_s[stretch.first]:.6g} s"
                )
            )
            rows.append(self.row(quantity, f"restarted{role.replace(' ', '_')}", used, 1.0, good, reason))
        return rows

    def share_row(self, rows: list[Row]) -> Row:
        """Share of the run that was judged: up to the limit, and in stretches beyond it."""
        last = self.n - 1
        if self.com_only or last == 0:
            return self.row("run", "judged_share", 1.0, None, Outcome.REPORTED)
        judged = self.t <= self.horizon_s
        for s in getattr(self, "stretches", []):
            judged[s.first + 1 : s.last + 1] = True
        share = float(np.count_nonzero(judged[1:]) / last)
        if share >= LEAST_JUDGED or any(not Outcome(r["outcome"]).ok for r in rows):
            return self.row("run", "judged_share", share, LEAST_JUDGED, Outcome.REPORTED)
        reason = f"{share:.0%} of the run could be judged, allowed: {LEAST_JUDGED:.0%} or more"
        return self.row("run", "judged_share", share, LEAST_JUDGED, Outcome.NOTHING_COMPARED, reason)

    def offset_rows(self) -> list[Row]:
        """Errors that do not shrink as the method's order says; see `barchain.form`."""
        return []

    def series(self) -> pd.DataFrame:
        """Differences, tolerances, bands and drifts over time, for plots."""
        columns: dict[str, Array] = {"t_s": self.main.t_s}
        for quantity, found in self.found.items():
            shift = self.left_out(quantity).size
            columns[f"{quantity}_difference"] = padded(found, self.main)
            columns[f"{quantity}_tolerance"] = padded(self.tolerance(quantity) + shift, self.main)
            columns[f"{quantity}_band"] = padded(self.margin(quantity) + shift, self.main)
        allowed = self.drift_band
        for quantity, drift in drifts(self.scene, self.main).items():
            columns[f"{quantity}_drift"] = drift
            columns[f"{quantity}_band"] = padded(allowed[quantity], self.main)
        return pd.DataFrame(columns)


@dataclass(frozen=True)
class Check:
    """What one question asked of a residual found."""

    ratio: float
    """Largest ratio of the residual to what is allowed"""
    outcome: Outcome
    words: str


def padded(values: Array, like: Trajectory) -> Array:
    """`values` with NaN for the samples of `like` beyond them."""
    n = len(like.t_s)
    return np.concatenate([values[:n], np.full(n - min(len(values), n), np.nan)])


def worst(found: Array, allowed: Array, inside: NDArray[np.bool_]) -> tuple[float, int]:
    """Largest ratio of what is found to what is allowed, and where; infinite where nothing is allowed.

    A difference of exactly zero needs no allowance. Not-a-number is never inside.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(found == 0.0, 0.0, found / allowed)
    ratio = np.where(np.isnan(ratio), np.inf, ratio)
    ratio = np.where(inside, ratio, -np.inf)
    at = int(np.argmax(ratio))
    return float(ratio[at]), at
