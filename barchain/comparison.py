"""One engine against the truth on one scene: rows of metrics, and differences over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from adapters.engine import Observable
from barchain.drift_bands import drift_bands
from barchain.local_errors import kinks
from barchain.model_difference import com_displacement
from barchain.quantities import differences, drifts
from barchain.tolerances import bands, common_samples, explained, floors
from barchain.truth import horizon
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
    """Compare an engine's run, and its finer one, with the truth."""
    scene = truth.scene
    for role, result in (("", main), (" (at its finer setting)", finer)):
        if result.outcome is not Outcome.PASS or result.trajectory is None:
            return no_verdict(scene.name, name, setting, result.outcome, result.reason + role)
    assert main.trajectory is not None
    assert finer.trajectory is not None
    return Comparison(name, engine, setting, main.trajectory, finer.trajectory, truth).verdict()


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
        model = self.remove_model_difference() if self.com_only else {}
        own, floor = differences(main, finer), floors(engine, self.scene, setting, main, truth)
        missed = kinks(engine, self.scene, setting, truth)
        self.model = model
        self.explained = explained(own, setting, truth, [floor, missed])
        self.band = {k: b[: self.n] for k, b in bands(engine, self.scene, setting, main, truth).items()}

    @property
    def com_only(self) -> bool:
        """Whether the engine follows the centre of mass as a particle."""
        return Observable.ATTITUDE not in self.engine.observables

    def remove_model_difference(self) -> dict[str, Array]:
        """Take the predicted displacement of the chain's centre of mass out of the residual.

        Returns
        -------
        dict
            Size of the prediction (added to drawn tolerances) and its uncertainty (to the judged ones).
        """
        predicted = com_displacement(self.scene, self.truth.trajectory)
        apart = self.truth.trajectory.com_m[: self.n] - self.main.com_m[: self.n] - predicted.vector_m[: self.n]
        self.residual["com"] = np.linalg.norm(apart, axis=1)
        return {
            "size": np.maximum.accumulate(np.linalg.norm(predicted.vector_m[: self.n], axis=1)),
            "uncertainty": predicted.uncertainty_m[: self.n],
        }

    def verdict(self) -> Verdict:
        """All rows, and the series for plots."""
        early = self.ended_differently() or self.compared_too_little()
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
        if quantity == "com" and self.model:
            return self.explained[quantity][: self.n] + self.model["uncertainty"]
        return self.explained[quantity][: self.n]

    def pointwise(self, quantity: str) -> list[Row]:
        """Size of the difference up to the horizon, whether it is explained, and whether it is good enough."""
        size = self.found[quantity][self.inside]
        ratio, when = worst(self.residual[quantity], self.tolerance(quantity), self.inside)
        margin = self.band[quantity] + 2.0 * self.truth.error[quantity][: self.n]
        if quantity == "com" and self.model:
            margin = margin + self.model["uncertainty"]
        used, at = worst(self.residual[quantity], margin, self.inside)
        allowed = margin + self.model["size"] if quantity == "com" and self.model else margin
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
        band = drift_bands(self.engine, self.scene, self.setting, self.main, self.truth)
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
        extra = self.model.get("size", np.zeros(self.n))
        for quantity, found in self.found.items():
            shift = extra if quantity == "com" else 0.0
            columns[f"{quantity}_difference"] = padded(found, self.main)
            columns[f"{quantity}_tolerance"] = padded(self.tolerance(quantity) + shift, self.main)
            columns[f"{quantity}_band"] = padded(self.band[quantity] + shift, self.main)
        allowed = drift_bands(self.engine, self.scene, self.setting, self.main, self.truth)
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
