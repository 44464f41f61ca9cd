"""Reference solution of a scene, its error bar, and the scene's error amplification.

The reference solution is the reference at its tightest tolerance. Its difference from a run at a ten times looser
tolerance bounds its error. A second run with perturbed initial angles and rates shows the error amplification.
Derivatives of the motion come from a run with dense samples.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from barchain.metrics.model_difference import track_response
from barchain.metrics.quantities import differences
from barchain.metrics.rates import MODES_PER_BAR, own_rate
from reports.tables.crossval import PARTED_RAD
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

SOLUTION_RTOL = 1e-13
SOLUTION_CHECK_RTOL = 1e-12
PERTURBATION_RAD = 1e-10  # a thousand times the error of the reference solution, and linear until amplified 1e8 times
RICHARDSON = 2.0
"""Halving the step of a method of order p >= 1: the error was at most 1/(1 - 2^-p) <= 2 times the change."""
FINE_RTOL = 1e-10  # four differences over a tenth of a radian cost four digits: six are left
FINE_PER_RADIAN = 4.0  # of the fastest rate: a sine's second difference is then 2 % short
FINE_PER_SLEW = 20.0  # three half waves: half a radian between samples
MOST_FINE = 20_000  # samples: they resolve a slew of a thousandth of the run
TRACK = ("com", "com_velocity")


def with_perturbed_start(scene: Scene) -> Scene:
    """`scene` with every bar's angle and rate perturbed by :data:`PERTURBATION_RAD`, in fixed arbitrary proportions."""
    chain = scene.chain
    perturbed = PERTURBATION_RAD * perturbation_directions(chain.bars)
    unit = max(1.0, *(abs(a) for a in chain.rate_factor))
    moved = dataclasses.replace(
        chain,
        angle_rad=tuple(a + float(d) for a, d in zip(chain.angle_rad, perturbed[0], strict=True)),
        rate_factor=tuple(a + unit * float(d) for a, d in zip(chain.rate_factor, perturbed[1], strict=True)),
    )
    return dataclasses.replace(scene, chain=moved)


def perturbation_directions(bars: int) -> Array:
    """Fixed arbitrary proportions of the perturbation of angles and rates, (2, N), each 0.5 to 1 in size."""
    rng = np.random.default_rng(20020812)  # any fixed numbers do; the same in every run
    moves: Array = rng.choice([-1.0, 1.0], (2, bars)) * rng.uniform(0.5, 1.0, (2, bars))
    return moves


def densely_sampled(scene: Scene) -> Scene:
    """`scene` with samples dense enough for derivatives of its motion: its own samples, and equally many in between."""
    intervals = scene.run.samples - 1
    spacing = 1.0 / (FINE_PER_RADIAN * MODES_PER_BAR * scene.bars * own_rate(scene))
    slews = [p.duration_s / FINE_PER_SLEW for p in scene.effects.prescribed_rotation]
    wanted = math.ceil(scene.run.duration_s / (intervals * min([spacing, *slews])))
    times = max(1, min(wanted, MOST_FINE // intervals))
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=times * intervals + 1))


class SolutionSource(StrEnum):
    """Origin of the solution that judges a scene."""

    SHIPPED = "shipped"
    """Certified solution that comes with barchain"""
    HEYOKA = "heyoka"
    """Certified solution, run here"""
    REFERENCE = "reference"
    """Reference solution, run here"""

    @property
    def certified(self) -> bool:
        """Whether the solution is independent of the reference's equations."""
        return self is not SolutionSource.REFERENCE


@dataclass(frozen=True)
class ReferenceSolution:
    """Solution that judges one scene, and its limits; n samples. It is the reference's, or a certified one."""

    scene: Scene
    trajectory: Trajectory
    fine: Trajectory
    """The motion at dense samples (:func:`densely_sampled`), for its derivatives only"""
    error: dict[str, Array]
    """Error estimate or error bar for each quantity, (n,), never falling"""
    amplification: Array
    """(n,) largest perturbation of the attitude so far, relative to the first sample's"""
    response: dict[str, Array]
    """Change of each quantity per change of attitude, (n,), never falling, SI units per rad: the larger of
    the perturbed run's and the looser run's"""
    limit_s: float
    """Predictability limit of the solution itself, s"""
    source: SolutionSource = SolutionSource.REFERENCE
    setting: str = f"rtol={SOLUTION_RTOL:g}"
    """Accuracy of its runs, in words"""

    @property
    def growth_per_orbit(self) -> float:
        """Amplification of a perturbation over the first orbit, or over the run if it is shorter."""
        t = self.trajectory.t_s
        return float(self.amplification[np.searchsorted(t, min(self.scene.period_s, t[-1]) * (1 - 1e-12))])


def establish(
    scene: Scene, solution: Trajectory, check: Trajectory, perturbed: Trajectory, fine: Trajectory | None = None
) -> ReferenceSolution:
    """Reference solution of a scene from its runs of the reference.

    Parameters
    ----------
    scene : Scene
    solution : Trajectory
        At the tightest tolerance.
    check : Trajectory
        At a ten times looser tolerance.
    perturbed : Trajectory
        From the start of :func:`with_perturbed_start`.
    fine : Trajectory, optional
        At dense samples; derivatives come from the samples of `solution` without it.
    """
    parted = differences(solution, perturbed)
    n = min(len(solution.t_s), len(check.t_s), len(perturbed.t_s))
    attitude = np.maximum.accumulate(parted["attitude"])[:n]
    amplification = attitude / attitude[0]
    looser = differences(solution, check)
    # errors of the track exceed its response to an attitude perturbed by 1e-10 rad: integrate it
    response = sensitivity(parted | track_response(scene, solution, perturbed), n, 0.0)
    for name, other in sensitivity({k: d for k, d in looser.items() if k not in TRACK}, n, PERTURBATION_RAD).items():
        response[name] = np.maximum(
            response[name], other
        )  # a perturbation in another direction, once it exceeds round-off
    # runs with step control may agree at a sample by chance: the tolerance of one step is added
    error = {name: np.maximum.accumulate(d)[:n] + SOLUTION_RTOL * response[name] for name, d in looser.items()}
    if scene.effects.gravity is not Gravity.NONE:  # a straight track has no error but round-off
        error["com"] += SOLUTION_RTOL * scene.radius0_m
        error["com_velocity"] += SOLUTION_RTOL * scene.speed0_m_s
    error["rate"] += SOLUTION_RTOL * scene.fastest_rate_rad_s
    return ReferenceSolution(
        scene, solution, fine or solution, error, amplification, response, divergence_instant_s(solution, check)
    )


def sensitivity(apart: dict[str, Array], n: int, least_rad: float) -> dict[str, Array]:
    """Change of each quantity per change of attitude between two runs, (n,), never falling; 0 below `least_rad`."""
    attitude = np.maximum.accumulate(apart["attitude"][:n])
    known = attitude > least_rad
    return {
        name: np.maximum.accumulate(np.divide(d[:n], attitude, out=np.zeros(n), where=known))
        for name, d in apart.items()
    }


def divergence_instant_s(a: Trajectory, b: Trajectory) -> float:
    """Last common instant before the attitudes of two runs differ by more than :data:`PARTED_RAD`, s.

    Without attitude (centre of mass only) it is the last common sample: orbits are not chaotic.
    """
    n = min(len(a.t_s), len(b.t_s))
    apart = differences(a, b).get("attitude", np.zeros(n))
    parted = np.nonzero(apart > PARTED_RAD)[0]
    last = int(parted[0]) - 1 if len(parted) else n - 1
    return float(a.t_s[max(last, 0)])
