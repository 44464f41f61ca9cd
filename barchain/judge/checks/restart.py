"""Restarts of the reference from an engine's own states: the comparison beyond the predictability limit.

Two correct runs of a chaotic scene part. An engine's samples still have to follow the equations of motion from one
sample to the next, and for as long as errors do not grow too large. Beyond the limit the reference therefore restarts
from the engine's last sample that was found right. The next segment of the engine's run is compared with the restarted
reference, as far as the restart's predictability limit, and so on. Garbage shows in the segment in which it begins.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, Setting
from adapters.reference.numpy_engines import Reference
from barchain.judge.error_model import ErrorModel
from barchain.judge.local_errors import resolving_s
from barchain.judge.scales import MACHINE_EPSILON, MAX_ATTITUDE_NOISE_RAD, NORM_SLACK, largest_entry
from barchain.metrics.quantities import TRACK, completed, differences, own_rate
from barchain.solutions.at_times import restarted_run
from barchain.solutions.reference import (
    SOLUTION_RTOL,
    ReferenceSolution,
    dense_parts,
    perturbation_directions,
    sensitivity,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

RTOL = 1e-8
"""Requested accuracy of a restart; its error is counted too, and the segment ends where that may be as large as parted
runs are"""
TIGHTER = 0.1
"""Requested accuracy of a restart relative to that of an engine that chooses its steps"""
PERTURBATION_RAD = (1e-10, 3e-5)
"""Least and largest perturbation of a restart's perturbed run. In between it is the engine's own error before
amplification: a larger one leaves the linear range while the engine can still be compared. The least is that of the
judging solution: below it the run shows its own errors"""
PERTURBED_SHARE = 1.0 / 30.0
"""Requested accuracy of the perturbed run relative to its perturbation: only the distance is used, to some per cent"""
LINEAR_RAD = 0.1
"""Distance of the perturbed run up to which it measures an amplification; the segment ends there"""
FASTER_BETWEEN = 2.0
"""Largest rate of a bar between samples, relative to that at samples"""
LOOK_AHEAD = 2.0
"""Samples that the reference computes ahead, relative to the length of the segment before"""
FIRST_SEGMENT_SHARE = 0.2
"""Length of the first segment relative to the run up to the predictability limit: an engine's samples have errors of
reading, exact initial values have none"""
CONSECUTIVE = 7
"""Consecutive segments from the predictability limit on"""
SCATTERED = 15
"""Segments spread over the rest of the run, where the consecutive ones do not reach its end"""
GRADIENT_SLACK = 3.0
"""Gradient of gravity over mu/r³: 2 along the radius, and a half of that for the other fields"""
JUDGED = ("attitude", "rate", "reaction", "torque", "impulse")


@dataclass(frozen=True)
class RestartSegment:
    """Segment of an engine's run, compared with the reference restarted from the engine's own state; m samples."""

    first: int
    """Sample that the reference starts from"""
    difference: dict[str, Array]
    """(m,) for each quantity, from sample `first` on, in its unit"""
    allowed: dict[str, Array]
    """(m,) bound of the difference of two correct runs. An engine's samples need not be the state that it goes on from:
    rates are read half a step aside, or from impulses that are noise"""

    @property
    def last(self) -> int:
        """Last sample compared; equal to `first` where not even the next sample can be predicted."""
        return self.first + len(next(iter(self.difference.values()))) - 1

    @property
    def empty(self) -> bool:
        """Whether no sample after the first could be predicted."""
        return self.last == self.first

    @property
    def everywhere(self) -> NDArray[np.bool_]:
        """Mask of all samples of the segment, (m,)."""
        return np.ones(self.last - self.first + 1, bool)

    @property
    def right(self) -> bool:
        """Whether all differences are inside their bounds."""
        return all(np.all(self.difference[name] <= self.allowed[name]) for name in self.difference)


def restart_segments(errors: ErrorModel, trajectory: Trajectory, first: int) -> list[RestartSegment]:
    """Segments of a run from sample `first` on, until a segment is outside its bound or the run ends.

    Each starts from the engine's own state, so that segments need not follow on each other. Where the run is longer
    than :data:`CONSECUTIVE` of them, :data:`SCATTERED` more are spread over the rest. A persistent error is met by a
    segment, wherever it began. A single wrong sample may fall in between.

    Parameters
    ----------
    errors : ErrorModel
        Of the engine at its setting in the scene.
    trajectory : Trajectory
        Run of the engine.
    first : int
        Last sample that is known to be right.

    Raises
    ------
    EngineError
        If the reference can't go on from one of the engine's states.
    """
    found = consecutive_segments(errors, trajectory, first)
    reached, end = found[-1].last if found else first, len(trajectory.t_s) - 1
    if reached >= end or not all(s.right for s in found):
        return found
    length = max(1, round(np.mean([s.last - s.first for s in found])))
    latest = max(end - length, reached)
    for planned in scattered_starts(errors.scene, reached, latest):
        start = max(planned, found[-1].last)
        if start >= end or not found[-1].right:
            break
        if planned in (start, latest):  # covered samples need no other segment, except the run's end
            found.append(compare_segment(errors, trajectory, start, min(end, start + samples_tried(length))))
    return found


def scattered_starts(scene: Scene, reached: int, latest: int) -> list[int]:
    """First samples of scattered segments: one at random in each equal part of the rest, the last at its end.

    They are drawn with a seed from the scene: they are the same in every run, and no recurring fault can fall between
    all of them.
    """
    edges = np.linspace(reached, latest, SCATTERED)
    shift = np.random.default_rng(list(scene.digest.encode())).uniform(0.0, 1.0, SCATTERED - 1)
    starts = edges[:-1] + shift * np.diff(edges)
    return [*starts.astype(int).tolist(), latest]


def consecutive_segments(errors: ErrorModel, trajectory: Trajectory, first: int) -> list[RestartSegment]:
    """Segments of a run from sample `first` on, each from the end of the one before, at most :data:`CONSECUTIVE`."""
    end = len(trajectory.t_s) - 1
    found: list[RestartSegment] = []
    ahead = max(FIRST_SEGMENT_SHARE * first, 1.0)
    while first < end and len(found) < CONSECUTIVE:
        segment = compare_segment(errors, trajectory, first, min(end, first + samples_tried(ahead)))
        found.append(segment)
        if not segment.right:
            break
        ahead = max(segment.last - first, 1.0)
        first = max(segment.last, first + 1)
    return found


def samples_tried(samples: float) -> int:
    """Samples that the reference computes where about `samples` are expected to be predictable."""
    return max(2, math.ceil(LOOK_AHEAD * samples))


def compare_segment(errors: ErrorModel, trajectory: Trajectory, first: int, last: int) -> RestartSegment:
    """Compare samples `first` to `last` of a run, as far as they can be predicted from the first.

    A value read from a step may belong to the motion before the first sample, such as the end of a manoeuvre or what
    dampers have slowed, and its ringing lasts where the method damps nothing. In such scenes the errors of reading of
    the whole run up to the first sample are allowed besides. In a manoeuvre and just after it they are errors of the
    state, too. The perturbation that measures amplification is the engine's error at the predictability limit before
    amplification.
    """
    scene, setting = errors.scene, errors.setting
    rtol = min(RTOL, TIGHTER * setting.value) if setting.parameter is AccuracyParameter.RTOL else RTOL
    limit = int(np.count_nonzero(errors.t_s <= errors.limit_s)) - 1
    unamplified_rad = float(errors.attitude_rad[limit] / errors.amplification[limit])
    aside_rad = float(np.clip(unamplified_rad, *PERTURBATION_RAD))
    restarted = restarted_solution(
        errors.solution, trajectory, first, trajectory.t_s[first : last + 1], max(rtol, SOLUTION_RTOL), aside_rad,
        lambda rate: resolving_s(errors.engine, setting, scene, FASTER_BETWEEN * rate),
    )  # fmt: skip
    joints = scene.effects.joint_spring_damper
    slowed = joints is not None and any(joints.damping_N_m_s_rad)
    shown = errors.local.immediate if scene.effects.breaks_s or slowed else {}
    before = {name: float(values[min(first, errors.n - 1)]) for name, values in shown.items()}
    model = restarted_model(errors, restarted, trajectory, first, before.get("rate", 0.0))
    n = int(np.count_nonzero(model.t_s <= model.limit_s))
    rows = trajectory.samples(slice(first, last + 1))
    if rows.impulse_N_s is not None:  # the restarted reference counts its impulses from its own start
        rows = rows.replace(impulse_N_s=rows.impulse_N_s - rows.impulse_N_s[0])
    rows = completed(rows, errors.absent, restarted.trajectory)
    apart, allowed = differences(rows, restarted.trajectory), {}
    pull = pull_on_gaps(scene, trajectory, first, model.n)
    for name in (q for q in JUDGED if q in apart):
        bound = model.bound[name] + restarted.error[name] + NORM_SLACK * before.get(name, 0.0)
        allowed[name] = (bound + pull[name] if name in pull else bound)[:n]
    return RestartSegment(first, {name: apart[name][:n] for name in allowed}, allowed)


def restarted_between(errors: ErrorModel, k: int, parts: int) -> ErrorModel:
    """Error model from a sample of the judging solution to the next one, at dense instants: before any run is made.

    Raises
    ------
    EngineError
        If the reference can't go on from there.
    """
    solution, engine, setting = errors.solution, errors.engine, errors.setting
    start_s, end_s = map(float, solution.trajectory.t_s[k : k + 2])
    times = np.linspace(start_s, end_s, parts + 1)
    made = restarted_solution(
        solution, solution.trajectory, k, times, SOLUTION_RTOL, PERTURBATION_RAD[0],
        lambda rate: resolving_s(engine, setting, errors.scene, FASTER_BETWEEN * rate),
    )  # fmt: skip
    return restarted_model(errors, made, made.trajectory, 0, 0.0)


def restarted_model(
    whole: ErrorModel, restarted: ReferenceSolution, run: Trajectory, first: int, read_before: float
) -> ErrorModel:
    """Error model of an engine from sample `first` of its `run` on, where its own samples are the initial state.

    The error of that state is an angle: the error of reading of a rate, at least `read_before` (rad/s) in a manoeuvre;
    declared noise of the rates; and the rounding of the sample, a unit in the last place of the angles and of the
    instant.
    """
    assert run.angle_rad is not None
    assert run.rate_rad_s is not None
    model = type(whole)(whole.engine, whole.setting, restarted, run)
    if first + model.n <= whole.n:  # asking the engine's class again may take a process each time
        model.declared_noise = {k: values[first : first + model.n] for k, values in whole.declared_noise.items()}
    reading = float(model.local.immediate["rate"][0])
    if during_manoeuvre(whole.scene, run.t_s, first):
        reading = max(reading, read_before)
    turned = np.abs(run.rate_rad_s[first]).max() * run.t_s[first]
    stored_rad = MACHINE_EPSILON * float(np.abs(run.angle_rad[first]).max() + turned)
    # before the first member that depends on it is asked for
    model.start_rad = reading / own_rate(whole.scene) + declared_noise_rad(whole, first) + stored_rad
    return model


def pull_on_gaps(scene: Scene, run: Trajectory, first: int, n: int) -> dict[str, Array]:
    """Reaction (N) and torque (N m) that the tide on open joints makes, (n,) each from sample `first` on.

    The reference restarts from the angles, which put all bars in place. Bars that stand apart by the sum of the gaps
    feel the gradient of gravity over that distance besides: at most 3 mu/r³ for each unit of mass, which leaves room
    for the other fields and the gradient's torque. Gaps count only with the bars' places, from which they are computed:
    a reported number alone would make room.
    """
    if run.gap_m is None or run.position_m is None:
        return {}
    rows = slice(first, first + n)
    gradient = GRADIENT_SLACK * scene.central_body.mu_m3_s2 / np.linalg.norm(run.com_m[rows], axis=1) ** 3
    force: Array = scene.mass_kg * gradient * run.gap_m[rows].sum(axis=1)
    return {"reaction": force, "torque": force * max(scene.chain.length_m)}


def during_manoeuvre(scene: Scene, t_s: Array, first: int) -> bool:
    """Whether a bar is being turned at a sample, or equations of motion changed within two sample intervals before."""
    earliest, now = t_s[max(first - 2, 0)], t_s[first]
    turns = [turn for law in scene.effects.prescribed_rotation for turn in law.turns]
    turned = any(turn.start_s <= now and earliest <= turn.end_s for turn in turns)
    return turned or any(earliest <= at <= now for at in scene.effects.breaks_s)


def declared_noise_rad(errors: ErrorModel, first: int) -> float:
    """Declared noise of the rates of a sample, as an angle, rad: as far as noise of the attitude would be believed.

    The floor of the run does not count: round-off since the start is part of the state that the engine goes on from.
    """
    rate = errors.noise.get("rate")
    said = 0.0 if rate is None else float(rate[min(first, errors.n - 1)]) / own_rate(errors.scene)
    return min(said, MAX_ATTITUDE_NOISE_RAD)


def restarted_solution(
    solution: ReferenceSolution,
    trajectory: Trajectory,
    first: int,
    times: Array,
    rtol: float,
    aside_rad: float,
    resolving: Callable[[float], float],
) -> ReferenceSolution:
    """Reference solution from a sample of a run on, at instants (m,) s, with error amplification and its own error.

    The amplification is the largest of perturbations by `aside_rad` in the directions of :func:`directions`, up to
    :data:`LINEAR_RAD`. The limit is no later than the restart's own at `rtol`. `resolving` gives the largest distance
    of dense samples, s, for a rate of the bars, rad/s.
    """
    scene = solution.scene
    loose = max(rtol, PERTURBED_SHARE * aside_rad)
    asides = [restarted_run(scene, trajectory, first, times, loose, aside_rad * d) for d in directions(scene.bars)]
    fastest = max(largest_entry(aside.rate_rad_s) for aside in asides)
    # as dense as this stretch needs: samples that a long run can afford pass over bars that fold through each other
    between = dense_parts(scene, float(times[-1] - times[0]), len(times) - 1, resolving(fastest))
    closely = np.interp(np.arange((len(times) - 1) * between + 1) / between, np.arange(len(times)), times)
    closely[::between] = times
    fine = restarted_run(scene, trajectory, first, closely, rtol)
    main = fine.samples(slice(None, None, between))
    n = min(len(run.t_s) for run in (main, *asides))
    parted = [differences(main, aside) for aside in asides]
    attitude = np.maximum.accumulate([found["attitude"][:n] for found in parted], axis=1)
    linear = max(int(np.count_nonzero(attitude.max(axis=0) <= LINEAR_RAD)), 1)
    responses = [sensitivity(found, n, 0.0) for found in parted]
    response = {name: np.max([found[name] for found in responses], axis=0) for name in responses[0]}
    response |= {name: np.zeros(n) for name in TRACK}
    amplification = np.max(attitude / attitude[:, :1], axis=0)
    made = ReferenceSolution(scene, main, fine, {}, amplification, response, float(main.t_s[linear - 1]))
    own = ErrorModel(Reference.declarations(), Setting(AccuracyParameter.RTOL, rtol), made, main)
    return dataclasses.replace(made, error=own.bound, limit_s=own.limit_s)


def directions(bars: int) -> list[Array]:
    """Directions of perturbation of angles and rates, each (2, N).

    Within an orbit errors grow by a factor that depends on their direction: between 35 and 1700 where two bars fold.
    Angles that turn together and against each other are therefore tried, each with the rates in both signs: the larger
    of a sum and a difference is at least as large as each of its parts.
    """
    angle, rate = perturbation_directions(bars)
    against = (-1.0) ** np.arange(bars)
    return [np.stack([a * angle, sign * a * rate]) for a in (np.ones(bars), against) for sign in (1.0, -1.0)]
