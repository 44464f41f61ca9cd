"""Differences of one engine's runs from the judging solution, and all bounds that they are compared with."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import finer_setting
from adapters.trajectory import Observable
from barchain.judge.error_model import ErrorModel
from barchain.judge.parted_track import parted_track_bound
from barchain.judge.scales import NORM_SLACK, measured_roundoff
from barchain.metrics.model_difference import SECOND_MOMENT_SENSITIVITY, com_displacement, displacement_bound
from barchain.metrics.quantities import FIELDS, TRACK, differences, drifts
from barchain.solutions.reference import RICHARDSON
from reports.results.outcome import Outcome
from scenarios import Gravity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.evidence import Evidence
    from barchain.solutions.reference import ReferenceSolution

HALVED_STEP_NOISE = 4.0
"""Noise of differences over a step goes as 1/h²: that of the finer run relative to the main run's"""
FINER_NOISE = 4.0 / 3.0
"""Noise in an extrapolation of second order relative to the finer run's noise"""
MAX_MEASURED_SHARE = 1e-6
"""Largest measured round-off relative to a quantity's scale, in coordinates no larger than the chain"""
CONVERGED_SHARE = 0.5
"""An error shrinks if it is below this two settings finer, relative to the main one: first order leaves a quarter"""
HIGHER_ORDER_SHARE = 0.1
"""Largest error of the extrapolation by terms of higher order, relative to the change between two settings. On random
scenes every unmodified engine in a moving frame stayed below 0.05."""
EXTRAPOLATED = ("com", "attitude", "rate", "reaction")
"""Quantities whose error is extrapolated"""


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
        self.errors, self.evidence, self.engine, self.setting = errors, evidence, errors.engine, errors.setting
        self.solution, self.scene = errors.solution, errors.scene
        self.main, self.finer = evidence.main.trajectory, evidence.finer.trajectory
        self.n = min(errors.n, len(self.finer.t_s))
        self.t = self.main.t_s[: self.n]
        self.limit_s, self.scale = errors.limit_s, errors.scale
        self.difference = {k: d[: self.n] for k, d in differences(self.main, self.solution.trajectory).items()}
        self.residual = dict(self.difference)
        self.finer_residual = {k: d[: self.n] for k, d in differences(self.finer, self.solution.trajectory).items()}
        self.model_size: dict[str, Array] = {}
        """Predicted difference of the engine's model from the chain, (n,) never falling; added to plotted tolerances"""
        self.model_uncertainty: dict[str, Array] = {}
        """Uncertainty of that prediction, (n,); added to the tolerances that judge"""
        if self.com_only:
            self.subtract_departure_from_particle()
        self.explained = errors.explained(self.own_error())
        known_s = self.solution.limit_s if self.com_only else self.limit_s  # a particle has no attitude to part
        self.parted_track = parted_track_bound(self.solution, self.t, known_s)

    @property
    def restarts(self) -> bool:
        """Whether the reference restarts from the run's states beyond the predictability limit."""
        return True

    def drifts(self, run: Trajectory) -> dict[str, Array]:
        """Drifts of one of the two runs, (n,) each (`barchain.metrics.quantities.drifts`)."""
        return drifts(self.scene, run)

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
        shown = self.main.observables.union(self.finer.observables, self.engine.observables)
        return shown <= {Observable.COM}

    def inside(self, quantity: str) -> NDArray[np.bool_]:
        """Mask of the samples at which a quantity is compared, (n,): all for the track, which is not chaotic."""
        return np.ones(self.n, bool) if quantity in TRACK else self.t <= self.limit_s

    def subtract_departure_from_particle(self) -> None:
        """Subtract the predicted departure of the chain's centre of mass from a particle's track from the residuals.

        The prediction changes by the attitude's error of the judging solution. That error counts as it is at the
        solution's own limit: beyond it :func:`parted_track_bound` allows any attitude.
        """
        n, right, scene, solution = self.n, self.solution.trajectory, self.scene, self.solution
        predicted = com_displacement(scene, right)
        known = np.where(right.t_s <= solution.limit_s, solution.error["attitude"], 0.0)
        wrong_rad = np.maximum.accumulate(known)
        sensitivity: dict[str, Array] = {}
        if scene.effects.gravity is not Gravity.NONE and scene.bound:
            sensitivity = displacement_bound(scene, right.t_s, SECOND_MOMENT_SENSITIVITY)
        for name, moved, uncertainty in (
            ("com", predicted.vector_m, predicted.uncertainty_m),
            ("com_velocity", predicted.vector_m_s, predicted.uncertainty_m_s),
        ):
            for residual, run in ((self.residual, self.main), (self.finer_residual, self.finer)):
                apart = getattr(right, FIELDS[name])[:n] - getattr(run, FIELDS[name])[:n]
                residual[name] = np.linalg.norm(apart - moved[:n], axis=1)
            self.model_size[name] = np.maximum.accumulate(np.linalg.norm(moved[:n], axis=1))
            self.model_uncertainty[name] = (uncertainty + wrong_rad * sensitivity.get(name, 0.0))[:n]

    def with_model(self, quantity: str, bound: Array) -> Array:
        """Bound (n,) plus the uncertainty of the model difference and what parted attitudes do to the track."""
        for part in (self.model_uncertainty, self.parted_track):
            if quantity in part:
                bound = bound + part[quantity]
        return bound

    @cached_property
    def tolerance(self) -> dict[str, Array]:
        """Explained error of each residual, (n,): both error estimates, floors and the model difference."""
        return {name: self.with_model(name, explained[: self.n]) for name, explained in self.explained.items()}

    @cached_property
    def margin(self) -> dict[str, Array]:
        """Expected-error bound of each residual, (n,): the engine's, and the reference's own error."""
        n, error = self.n, self.solution.error
        return {
            name: self.with_model(name, bound[:n] + RICHARDSON * error[name][:n])
            for name, bound in self.errors.bound.items()
        }

    @cached_property
    def max_roundoff(self) -> dict[str, Array]:
        """Largest round-off that the engine's coordinates can cause since the start, for each quantity."""
        return self.errors.max_roundoff(self.errors.amplification)

    @cached_property
    def roundoff(self) -> dict[str, Array]:
        """Round-off of the main run, measured with perturbed runs, for each quantity and drift; empty without them."""
        perturbed = self.evidence.perturbed
        return measured_roundoff(self.scene, (self.main, *perturbed)) if perturbed else {}

    def granted_roundoff(self, quantity: str) -> Array:
        """Measured round-off that counts towards a pass, (n,): up to the floor of the coordinates, with slack.

        A larger error is not right but limited by round-off, and that only up to the round-off of coordinates as large
        as the orbit's radius.
        """
        if not self.roundoff:
            return np.zeros(self.n)
        return np.minimum(self.roundoff[quantity][: self.n], NORM_SLACK * self.errors.floor[quantity][: self.n])

    def limiting_noise(self, quantity: str) -> Array:
        """Noise that may cause too large an error, (n,): such a run is limited by round-off, which is no pass.

        Perturbed runs show this noise. In absolute coordinates declared noise adds to it. An error that does not shrink
        with the setting can't be told from the largest round-off of such coordinates, which is then allowed. In other
        coordinates the floor is far lower, and only :data:`MAX_MEASURED_SHARE` of the scale is believed to be noise.
        """
        if not self.evidence.perturbed:
            return np.zeros(self.n)
        if not self.engine.coordinates.absolute:
            return np.minimum(self.roundoff[quantity][: self.n], MAX_MEASURED_SHARE * self.scale[quantity])
        most = self.max_roundoff[quantity][: self.n]
        if self.errors_by_setting(quantity) and not self.shrinks(quantity):
            return most
        return np.minimum(self.roundoff[quantity][: self.n] + self.errors.unbounded_floor[quantity][: self.n], most)

    @cached_property
    def finest(self) -> Trajectory | None:
        """Run at the finest setting, if it was requested and completed."""
        result = self.evidence.finest
        if result is None or result.outcome is not Outcome.PASS or result.trajectory is None:
            return None
        return None if other_end(result.trajectory, self.solution) else result.trajectory

    def errors_by_setting(self, quantity: str) -> tuple[float, ...]:
        """Largest errors of a quantity from the coarsest to the finest of three settings; empty without a third one."""
        finest = self.finest_difference.get(quantity)
        if finest is None or self.com_only:
            return ()
        inside = self.inside(quantity)
        each = (self.residual[quantity], self.finer_residual[quantity], finest[: self.n])
        return tuple(float(r[inside[: len(r)]].max()) for r in each)

    @cached_property
    def finest_difference(self) -> dict[str, Array]:
        """Differences of the finest run from the judging solution; empty without that run."""
        return {} if self.finest is None else differences(self.finest, self.solution.trajectory)

    def shrinks(self, quantity: str) -> bool:
        """Whether a quantity's error falls from the first to the last of three settings."""
        sizes = self.errors_by_setting(quantity)
        return sizes[-1] < CONVERGED_SHARE * sizes[0]

    @cached_property
    def finer_errors(self) -> ErrorModel:
        """Error model of the finer setting."""
        finer = finer_setting(self.scene, self.engine.sweep, self.setting)
        return ErrorModel(self.engine, finer, self.solution, self.main)

    def finer_floor(self, quantity: str) -> Array:
        """Floor of the finer run, (n,): noise of differences over a step grows as the step shrinks."""
        return self.finer_errors.floor[quantity][: self.errors.n]

    @cached_property
    def extrapolated(self) -> dict[str, tuple[Array, Array]]:
        """Error of the extrapolation of main and finer run and its tolerance, each (n,), by quantity.

        Empty for an engine without a fixed order, and for one that follows the centre of mass alone.
        """
        if self.engine.order is None or self.com_only:
            return {}
        names = [name for name in EXTRAPOLATED if name in self.difference and name in self.errors.floor]
        return {name: self.extrapolation_error(name, self.main, self.finer) for name in names}

    def extrapolation_error(
        self, quantity: str, coarse: Trajectory, fine: Trajectory, noise: float = FINER_NOISE
    ) -> tuple[Array, Array]:
        """Error of the extrapolation of two runs and its tolerance, each (n,), the largest component.

        Parameters
        ----------
        quantity : str
            One of :data:`EXTRAPOLATED`.
        coarse, fine : Trajectory
            Runs at some step and at half of it.
        noise : float
            Of the extrapolation, relative to the finer run's floor.
        """
        assert self.engine.order is not None
        arrays = [getattr(run, FIELDS[quantity]) for run in (coarse, fine, self.solution.trajectory)]
        n = min(len(values) for values in arrays)
        one, two, right = (values[:n].reshape(n, -1) for values in arrays)
        change = one - two
        left = two - change / (2.0**self.engine.order - 1.0) - right
        size: Array = np.abs(left).max(axis=1, initial=0.0)
        own: Array = np.maximum.accumulate(np.abs(change).max(axis=1, initial=0.0))
        n = min(self.n, len(size))
        fixed = self.errors.floor[quantity] + RICHARDSON * self.solution.error[quantity][: self.errors.n]
        fixed = fixed + noise * self.finer_floor(quantity)
        allowed = HIGHER_ORDER_SHARE * own[:n] + (fixed + self.errors.missed.get(quantity, 0.0))[:n]
        if quantity in self.parted_track:
            allowed = allowed + self.parted_track[quantity][:n]
        return size[:n], allowed


def other_end(trajectory: Trajectory, solution: ReferenceSolution) -> str | None:
    """Reason if a run and the judging solution do not end at the same event, to one sample; None if they do."""
    run, right = solution.scene.run, solution.trajectory
    spacing = run.duration_s / (run.samples - 1)
    apart = abs(len(trajectory.t_s) - len(right.t_s))
    if apart <= 1 and bool(trajectory.ended) == bool(right.ended) and (len(trajectory.t_s) > 1 or len(right.t_s) == 1):
        return None
    return (
        f"ended {apart * spacing:.3g} s apart from the reference: "
        f"{trajectory.ended or 'at its last sample'}; reference: "
        f"{right.ended or 'at its last sample'}"
    )


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
