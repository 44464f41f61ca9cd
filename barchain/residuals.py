"""Differences of one engine's runs from the reference solution, and everything that may explain them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import Coordinates, Observable
from adapters.steps import finer_setting
from barchain.beyond import beyond_limit
from barchain.ending import ended_differently
from barchain.error_model import ErrorModel
from barchain.extrapolation import FIELDS, SHARE, STAYS, left_over
from barchain.model_difference import com_displacement
from barchain.quantities import differences
from barchain.roundoff_limit import coarsest_roundoff, measured_roundoff
from barchain.scales import scales
from barchain.tolerances import NORM_SLACK
from barchain.truth import RICHARDSON, TRACK
from reports.outcome import Outcome
from reports.tables import QUANTITY_UNITS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.evidence import Evidence
    from barchain.truth import Truth

HALVED = 4.0  # noise of differences over a step goes as 1/h²
FINER_NOISE = 4.0 / 3.0  # what an extrapolation of second order makes of the finer run's noise
FINEST_NOISE = 4.0 * FINER_NOISE  # of the finer run's, after another halving: noise of differences goes as 1/h²
MOST_MEASURED = 1e-6
"""Of a quantity's scale: measured round-off in coordinates no larger than the chain.

In 300 random scenes 4e-7 at most, where last digits change which steps a solver takes.
"""
SHRINKS = 0.5  # of the error at the main setting, two settings finer: a method of first order leaves a quarter


@dataclass(frozen=True)
class ModelDifference:
    """What an engine's model is predicted to leave out of one quantity; n samples, in its unit."""

    size: Array
    """(n,) never falling; added to drawn tolerances"""
    uncertainty: Array
    """(n,) of the prediction; added to the judged ones"""


@dataclass(frozen=True)
class Check:
    """What one question asked of a residual found."""

    ratio: float
    """Largest ratio of the residual to what is allowed"""
    outcome: Outcome
    words: str


