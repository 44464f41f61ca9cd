"""Differences of one engine's runs from the judging solution, and all bounds that they are compared with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import finer_setting
from adapters.engine import Coordinates
from adapters.trajectory import Observable
from barchain.judge.checks.extrapolation import FIELDS, HIGHER_ORDER_SHARE, PERSISTING_SHARE, extrapolation_residual
from barchain.judge.checks.run_end import end_event_fault
from barchain.judge.checks.track_beyond_limit import parted_track_bound
from barchain.judge.error_model import ErrorModel
from barchain.judge.error_units import NORM_SLACK
from barchain.judge.measured_roundoff import max_roundoff, measured_roundoff
from barchain.metrics.model_difference import SECOND_MOMENT_SENSITIVITY, com_displacement, displacement_bound
from barchain.metrics.quantities import differences
from barchain.solutions.reference import RICHARDSON, TRACK
from reports.tables.crossval import QUANTITY_UNITS
from reports.tables.outcome import Outcome
from scenarios import Gravity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.evidence import Evidence

HALVED_STEP_NOISE = 4.0
"""Noise of differences over a step goes as 1/h²: that of the finer run relative to the main run's"""
FINER_NOISE = 4.0 / 3.0
"""Noise in an extrapolation of second order relative to the finer run's noise"""
FINEST_NOISE = 4.0 * FINER_NOISE
"""The same for the extrapolation of the finer and the finest run, relative to the finer run's noise"""
MAX_MEASURED_SHARE = 1e-6
"""Largest measured round-off relative to a quantity's scale, in coordinates no larger than the chain"""
CONVERGED_SHARE = 0.5
"""An error shrinks if it is below this two settings finer, relative to the main one: first order leaves a quarter"""


@dataclass(frozen=True)
class ModelDifference:
    """Predicted difference of an engine's model from the chain in one quantity; n samples, in its unit."""

    size: Array
    """(n,) never falling; added to plotted tolerances"""
    uncertainty: Array
    """(n,) of the prediction; added to the tolerances that judge"""


@dataclass(frozen=True)
class ResidualCheck:
    """Answer to one question asked of a residual."""

    ratio: float
    """Largest ratio of the residual to its tolerance"""
    outcome: Outcome
    reason: str
    """Empty for a pass"""


