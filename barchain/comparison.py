"""One engine against the truth on one scene: rows of metrics, and differences over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.engine import ENDED, Observable
from barchain.checks import TIME_SLACK
from barchain.drift_bands import drift_bands
from barchain.local_errors import kinks
from barchain.model_difference import com_displacement
from barchain.quantities import differences, drifts
from barchain.tolerances import bands, common_samples, explained, floors
from barchain.truth import RICHARDSON, horizon
from reports.outcome import Outcome
from reports.summary import gravest
from reports.tables import QUANTITY_UNITS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.job import RunResult
    from barchain.truth import Truth

LEAST_COMPARED = 0.1  # of the run: agreement over less says nothing about the scene
END_SLACK = 1e-6  # of an orbit: a sample meant to be at its end is in it

Row = dict[str, Any]


@dataclass(frozen=True)
class Verdict:
    """Outcome of one engine on one scene."""

    rows: list[Row]
    """Rows of the metrics table"""
    series: pd.DataFrame | None = None
    """Differences over time; None where nothing was compared"""

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
    unit = "1" if metric == "consistency" else QUANTITY_UNITS[quantity]
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


def judge(
    name: str, engine: type[Engine], setting: Setting, main: RunResult, finer: RunResult, truth: Truth
) -> Verdict:
    """Compare an engine's run, and its finer one, with the truth.

    Samples that arithmetic fails on cost their engine's verdict, not the run that it is part of.
    """
    scene = truth.scene
    for role, result in (("", main), (" (at its finer setting)", finer)):
        if result.outcome is not Outcome.PASS or result.trajectory is None:
            return no_verdict(scene.name, name, setting, result.outcome, result.reason + role)
    assert main.trajectory is not None
    assert finer.trajectory is not None
    try:
        return Comparison(name, engine, setting, main.trajectory, finer.trajectory, truth).verdict()
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

    def __init__(
        self,
        name: str,
        engine: type[Engine],
        setting: Setting,
        main: Trajectory,
        finer: Trajectory,
        truth: Truth,
    ) -> None:
        self.name, self.engine, self.setting, self.truth, self.scene = (
            name,
            engine,
            setting,
            truth,
            truth.scene,
        )
        self.main, self.finer = main, finer
        self.n = min(common_samples(main, truth), len(finer.t_s))
        self.t = main.t_s[: self.n]
        self.horizon_s = min(horizon(main, finer), truth.horizon_s)
        self.inside = self.t <= self.horizon_s
        self.found = {k: d[: self.n] for k, d in differences(main, truth.trajectory).items()}
        self.residual = dict(self.found)
        self.model = self.remove_model_difference() if self.com_only else {}
        own, floor = differences(main, finer), floors(engine, self.scene, setting, main, truth)
        missed = kinks(engine, self.scene, setting, truth)
        self.explained = explained(engine, own, setting, truth, [floor, missed])
        self.band = {k: b[: self.n] for k, b in bands(engine, self.scene, setting, main, truth).items()}
        self.drift_band = drift_bands(engine, setting, main, finer, truth)

    @property
    def com_only(self) -> bool:
        """Whether the engine follows the centre of mass as a particle."""
        return Observable.ATTITUDE not in self.engine.observables

    def remove_model_difference(self) -> dict[str, ModelDifference]:
        """Take what the chain's centre of mass is predicted to do besides a particle's motion out of the residuals."""
        truth, main, n = self.truth.trajectory, self.main, self.n
        predicted = com_displacement(self.scene, truth)
        return {
            "com": self.removed("com", truth.com_m[:n] - main.com_m[:n], predicted.vector_m, predicted.uncertainty_m),
            "com_velocity": self.removed(
                "com_velocity",
                truth.com_velocity_m_s[:n] - main.com_velocity_m_s[:n],
                predicted.vector_m_s,
                predicted.uncertainty_m_s,
            ),
        }

    def removed(self, quantity: str, apart: Array, predicted: Array, uncertainty: Array) -> ModelDifference:
        """Set the residual of one quantity to what its prediction leaves of it."""
        self.residual[quantity] = np.linalg.norm(apart - predicted[: self.n], axis=1)
        size = np.maximum.accumulate(np.linalg.norm(predicted[: self.n], axis=1))
        return ModelDifference(size, uncertainty[: self.n])

    def verdict(self) -> Verdict:
        """All rows, and the series for plots."""
        early = self.ended_differently() or self.ended_elsewhen() or self.compared_too_little()
        rows = [] if early is None else [early]
        for quantity in self.found:
            rows += self.pointwise(quantity)
        return Verdict(rows + self.drift_rows(), self.series())

    def ended_differently(self) -> Row | None:
        """A fault if one of the two stopped at an event that the other does not know."""
        spacing = self.scene.run.duration_s / (self.scene.run.samples - 1)
        apart = abs(len(self.main.t_s) - len(self.truth.trajectory.t_s))
        if apart <= 1 and bool(self.main.ended) == bool(self.truth.trajectory.ended):
            return None
        reason = (
            f"ended {apart * spacing:.3g} s apart from the truth: "
            f"{self.main.ended or 'at its last sample'}; truth: {self.truth.trajectory.ended or 'at its last sample'}"
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
        reason = f"ended {apart:.3g} s apart from the truth, {apart / allowed:.3g} times what is explained"
        return self.row("run", "outcome", None, None, Outcome.INCONSISTENT, reason)

    def landing_tolerance_s(self) -> float:
        """What explains a difference of the instants at which a bar reached the surface, s.

        The chain's ends are where they are to the errors of track and attitude at the last sample, and of their rates
        until the next. That over the speed at which they come down, at least the centre of mass' less what they turn
        with about it. Where that is nothing, the chain grazes the surface, and no instant is judged.
        """
        seen, size, last = self.truth.trajectory, self.scene.size_m, self.n - 1
        if seen.rate_rad_s is None or not {"attitude", "rate"} <= self.found.keys() or not self.inside[last]:
            return np.inf
        place, velocity = seen.com_m[last], seen.com_velocity_m_s[last]
        turning = float(np.abs(seen.rate_rad_s[last]).max())
        down = -float(place @ velocity) / float(np.linalg.norm(place)) - size * turning
        off = {name: float(self.tolerance(name)[last]) for name in ("com", "com_velocity", "attitude", "rate")}
        spacing = self.scene.run.duration_s / (self.scene.run.samples - 1)
        ends = off["com"] + size * off["attitude"]
        ends += spacing * (off["com_velocity"] + size * (off["rate"] + turning * off["attitude"]))
        return TIME_SLACK * self.scene.run.duration_s + ends / down if down > 0.0 else np.inf

    def compared_too_little(self) -> Row | None:
        """A fault if the horizon leaves next to nothing to compare."""
        if np.count_nonzero(self.inside) > LEAST_COMPARED * self.n:
            return None
        reason = f"two settings of the engine part after {self.horizon_s:.4g} of {self.t[-1]:.4g} s"
        return self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, reason)

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
        return row(
            self.scene.name,
            self.name,
            self.setting,
            quantity,
            metric,
            value,
            tolerance,
            outcome,
            reason,
            self.horizon_s,
        )

    def tolerance(self, quantity: str) -> Array:
        """What explains a residual, (n,)."""
        return self.explained[quantity][: self.n] + self.left_out(quantity).uncertainty

    def left_out(self, quantity: str) -> ModelDifference:
        """Declared model difference of a quantity; of most, none."""
        none = np.zeros(self.n)
        return self.model.get(quantity, ModelDifference(none, none))

    def pointwise(self, quantity: str) -> list[Row]:
        """Size of the difference up to the horizon, whether it is explained, and whether it is good enough."""
        size = self.found[quantity][self.inside]
        ratio, when = worst(self.residual[quantity], self.tolerance(quantity), self.inside)
        model = self.left_out(quantity)
        margin = self.band[quantity] + RICHARDSON * self.truth.error[quantity][: self.n] + model.uncertainty
        used, at = worst(self.residual[quantity], margin, self.inside)
        allowed = margin + model.size
        good = Outcome.PASS if used <= 1.0 else Outcome.OUT_OF_BAND
        agrees = Outcome.PASS if ratio <= 1.0 else Outcome.INCONSISTENT
        return [
            self.row(quantity, "max", float(size.max()), float(allowed[int(np.argmax(size))]), good,
                     "" if used <= 1.0 else f"{used:.3g} times the band at t = {self.t[at]:.6g} s"),
            self.row(quantity, "rms", float(np.sqrt(np.mean(size**2))), None, Outcome.REPORTED),
            self.row(quantity, "final", float(size[-1]), None, Outcome.REPORTED),
            *self.first_orbit(quantity),
            self.row(quantity, "band_used", used, 1.0, good),
            self.row(quantity, "consistency", ratio, 1.0, agrees,
                     "" if ratio <= 1.0 else f"{ratio:.3g} times what is explained at t = {self.t[when]:.6g} s"),
        ]  # fmt: skip

    def first_orbit(self, quantity: str) -> list[Row]:
        """Largest difference up to one orbit: on a chaotic scene that at the horizon says little."""
        early = self.inside & (self.t <= self.scene.period_s * (1.0 + END_SLACK))
        if early.sum() == self.n or self.horizon_s < self.scene.period_s * (1.0 - END_SLACK):
            return []
        return [self.row(quantity, "first_orbit", float(self.found[quantity][early].max()), None, Outcome.REPORTED)]

    def drift_rows(self) -> list[Row]:
        """Drifts over the whole run."""
        band = self.drift_band
        rows = []
        for quantity, drift in drifts(self.scene, self.main).items():
            n = min(len(drift), len(band[quantity]))
            used, at = worst(drift[:n], band[quantity][:n], np.ones(n, bool))
            good = Outcome.PASS if used <= 1.0 else Outcome.OUT_OF_BAND
            reason = "" if used <= 1.0 else f"{used:.3g} times the band at t = {self.main.t_s[at]:.6g} s"
            rows.append(
                self.row(
                    quantity,
                    "drift",
                    float(drift.max()),
                    float(band[quantity][int(np.argmax(drift[:n]))]),
                    good,
                    reason,
                )
            )
        return rows

    def series(self) -> pd.DataFrame:
        """Differences, tolerances, bands and drifts over time, for plots."""
        columns: dict[str, Array] = {"t_s": self.main.t_s}
        for quantity, found in self.found.items():
            shift = self.left_out(quantity).size
            columns[f"{quantity}_difference"] = padded(found, self.main)
            columns[f"{quantity}_tolerance"] = padded(self.tolerance(quantity) + shift, self.main)
            columns[f"{quantity}_band"] = padded(self.band[quantity] + shift, self.main)
        allowed = self.drift_band
        for quantity, drift in drifts(self.scene, self.main).items():
            columns[f"{quantity}_drift"] = drift
            columns[f"{quantity}_band"] = padded(allowed[quantity], self.main)
        return pd.DataFrame(columns)


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