class Residuals:
    """Residuals of an engine's two runs, n common samples, and their bounds; computed once for a verdict."""

    def __init__(self, engine: type[Engine], setting: Setting, evidence: Evidence, truth: Truth) -> None:
        assert evidence.main.trajectory is not None
        assert evidence.finer.trajectory is not None
        self.engine, self.setting, self.truth, self.scene = engine, setting, truth, truth.scene
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
        self.explained = self.errors.explained(differences(self.main, self.finer))
        self.band = self.errors.band
        self.beyond = beyond_limit(truth, self.t, self.horizon_s)
        self.roundoff = measured_roundoff(self.scene, (self.main, *evidence.perturbed)) if evidence.perturbed else {}

    @property
    def com_only(self) -> bool:
        """Whether the engine follows the centre of mass as a particle."""
        shown = self.main.observables | self.finer.observables | self.engine.observables
        return shown <= {Observable.COM}

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

    def may_be_roundoff(self, quantity: str) -> bool:
        """Whether a difference is no larger than round-off can make it in the engine's coordinates."""
        if quantity not in self.residual:
            return True  # drifts of what should stay: rounding is all that there is
        most = (coarsest_roundoff(self.errors, quantity) + self.errors.unbounded_floor[quantity])[: self.n]
        allowed = np.maximum(self.tolerance(quantity), self.margin(quantity)) + most
        return worst(self.residual[quantity], allowed, self.inside(quantity))[0] <= 1.0

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

    def checks(self, quantity: str) -> tuple[Check, Check]:
        """Whether a residual is explained, and whether it is inside the expected-error bound.

        Measured round-off counts in both up to what the coordinates' own floor explains (times the slack of bands).
        Beyond that the engine is not right but limited by round-off, and that only as far as coordinates as large as
        the orbit's radius can be.
        """
        inside, residual = self.inside(quantity), self.residual[quantity]
        tolerance, margin = self.tolerance(quantity), self.margin(quantity)
        noise = self.limiting_noise(quantity)
        granted = self.granted(quantity)
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

    def granted(self, quantity: str) -> Array:
        """Measured round-off that counts towards a pass, (n,): up to the floor of the coordinates, with slack."""
        if not self.roundoff:
            return np.zeros(self.n)
        return np.minimum(self.roundoff[quantity][: self.n], NORM_SLACK * self.errors.floor[quantity][: self.n])

    def granted_finer(self, quantity: str) -> Array:
        """The same for the finer run, whose steps, half as long, make four times the noise of differences, (n,)."""
        if not self.roundoff:
            return np.zeros(self.n)
        floor = NORM_SLACK * self.finer_floor(quantity)[: self.n]
        return np.minimum(HALVED * self.roundoff[quantity][: self.n], floor)

    def limiting_noise(self, quantity: str) -> Array:
        """Noise that may be behind too large an error, (n,): such a run is limited by round-off, which is no pass.

        Perturbed runs show it. In absolute coordinates declared noise adds to it, and an error that does not shrink
        with the setting may be all that rounding of such coordinates can make: the two can't be told apart. In
        others, whose floor is far lower, only a small share of the quantity's scale is believed to be noise.
        """
        if not self.evidence.perturbed:
            return np.zeros(self.n)
        if self.engine.coordinates is not Coordinates.ABSOLUTE:
            return np.minimum(self.roundoff[quantity][: self.n], MOST_MEASURED * self.scale[quantity])
        most = coarsest_roundoff(self.errors, quantity)[: self.n]
        if self.errors_by_setting(quantity) and not self.shrinks(quantity):
            return most
        return np.minimum(self.roundoff[quantity][: self.n] + self.errors.unbounded_floor[quantity][: self.n], most)

    def digits_words(self, quantity: str, inside: NDArray[np.bool_]) -> str:
        """How many digits round-off leaves of a quantity."""
        noise = float(self.residual[quantity][inside].max())
        left = max(0.0, -math.log10(noise / self.scale[quantity]))
        unit = QUANTITY_UNITS[quantity]
        return f"limited by round-off, which moves it by {noise:.2g} {unit}: {left:.1f} digits are left"

    @cached_property
    def finest(self) -> Trajectory | None:
        """Run at the finest setting, where one was asked for and came."""
        result = self.evidence.finest
        if result is None or result.outcome is not Outcome.PASS or result.trajectory is None:
            return None
        return None if ended_differently(result.trajectory, self.truth) else result.trajectory

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
        tolerance wherever it is, whatever the sign of the error that the engine makes itself, and whatever round-off
        further runs may grant.
        """
        inside = self.inside(quantity)
        allowed = np.minimum(self.tolerance(quantity), self.margin(quantity)) + self.residual[quantity]
        if self.engine.order is not None and quantity in FIELDS and not self.com_only:
            left, most = self.offset(quantity, self.main, self.finer)
            allowed[: len(left)] = np.minimum(allowed[: len(left)], left + most)
        granted = 0.0 if self.com_only else NORM_SLACK * self.errors.floor[quantity][: self.n]
        return float((allowed + granted)[inside].max() / self.scale[quantity])

    def offset(
        self, quantity: str, coarse: Trajectory, fine: Trajectory, noise: float = FINER_NOISE
    ) -> tuple[Array, Array]:
        """What the extrapolation of two runs is off by, and may be, each (n,); `noise`: share of the finer floor."""
        assert self.engine.order is not None
        size, own = left_over(quantity, coarse, fine, self.truth.trajectory, self.engine.order)
        n = min(self.n, len(size))
        fixed = self.errors.floor[quantity] + RICHARDSON * self.truth.error[quantity][: self.errors.n]
        fixed = fixed + noise * self.finer_floor(quantity)
        missed = self.errors.missed.get(quantity, np.zeros(self.errors.n))
        return size[:n], SHARE * own[:n] + (fixed + missed)[:n] + self.apart(quantity)[:n]

    def finer_floor(self, quantity: str) -> Array:
        """Floor of the finer run, (n,): noise of differences over a step grows as the step shrinks."""
        return self.finer_errors.floor[quantity][: self.errors.n]

    @cached_property
    def finer_errors(self) -> ErrorModel:
        """Error model of the finer setting."""
        return ErrorModel(
            self.engine, finer_setting(self.scene, self.engine.ladder, self.setting), self.truth, self.main
        )

    def stays(self, quantity: str, over: NDArray[np.bool_], size: Array) -> bool:
        """Whether what is left over is there at the next setting too; taken for granted until that is run."""
        if self.finest is None:
            return True
        later, allowed = self.offset(quantity, self.finer, self.finest, FINEST_NOISE)
        n = min(len(later), len(size))
        stays = over[:n] & (later[:n] > allowed[:n]) & (later[:n] > STAYS * size[:n])
        return bool(np.any(stays & self.inside(quantity)[:n]))


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
