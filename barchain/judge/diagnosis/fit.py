"""Agreement of a given trajectory with a supposed one, quantity by quantity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import VECTORS, channels_of
from barchain.judge.residuals import worst
from barchain.judge.scales import scales
from barchain.metrics.quantities import differences

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingMistake
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

    Tolerance = Mapping[str, Array]

SPREAD = 3.0
"""Slack of a tolerance carried through a reading: one perturbation of random signs may meet a weak direction"""
MOST_CARRIED = 1e5
"""Largest factor by which a reading may widen tolerances; micronewtons would be 1e6"""
MOST_UNKNOWN = 2
"""Samples about which a supposed trajectory may say nothing: central differences leave both ends"""
QUANTITY_OF = {
    "com_m": "com", "com_velocity_m_s": "com_velocity", "angle_rad": "attitude", "rate_rad_s": "rate",
    "reaction_N": "reaction", "torque_N_m": "torque", "impulse_N_s": "impulse",
}  # fmt: skip
"""Compared quantity of each array of `Trajectory`"""


@dataclass(frozen=True)
class Fit:
    """Residuals of a given trajectory against a supposed one."""

    ratio: dict[str, float]
    """Largest difference over its tolerance, for each quantity"""
    own_ratio: dict[str, float]
    """Largest difference over the tolerance of the right motion, not carried through a reading, for each quantity"""
    relative: dict[str, float]
    """Largest difference over the quantity's scale, for each quantity"""

    @property
    def normalised_error(self) -> float:
        """Largest difference over its tolerance, of all quantities."""
        return max(self.ratio.values(), default=math.inf)

    @property
    def own_error(self) -> float:
        """Largest difference over the tolerance of the right motion, of all quantities."""
        return max(self.own_ratio.values(), default=math.inf)

    @property
    def relative_error(self) -> float:
        """Largest difference over its quantity's scale, of all quantities."""
        return max(self.relative.values(), default=math.inf)

    @property
    def outside(self) -> frozenset[str]:
        """Quantities outside their tolerances."""
        return frozenset(name for name, value in self.ratio.items() if not value <= 1.0)

    def of(self, names: frozenset[str]) -> Fit:
        """Residuals of some quantities."""
        return merged([(names, self)])


def merged(parts: list[tuple[frozenset[str], Fit]]) -> Fit:
    """Fit that has some quantities of each of several fits."""
    pairs = [(q, fit) for names, fit in parts for q in sorted(names)]
    return Fit(
        {q: fit.ratio[q] for q, fit in pairs},
        {q: fit.own_ratio[q] for q, fit in pairs},
        {q: fit.relative[q] for q, fit in pairs},
    )


def known(size: Array) -> Array:
    """Differences (n,) with 0 at one or two unknown samples, NaN; infinite throughout if more are unknown."""
    if np.count_nonzero(np.isnan(size)) > MOST_UNKNOWN:
        return np.full_like(size, math.inf)
    return np.nan_to_num(size, posinf=math.inf)