class Residuals:
    """Residuals of an engine's two runs, n common samples, and their bounds, each computed once for a verdict."""

    def __init__(self, errors: ErrorModel, evidence: Evidence) -> None:
        """Compare the runs.

        Parameters
        ----------
        errors : ErrorModel
            Of the engine at the setting of its main run.
        evidence : Evidence
            Its main and its finer run have trajectories.
        """
        assert evidence.main.trajectory is not None
        assert evidence.finer.trajectory is not None
        self.errors, self.evidence = errors, evidence
        self.engine, self.setting, self.solution, self.scene = (
            errors.engine,
            errors.setting,
            errors.solution,
            errors.scene,
        )
        self.main, self.finer = evidence.main.trajectory, evidence.finer.trajectory
        self.n = min(errors.n, len(self.finer.t_s))
        self.t = self.main.t_s[: self.n]
        self.limit_s, self.scale = errors.limit_s, errors.scale
        self.difference = {k: d[: self.n] for k, d in differences(self.main, self.solution.trajectory).items()}
        self.residual = dict(self.difference)
        self.finer_residual = {k: d[: self.n] for k, d in differences(self.finer, self.solution.trajectory).items()}
        self.model = self.remove_model_difference() if self.com_only else {}
        self.explained = errors.explained(self.own_error())
        known_s = self.solution.limit_s if self.com_only else self.limit_s  # a particle has no attitude to part
        self.parted_track = parted_track_bound(self.solution, self.t, known_s)

    def own_error(self) -> dict[str, Array]:
        """Differences of the main run from its finer runs, (n,) for each quantity: its error, by two settings or three.

        The error of a method that chooses its steps is a sum of errors of any sign. Two of its runs may meet where both
        are off, and most so where the order varies too. The third setting, where there is one, then decides.
        """
        own = differences(self.main, self.finer)
        third = self.finest if self.engine.order is None else None
        if third is not None:
            for name, size in differences(self.main, third).items():
                n = min(len(size), len(own[name]))
                own[name] = np.maximum(own[name][:n], size[:n])
        return own

    @property
    def com_only(self) -> bool:
        """Whether the engine follows the centre of mass alone, as a particle."""
        shown = self.main.observables | self.finer.observables | self.engine.observables
        return shown <= {Observable.COM}

    def inside(self, quantity: str) -> NDArray[np.bool_]:
        """Mask of the samples at which a quantity is compared, (n,): all for the track, which is not chaotic."""
        return np.ones(self.n, bool) if quantity in TRACK else self.t <= self.limit_s

    def remove_model_difference(self) -> dict[str, ModelDifference]:
        """Subtract the predicted departure of the chain's centre of mass from a particle's track from the residuals."""
        predicted = com_displacement(self.scene, self.solution.trajectory)
        turned = self.displacement_by_solution_error()
        return {
            "com": self.subtracted("com", "com_m", predicted.vector_m, predicted.uncertainty_m + turned["com"]),
            "com_velocity": self.subtracted(
                "com_velocity", "com_velocity_m_s", predicted.vector_m_s,
                predicted.uncertainty_m_s + turned["com_velocity"],
            ),
        }  # fmt: skip

    def displacement_by_solution_error(self) -> dict[str, Array]:
        """Change of the predicted departure by the attitude's error of the judging solution, (n,) each.

        The error counts as it is at the solution's own limit: beyond it :func:`parted_track_bound` allows any attitude.
        """
        scene, t_s = self.scene, self.solution.trajectory.t_s
        if scene.effects.gravity is Gravity.NONE or not scene.bound:
            return {name: np.zeros(len(t_s)) for name in TRACK}
        known = np.where(t_s <= self.solution.limit_s, self.solution.error["attitude"], 0.0)
        wrong_rad = np.maximum.accumulate(known)
        bounds = displacement_bound(scene, t_s, SECOND_MOMENT_SENSITIVITY)
        return {name: wrong_rad * bounds[name] for name in TRACK}

    def subtracted(self, quantity: str, field: str, predicted: Array, uncertainty: Array) -> ModelDifference:
        """Subtract the prediction (n, 2) from the residuals of one quantity; return size and uncertainty, (n,) each."""
        n, right = self.n, getattr(self.solution.trajectory, field)
        for residual, run in ((self.residual, self.main), (self.finer_residual, self.finer)):
            apart = right[:n] - getattr(run, field)[:n]
            residual[quantity] = np.linalg.norm(apart - predicted[:n], axis=1)
        size = np.maximum.accumulate(np.linalg.norm(predicted[:n], axis=1))
        return ModelDifference(size, uncertainty[:n])

    @cached_property
    def max_roundoff(self) -> dict[str, Array]:
        """Largest round-off that the engine's coordinates can cause since the start, for each quantity."""
        return max_roundoff(self.errors, self.errors.amplification)

    @cached_property
    def roundoff(self) -> dict[str, Array]:
        """Round-off of the main run, measured with perturbed runs, for each quantity and drift; empty without them."""
        perturbed = self.evidence.perturbed
        return measured_roundoff(self.scene, (self.main, *perturbed)) if perturbed else {}

    def may_be_roundoff(self, quantity: str) -> bool:
        """Whether a difference is no larger than round-off can make it in the engine's coordinates."""
        if quantity not in self.residual:
            return True  # drifts of conserved quantities: rounding is all that there is
        most = (self.max_roundoff[quantity] + self.errors.unbounded_floor[quantity])[: self.n]
        allowed = np.maximum(self.tolerance[quantity], self.margin[quantity]) + most
        return worst(self.residual[quantity], allowed, self.inside(quantity))[0] <= 1.0

    @cached_property
    def tolerance(self) -> dict[str, Array]:
        """Explained error of each residual, (n,): both error estimates, floors and the model difference."""
        return {
            name: explained[: self.n] + self.model_difference(name).uncertainty + self.parted(name)
            for name, explained in self.explained.items()
        }

    @cached_property
    def margin(self) -> dict[str, Array]:
        """Expected-error bound of each residual, (n,): the engine's, and the reference's own error."""
        return {
            name: bound[: self.n] + RICHARDSON * self.solution.error[name][: self.n]
            + self.model_difference(name).uncertainty + self.parted(name)
            for name, bound in self.errors.bound.items()
        }  # fmt: skip

    def parted(self, quantity: str) -> Array:
        """Effect of parted attitudes on the track beyond the limit, (n,); zero for other quantities."""
        return self.parted_track.get(quantity, np.zeros(self.n))

    def model_difference(self, quantity: str) -> ModelDifference:
        """Declared model difference of a quantity; zero for most."""
        none = np.zeros(self.n)
        return self.model.get(quantity, ModelDifference(none, none))

    def checks(self, quantity: str) -> tuple[ResidualCheck, ResidualCheck]:
        """Whether a residual is explained, and whether it is inside the expected-error bound.

        Measured round-off counts in both questions up to the floor of the coordinates, times the slack of the bounds.
        A larger error is not right but limited by round-off, and that only up to the round-off of coordinates as large
        as the orbit's radius.
        """
        granted = self.granted_roundoff(quantity)
        return (
            self.check(quantity, self.tolerance[quantity] + granted, Outcome.INCONSISTENT, "the explained error"),
            self.check(quantity, self.margin[quantity] + granted, Outcome.EXCEEDS_BOUND, "the expected-error bound"),
        )

    def check(self, quantity: str, allowed: Array, failure: Outcome, named: str) -> ResidualCheck:
        """Compare a residual with `allowed` (n,), `named` in reasons; `failure` is the outcome outside of it."""
        inside, residual = self.inside(quantity), self.residual[quantity]
        ratio, at = worst(residual, allowed, inside)
        if ratio <= 1.0:
            return ResidualCheck(ratio, Outcome.PASS, "")
        with_noise = worst(residual, allowed + self.limiting_noise(quantity), inside)[0]
        if with_noise <= 1.0:
            limited = self.digits_left(quantity, residual[inside], f"{ratio:.3g} times {named}")
            return ResidualCheck(ratio, Outcome.ROUNDOFF_LIMITED, limited)
        said = f"{ratio:.3g} times {named} at t = {self.t[at]:.6g} s"
        return ResidualCheck(ratio, failure, said + self.convergence_reason(quantity))

    def granted_roundoff(self, quantity: str) -> Array:
        """Measured round-off that counts towards a pass, (n,): up to the floor of the coordinates, with slack."""
        if not self.roundoff:
            return np.zeros(self.n)
        return np.minimum(self.roundoff[quantity][: self.n], NORM_SLACK * self.errors.floor[quantity][: self.n])

    def granted_finer_roundoff(self, quantity: str) -> Array:
        """Round-off granted to the finer run, (n,): half as long steps make four times the noise of differences."""
        if not self.roundoff:
            return np.zeros(self.n)
        floor = NORM_SLACK * self.finer_floor(quantity)[: self.n]
        return np.minimum(HALVED_STEP_NOISE * self.roundoff[quantity][: self.n], floor)

    def limiting_noise(self, quantity: str) -> Array:
        """Noise that may cause too large an error, (n,): such a run is limited by round-off, which is no pass.

        Perturbed runs show this noise. In absolute coordinates declared noise adds to it. An error that does not shrink
        with the setting can't be told from the largest round-off of such coordinates, which is then allowed. In other
        coordinates the floor is far lower, and only :data:`MAX_MEASURED_SHARE` of the scale is believed to be noise.
        """
        if not self.evidence.perturbed:
            return np.zeros(self.n)
        if self.engine.coordinates is not Coordinates.ABSOLUTE:
            return np.minimum(self.roundoff[quantity][: self.n], MAX_MEASURED_SHARE * self.scale[quantity])
        most = self.max_roundoff[quantity][: self.n]
        if self.errors_by_setting(quantity) and not self.shrinks(quantity):
            return most
        return np.minimum(self.roundoff[quantity][: self.n] + self.errors.unbounded_floor[quantity][: self.n], most)

    def digits_left(self, quantity: str, error: Array, without: str) -> str:
        """Reason of an outcome limited by round-off: its size up to `error`, the ratio `without` it, digits left."""
        inside = self.inside(quantity)
        noise = min(float(error.max()), float(self.limiting_noise(quantity)[inside].max()))
        left = max(0.0, -math.log10(float(self.residual[quantity][inside].max()) / self.scale[quantity]))
        unit = QUANTITY_UNITS[quantity]
        return f"limited by round-off of {noise:.2g} {unit} ({without} without it): {left:.1f} digits are left"

    @cached_property
    def finest(self) -> Trajectory | None:
        """Run at the finest setting, if it was requested and completed."""
        result = self.evidence.finest
        if result is None or result.outcome is not Outcome.PASS or result.trajectory is None:
            return None
        return None if end_event_fault(result.trajectory, self.solution) else result.trajectory

    @cached_property
    def finest_difference(self) -> dict[str, Array]:
        """Differences of the finest run from the judging solution; empty without that run."""
        return {} if self.finest is None else differences(self.finest, self.solution.trajectory)

    def errors_by_setting(self, quantity: str) -> tuple[float, ...]:
        """Largest errors of a quantity from the coarsest to the finest of three settings; empty without a third one."""
        finest = self.finest_difference.get(quantity)
        if finest is None or self.com_only:
            return ()
        inside = self.inside(quantity)
        each = (self.residual[quantity], self.finer_residual[quantity], finest[: self.n])
        return tuple(float(r[inside[: len(r)]].max()) for r in each)

    def shrinks(self, quantity: str) -> bool:
        """Whether a quantity's error falls from the first to the last of three settings."""
        sizes = self.errors_by_setting(quantity)
        return sizes[-1] < CONVERGED_SHARE * sizes[0]

    def convergence_reason(self, quantity: str) -> str:
        """Errors at three settings and whether they shrink, for a reason; empty without a third setting."""
        sizes = self.errors_by_setting(quantity)
        if not sizes:
            return ""
        told = ", ".join(f"{size:.2g}" for size in sizes)
        how = "shrinks" if self.shrinks(quantity) else "does not shrink"
        return f"; the error {how} with the setting: {told} {QUANTITY_UNITS[quantity]} from coarse to fine"

    def detection_limit(self, quantity: str) -> float:
        """Smallest error that would be rejected at every sample, relative to the quantity's scale.

        A larger error, equal at both settings, is outside a tolerance at any sample. This holds for either sign of the
        engine's own error, and for all round-off that further runs may grant.
        """
        inside = self.inside(quantity)
        allowed = np.minimum(self.tolerance[quantity], self.margin[quantity]) + self.residual[quantity]
        if self.engine.order is not None and quantity in FIELDS and not self.com_only:
            left, most = self.extrapolated[quantity]
            allowed[: len(left)] = np.minimum(allowed[: len(left)], left + most)
        granted_roundoff = 0.0 if self.com_only else NORM_SLACK * self.errors.floor[quantity][: self.n]
        return float((allowed + granted_roundoff)[inside].max() / self.scale[quantity])

    @cached_property
    def extrapolated(self) -> dict[str, tuple[Array, Array]]:
        """Error of the extrapolation of main and finer run and its tolerance, each (n,), for each of `FIELDS`."""
        names = [name for name in FIELDS if name in self.difference and name in self.errors.floor]
        return {name: self.extrapolation_error(name, self.main, self.finer) for name in names}

    def extrapolation_error(
        self, quantity: str, coarse: Trajectory, fine: Trajectory, noise: float = FINER_NOISE
    ) -> tuple[Array, Array]:
        """Error of the extrapolation of two runs and its tolerance, each (n,); `noise` relative to the finer floor."""
        assert self.engine.order is not None
        size, own = extrapolation_residual(quantity, coarse, fine, self.solution.trajectory, self.engine.order)
        n = min(self.n, len(size))
        fixed = self.errors.floor[quantity] + RICHARDSON * self.solution.error[quantity][: self.errors.n]
        fixed = fixed + noise * self.finer_floor(quantity)
        missed = self.errors.missed.get(quantity, np.zeros(self.errors.n))
        return size[:n], HIGHER_ORDER_SHARE * own[:n] + (fixed + missed)[:n] + self.parted(quantity)[:n]

    def finer_floor(self, quantity: str) -> Array:
        """Floor of the finer run, (n,): noise of differences over a step grows as the step shrinks."""
        return self.finer_errors.floor[quantity][: self.errors.n]

    @cached_property
    def finer_errors(self) -> ErrorModel:
        """Error model of the finer setting."""
        return ErrorModel(
            self.engine, finer_setting(self.scene, self.engine.sweep, self.setting), self.solution, self.main
        )

    def persisting(self, quantity: str, over: NDArray[np.bool_], size: Array) -> NDArray[np.bool_]:
        """Samples (n,) at which an error `size` (n,), `over` its tolerance, is there at a third setting too.

        Without a third setting, all samples over the tolerance.
        """
        over = over & self.inside(quantity)[: len(over)]
        if self.finest is None:
            return over
        later, allowed = self.extrapolation_error(quantity, self.finer, self.finest, FINEST_NOISE)
        n = min(len(later), len(size))
        found = np.zeros_like(over)
        found[:n] = over[:n] & (later[:n] > allowed[:n]) & (later[:n] > PERSISTING_SHARE * size[:n])
        return found


def worst(found: Array, allowed: Array, inside: NDArray[np.bool_]) -> tuple[float, int]:
    """Largest ratio of a found to an allowed error, and its sample; infinite where nothing is allowed.

    A difference of exactly zero needs no allowance. Not-a-number is never inside.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(found == 0.0, 0.0, found / allowed)
    ratio = np.where(np.isnan(ratio), np.inf, ratio)
    ratio = np.where(inside, ratio, -np.inf)
    at = int(np.argmax(ratio))
    return float(ratio[at]), at
