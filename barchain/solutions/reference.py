"""Reference solution of a scene, its error bar, and the scene's error amplification.

The reference solution is the reference at its tightest tolerance, in extended precision where that takes seconds,
else in double. Its difference from a run at a looser tolerance bounds its error. Runs from perturbed initial
angles show the error amplification: from 1e-10 rad, and in extended precision from 1e-16 rad besides, which stays
linear for six decades more. Derivatives of the motion come from a run with dense samples.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.reference_model import chain_model
from adapters.reference import WIDE_UNTIL
from barchain.metrics.model_difference import track_response
from barchain.metrics.quantities import MODES_PER_BAR, TRACK, differences, largest, own_rate
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.joints import condition_number, joint_matrix
from reports.results.comparison import PARTED_RAD
from scenarios import Gravity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

SOLUTION_RTOL = 1e-13
SOLUTION_CHECK_RTOL = 1e-12
WIDE_RTOL, WIDE_CHECK_RTOL = 1e-18, 1e-16
"""In extended precision. Its rounding, 5e-20, may bound the tighter steps; the looser tolerance is far above."""
UNIT_ROUNDOFF = 2.0**-53  # of double precision: largest relative error of rounding to nearest
ROUNDED = 3.0  # roundings: of the result, and of the two results that are subtracted
ROUNDED_ALIKE = 5.0
"""Bound of the error over the difference of two runs whose errors are rounding alone, alike in size. By chance they
differ by less than either: the error was up to 3 times the difference with bars of 1e4 : 1"""
SEEN_ROUNDINGS = 1e4
"""Least growth of the close start in roundings of the largest angle: its size is then known to 1e-4"""
PERTURBATION_RAD = 1e-10  # a thousand times the error of the reference solution, and linear until amplified 1e8 times
RICHARDSON = 2.0
"""Halving the step of a method of order p >= 1: the error was at most 1/(1 - 2^-p) <= 2 times the change."""
FINE_RTOL = 1e-10  # four differences over a tenth of a radian cost four digits: six are left
FINE_PER_RADIAN = 4.0  # of the fastest rate: a sine's second difference is then 2 % short
FINE_PER_SLEW = 20.0  # three half waves: half a radian between samples
MOST_FINE = 20_000  # samples: they resolve a slew of a thousandth of the run
MOST_FINE_SHORT, MOST_FINE_ANGLES = 100_000, 400_000
"""Samples of a chain of few bars, and samples times bars: some twenty megabytes for long runs of bars that turn fast.
With a quarter of the samples that it needs, a chaotic run of six bars had 0.7 of a bound with a slack of ten"""
MOST_TURNED_RAD = 0.3
"""Largest rotation of the orbit, or of the fastest bar at the start, between two samples. In that time an error grows
at most 1.7 times, at the rate sqrt(3) n: the next sample can always be predicted."""
MOST_SAMPLES = 2001  # a run of ten thousand orbits is sampled sparsely


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
    times = dense_parts(scene, scene.run.duration_s, intervals)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=times * intervals + 1))


def dense_parts(scene: Scene, duration_s: float, intervals: int, most_s: float = math.inf) -> int:
    """Number of parts of each of equal intervals between samples, for derivatives of the motion in `duration_s`.

    No part is longer than `most_s`, unless there were too many.
    """
    spacing = 1.0 / (FINE_PER_RADIAN * MODES_PER_BAR * scene.bars * own_rate(scene))
    slews = [turn.duration_s / FINE_PER_SLEW for p in scene.effects.prescribed_rotation for turn in p.turns]
    wanted = math.ceil(duration_s / (intervals * min([spacing, most_s, *slews])))
    most = max(MOST_FINE, min(MOST_FINE_SHORT, MOST_FINE_ANGLES // scene.bars))
    return max(1, min(wanted, most // intervals))


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
    setting: str = ""
    """Accuracy of its runs, in words"""

    @property
    def growth_per_orbit(self) -> float:
        """Amplification of a perturbation over the first orbit, or over the run if it is shorter."""
        t = self.trajectory.t_s
        return float(self.amplification[np.searchsorted(t, min(self.scene.period_s, t[-1]) * (1 - 1e-12))])


def establish(
    scene: Scene,
    solution: Trajectory,
    check: Trajectory,
    perturbed: Trajectory,
    fine: Trajectory | None = None,
    close: Trajectory | None = None,
    *,
    close_rad: float = 0.0,
) -> ReferenceSolution:
    """Reference solution of a scene from its runs of the reference.

    Parameters
    ----------
    scene : Scene
    solution : Trajectory
        At the tightest tolerance.
    check : Trajectory
        At a looser tolerance.
    perturbed : Trajectory
        From the start of :func:`with_perturbed_start`.
    fine : Trajectory, optional
        At dense samples; derivatives come from the samples of `solution` without it.
    close : Trajectory, optional
        From angles perturbed by `close_rad`, which is below double precision; with it the runs are those of extended
        precision.
    close_rad : float
    """
    parted, looser = differences(solution, perturbed), differences(solution, check)
    n = min(len(x.t_s) for x in (solution, check, perturbed, close) if x is not None)
    attitude = np.maximum.accumulate(parted["attitude"])[:n]
    amplification = attitude / attitude[0]
    if close is not None:
        amplification = amplification_of(solution, perturbed, close, close_rad)[:n]
    # errors of the track exceed its response to an attitude perturbed by 1e-10 rad: integrate it
    response = sensitivity(parted | track_response(scene, solution, perturbed), n, 0.0)
    for name, other in sensitivity({k: d for k, d in looser.items() if k not in TRACK}, n, PERTURBATION_RAD).items():
        # a perturbation in another direction, once it exceeds round-off
        response[name] = np.maximum(response[name], other)
    wide = np.zeros(n, bool)
    setting = f"rtol={SOLUTION_RTOL:g}"
    if close is not None:
        wide = solution.t_s[:n] <= float(solution.info[WIDE_UNTIL])
        until = "" if wide.all() else f" until {solution.info[WIDE_UNTIL]:.6g} s, then {setting}"
        setting = f"rtol={WIDE_RTOL:g} in extended precision{until}"
    error = truncation(scene, looser, response, np.where(wide, WIDE_RTOL, SOLUTION_RTOL))
    if close is not None:
        error = {name: ROUNDED_ALIKE * d for name, d in error.items()}
    for name, d in common_rounding(scene, solution, amplification, response, wide).items():
        error[name] = error[name] + d
    return ReferenceSolution(
        scene, solution, fine or solution, error, amplification, response, divergence_instant_s(solution, check),
        setting=setting,
    )  # fmt: skip


def truncation(scene: Scene, looser: dict[str, Array], response: dict[str, Array], rtol: Array) -> dict[str, Array]:
    """Error of the method for each quantity, (n,): the difference of two tolerances, and the tolerance of one step.

    Parameters
    ----------
    scene : Scene
    looser : dict of ndarray
        Differences from the run at a looser tolerance; with step control both may agree at a sample by chance.
    response : dict of ndarray, (n,)
        Change of each quantity per change of attitude.
    rtol : ndarray, shape (n,)
        Tolerance of the steps so far.
    """
    n = len(rtol)
    error = {name: np.maximum.accumulate(d)[:n] + rtol * response[name] for name, d in looser.items()}
    if scene.effects.gravity is not Gravity.NONE:  # a straight track has no error but round-off
        error["com"] += rtol * scene.radius0_m
        error["com_velocity"] += rtol * scene.speed0_m_s
    error["rate"] += rtol * scene.fastest_rate_rad_s
    return error


def common_rounding(
    scene: Scene, solution: Trajectory, amplification: Array, response: dict[str, Array], wide: NDArray[np.bool_]
) -> dict[str, Array]:
    """Error for each quantity, (n,), that runs at two tolerances share, so that their difference does not show it.

    Equal evaluations, as at an equilibrium, are rounded alike; samples and events are rounded to double precision.
    `wide` tells where the steps so far were in extended precision.
    """
    n = len(amplification)
    rounded, sizes = ROUNDED * UNIT_ROUNDOFF, {name: size[:n] for name, size in largest(solution).items()}
    struck = joint_condition(scene) if scene.effects.impulse else 1.0
    # impulses, faces and a shadow change the motion at instants that are computed in double precision
    has_events = bool(scene.effects.impulse or scene.effects.on_faces)
    shared_rad = np.where(wide & (not has_events), WIDE_RTOL, struck * rounded) * amplification
    error = {
        name: (1.0 if name in TRACK else struck) * rounded * sizes[name] + shared_rad * response[name]
        for name in response
    }
    if scene.effects.impulse:  # a rounded step of the velocity drifts along the orbit, by 3 t in Hill's equations
        turned_rad = 3.0 * scene.speed_rate_rad_s * solution.t_s[:n]
        error["com"] += 3.0 * rounded * sizes["com_velocity"] * solution.t_s[:n]
        error["com_velocity"] += rounded * sizes["com_velocity"] * turned_rad
    return error


def joint_condition(scene: Scene) -> float:
    """Condition number of the joint system at the start, in which impulses are solved in double precision."""
    along = unit_along(np.array(scene.chain.angle_rad))
    return condition_number(joint_matrix(chain_model(scene), 1j * along))


def amplification_of(solution: Trajectory, perturbed: Trajectory, close: Trajectory, close_rad: float) -> Array:
    """Error amplification, (n,), never falling: the larger of both perturbed runs'.

    The close start's difference counts where it exceeds the rounding of angles to double precision.
    """
    n = min(len(x.t_s) for x in (solution, perturbed, close))
    far, near = (np.maximum.accumulate(differences(solution, x)["attitude"][:n]) for x in (perturbed, close))
    assert solution.angle_rad is not None
    least = SEEN_ROUNDINGS * UNIT_ROUNDOFF * max(1.0, float(np.abs(solution.angle_rad).max()))
    grown: Array = np.maximum(far / far[0], np.where(near > least, near / close_rad, 0.0))
    return grown


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


def closely_sampled(scene: Scene) -> Scene:
    """`scene` with its own samples, and equally many between any two if they are too far apart for a comparison.

    Of two samples an orbit apart, the second sample of a chaotic run can't be predicted.
    """
    intervals = scene.run.samples - 1
    turning = scene.orbital_rate_rad_s * max(1.0, *map(abs, scene.chain.rate_factor))
    rate = max(2.0 * math.pi / scene.step_period_s, turning)
    wanted = math.ceil(scene.run.duration_s * rate / (MOST_TURNED_RAD * intervals))
    times = max(1, min(wanted, (MOST_SAMPLES - 1) // intervals))
    if times == 1:
        return scene
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=times * intervals + 1))


def at_own_samples(solution: ReferenceSolution, scene: Scene) -> ReferenceSolution:
    """Solution of a scene that is sampled closely, at the samples of the `scene` itself."""
    every = slice(None, None, (solution.scene.run.samples - 1) // (scene.run.samples - 1))
    return dataclasses.replace(
        solution,
        scene=scene,
        trajectory=solution.trajectory.samples(every),
        error={name: values[every] for name, values in solution.error.items()},
        amplification=solution.amplification[every],
        response={name: values[every] for name, values in solution.response.items()},
    )