@dataclass(frozen=True)
class GivenResult:
    """A trajectory to be explained and the right motion, at n common samples.

    A tolerance is infinite where a quantity is not compared, beyond the predictability limit.
    """

    scene: Scene
    given: Trajectory
    right: Trajectory
    """Judging solution"""
    tolerance: Tolerance
    """(n,) for each quantity, SI units"""
    scale: dict[str, float]
    """Size of each quantity in the scene"""
    right_tolerance: Tolerance | None = None
    """Tolerance of the right motion, where `tolerance` allows for the error of another motion too"""

    @property
    def n(self) -> int:
        """Number of compared samples."""
        return len(self.right.t_s)

    @cached_property
    def quantities(self) -> frozenset[str]:
        """Compared quantities."""
        return frozenset(differences(self.given, self.right)) & frozenset(self.tolerance)

    @property
    def finite(self) -> bool:
        """Whether all compared values are numbers."""
        return all(bool(np.isfinite(v).all()) for v in channels_of(self.given).values())

    def at(self, rows: NDArray[np.intp]) -> GivenResult:
        """Result at some samples."""
        tolerance = {name: values[rows] for name, values in self.tolerance.items()}
        right = self.right_tolerance and {name: values[rows] for name, values in self.right_tolerance.items()}
        given, motion = self.given.samples(rows), self.right.samples(rows)
        return GivenResult(self.scene, given, motion, tolerance, self.scale, right)

    def perturbed(self, motion: Trajectory) -> Trajectory:
        """A motion with every value off by the tolerance of its quantity, with random signs."""
        rng = np.random.default_rng(0)
        changes: dict[str, Array | None] = {}
        for field, values in channels_of(motion).items():
            tolerance = self.tolerance.get(QUANTITY_OF[field])
            if tolerance is not None:
                size = np.where(np.isfinite(tolerance), tolerance, 0.0)
                size = size / (math.sqrt(2.0) if field in VECTORS else 1.0)
                signs = rng.choice([-1.0, 1.0], values.shape)
                changes[field] = values + signs * size.reshape(-1, *[1] * (values.ndim - 1))
        return motion.replace(**changes)

    def read(self, reading: ReadingMistake, motion: Trajectory) -> tuple[Trajectory, Tolerance]:
        """Altered reading of a motion, and tolerances carried through the reading: at least the motion's own."""
        supposed = reading.read(self.scene, motion)
        carried = differences(supposed, reading.read(self.scene, self.perturbed(motion)))
        widened = {
            name: np.fmax(values, SPREAD * carried[name]) if name in carried else values
            for name, values in self.tolerance.items()
        }
        return supposed, widened

    def fit(
        self,
        supposed: Trajectory,
        *,
        any_turns: bool = False,
        tolerance: Tolerance | None = None,
        samples: int | None = None,
    ) -> Fit:
        """Residuals against a supposed trajectory.

        Parameters
        ----------
        supposed : Trajectory
            NaN where the supposition says nothing: such values are not compared. A run that ends too early does not
            fit.
        any_turns : bool
            Whether angles may differ by whole turns, the same at all samples.
        tolerance : mapping, optional
            (n,) for each quantity; that of the right motion by default.
        samples : int, optional
            Number of samples at the start that are compared; all by default.
        """
        allowed, n = tolerance or self.tolerance, min(self.n, samples or self.n)
        if any_turns:
            supposed = self.with_turns(supposed)
        apart = differences(self.given, supposed) if len(supposed.t_s) >= n else {}
        ratio, own, relative = {}, {}, {}
        for name in sorted(self.quantities):
            size = known(apart[name][:n]) if name in apart else np.full(n, math.inf)
            inside = np.isfinite(allowed[name][:n])
            ratio[name] = max(0.0, worst(size, allowed[name][:n], inside)[0])
            own[name] = max(0.0, worst(size, (self.right_tolerance or self.tolerance)[name][:n], inside)[0])
            relative[name] = float(size[inside].max(initial=0.0)) / self.scale[name]
        return Fit(ratio, own, relative)

    def hopeless(self, supposed: Trajectory, *, any_turns: bool = False) -> bool:
        """Whether no tolerance carried through a reading explains the differences: a quick look before :meth:`fit`.

        The median sample decides: a wrapped angle may jump at a single one.
        """
        apart = differences(self.given, self.with_turns(supposed) if any_turns else supposed)
        over = (apart[q] > MOST_CARRIED * self.tolerance[q] for q in self.quantities if q in apart)
        return any(2 * int(np.count_nonzero(each)) > len(each) for each in over)

    def with_turns(self, supposed: Trajectory) -> Trajectory:
        """Supposed trajectory with whole turns added to each bar's angle, as at the first known sample."""
        if supposed.angle_rad is None or self.given.angle_rad is None:
            return supposed
        rows = np.nonzero(~np.isnan(supposed.angle_rad).any(axis=1))[0]
        if not len(rows):
            return supposed
        apart = self.given.angle_rad[rows[0]] - supposed.angle_rad[rows[0]]
        turns = 2.0 * math.pi * np.rint(apart / (2.0 * math.pi))
        return supposed.replace(angle_rad=supposed.angle_rad + turns)


def given_result(trajectory: Trajectory, judging: ReferenceSolution, tolerance: Tolerance) -> GivenResult:
    """A trajectory and its judging solution at their common samples.

    Parameters
    ----------
    trajectory : Trajectory
    judging : ReferenceSolution
    tolerance : mapping
        (k,) for each quantity, SI units; infinite where the quantity is not compared.
    """
    lengths = [len(values) for values in tolerance.values()]
    rows = np.arange(min([len(trajectory.t_s), len(judging.trajectory.t_s), *lengths]))
    whole = GivenResult(judging.scene, trajectory, judging.trajectory, tolerance, scales(judging))
    return whole.at(rows)
