"""Checks beyond the predictability limit: kinetic energy, segments from the engine's own states, samples in between.

Beyond the limit of a long run the reference restarts from some samples only (`barchain.judge.checks.restart`). At
samples in between two questions hardly need integration. Do the reactions belong to the engine's own state? Does each
angle grow from one sample to the next as its rates say? Where it seems not to, the reference restarts there too.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.reference_model import chain_model
from adapters.engine import EngineError
from barchain.judge.checks.more_judged import after_restarts
from barchain.judge.checks.restart import RTOL, compare_segment, restart_segments
from barchain.judge.parted_track import face_acceleration_m_s2
from barchain.judge.residuals import worst
from barchain.judge.scales import largest_entry
from barchain.judge.verdict import CheckFinding
from barchain.metrics.model_difference import stretched_inertia_kg_m2
from barchain.metrics.quantities import FIELDS, differences
from barchain.solutions.at_times import restarted_run
from reference_impl.model.invariants import relative_kinetic_energy
from reports.results.comparison import PARTED_RAD
from reports.results.outcome import Outcome
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.checks.restart import RestartSegment
    from barchain.judge.error_model import ErrorModel
    from barchain.judge.residuals import Residuals
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

MAX_EMPTY_SHARE = 0.75
"""Largest share of the segments beyond the limit that may predict no sample; in manoeuvres most do not"""
MAX_KINETIC_RATIO = 4.0
"""Largest kinetic energy about the centre of mass that is accepted, relative to the largest possible: twice every rate.

The largest possible energy is that of the judging solution, the energy that the tide can give a stretched chain between
lying along the orbit and standing upright, 3/2 n² I, and what drag and light can add. The bound therefore holds beyond
the predictability limit too, and for a chain that leaves an equilibrium on which the judging solution still rests.
"""
STATE_QUANTITIES = ("reaction", "torque")
"""Quantities that follow from a state alone"""
TINY = float(np.finfo(float).tiny)
FAR_ABOVE = 10.0
"""Largest rate of a bar relative to the median of the run that is not in doubt"""
UNDERSAMPLED = 4.0
"""Change of a rate inside an interval relative to that between its ends; in random scenes up to 1.2"""


def findings_beyond_limit(run: Residuals) -> tuple[list[CheckFinding], list[RestartSegment]]:
    """Findings beyond the predictability limit, and the segments that were compared; none where the run ends before."""
    first = int(np.count_nonzero(run.t <= run.limit_s)) - 1
    if first >= run.n - 1 or run.com_only:
        return [], []
    found = [energy_finding(run)]
    if run.main.angle_rad is None or run.main.rate_rad_s is None:
        said = f"no rates: nothing can be judged beyond the predictability limit, {run.limit_s:.4g} s"
        return [*found, CheckFinding("run", "outcome", outcome=Outcome.NOTHING_COMPARED, reason=said)], []
    try:
        segments = restart_segments(run.errors, run.main, first)
    except (EngineError, ArithmeticError) as error:
        said = f"the reference can't be restarted from the engine's states: {error}"
        return [*found, CheckFinding("run", "outcome", outcome=Outcome.NOTHING_COMPARED, reason=said)], []
    found += segment_findings(run, segments)
    empty = sum(s.empty for s in segments)
    if empty > MAX_EMPTY_SHARE * len(segments):
        said = (
            f"beyond the predictability limit, {run.limit_s:.4g} s, in {empty} of {len(segments)} segments the "
            f"next sample can't be predicted: the rates are too uncertain at {run.setting}"
            f"{after_restarts(run.errors, run.limit_s)}"
        )
        found.append(CheckFinding("run", "outcome", outcome=Outcome.TOO_COARSE, reason=said))
    if all(f.outcome.ok for f in found):
        found += uncovered_findings(run, segments, first)
    return found, segments


def energy_finding(run: Residuals) -> CheckFinding:
    """Kinetic energy about the centre of mass, relative to its largest possible value."""
    effects = run.scene.effects
    unlimited = effects.thrust or effects.impulse or effects.prescribed_rotation
    each = [] if unlimited else [kinetic_ratio(seen, run.solution) for seen in (run.main, run.finer)]
    ratio = max((r for r in each if r is not None), default=None)
    if ratio is None:
        return CheckFinding("relative_energy", "drift")
    good = Outcome.PASS if ratio <= MAX_KINETIC_RATIO else Outcome.EXCEEDS_BOUND
    reason = "" if ratio <= MAX_KINETIC_RATIO else f"{ratio:.3g} times the largest possible kinetic energy"
    return CheckFinding("relative_energy", "drift", ratio, MAX_KINETIC_RATIO, good, reason)


def kinetic_ratio(trajectory: Trajectory, solution: ReferenceSolution) -> float | None:
    """Largest kinetic energy about the centre of mass relative to the largest possible; None without attitude."""
    model, largest = chain_model(solution.scene), []
    for seen in (trajectory, solution.trajectory):
        if seen.angle_rad is None or seen.rate_rad_s is None:
            return None
        largest.append(float(relative_kinetic_energy(model, seen.angle_rad, seen.rate_rad_s).max()))
    mine, theirs = largest
    most = (math.sqrt(theirs + max_tidal_gain(solution)) + max_driven_gain(solution)) ** 2
    return mine / most if most > 0.0 else None


def max_tidal_gain(solution: ReferenceSolution) -> float:
    """Largest energy that the tide can give the chain, J: 3/2 n² I, n at its lowest, the chain stretched."""
    scene = solution.scene
    if scene.effects.gravity is Gravity.NONE:
        return 0.0
    lowest = float(np.linalg.norm(solution.trajectory.com_m, axis=1).min())
    return 1.5 * scene.central_body.mu_m3_s2 / lowest**3 * stretched_inertia_kg_m2(scene)


def max_driven_gain(solution: ReferenceSolution) -> float:
    """Largest gain of the square root of the kinetic energy T about the centre of mass by drag and light, sqrt(J).

    dT/dt is the sum of f_j . v_j over the bars, at most sqrt(sum f_j²/m_j) sqrt(2 T) by Cauchy and Schwarz. The forces
    are those on bars face on, along the orbit, and a bar has its share of the area.
    """
    scene, t = solution.scene, solution.fine.t_s
    wide = [each.width_m for each in scene.effects.on_faces]
    if not wide:
        return 0.0
    areas = [np.multiply(each, scene.chain.length_m) for each in wide]
    over_mass = max(float(np.sum((area / area.sum()) ** 2 / np.array(scene.chain.mass_kg))) for area in areas)
    force = scene.mass_kg * face_acceleration_m_s2(solution, t)
    return float(np.trapezoid(force, t)) * math.sqrt(0.5 * over_mass)


def segment_findings(run: Residuals, segments: list[RestartSegment]) -> list[CheckFinding]:
    """Largest ratio of each quantity to its bound in segments from the engine's own states.

    Outside the bound, rounding of absolute coordinates is no fault.
    """
    found = []
    for quantity in segments[0].difference if segments else ():
        each = [(*worst(s.difference[quantity], s.allowed[quantity], s.everywhere), s) for s in segments]
        used, at, segment = max(each, key=lambda e: e[0])
        if used <= 1.0:
            found.append(CheckFinding(quantity, "restart_ratio", used, 1.0, Outcome.PASS))
            continue
        limited = run.engine.coordinates.absolute and all(within_roundoff(run.errors, s, quantity) for s in segments)
        when, start = (run.main.t_s[k] for k in (segment.first + at, segment.first))
        reason = (
            f"{used:.3g} times the expected-error bound at t = {when:.6g} s, compared with the reference "
            f"restarted from the engine's own state at t = {start:.6g} s"
        )
        outcome = Outcome.ROUNDOFF_LIMITED if limited else Outcome.EXCEEDS_BOUND
        found.append(CheckFinding(quantity, "restart_ratio", used, 1.0, outcome, reason))
    return found


def within_roundoff(errors: ErrorModel, segment: RestartSegment, quantity: str) -> bool:
    """Whether the largest round-off of the coordinates since a segment's start explains its differences, too."""
    since = errors.amplification / errors.amplification[segment.first]
    most = errors.max_roundoff(since)[quantity][segment.first : segment.last + 1]
    return bool(np.all(segment.difference[quantity] <= segment.allowed[quantity] + most))


def uncovered_findings(run: Residuals, segments: list[RestartSegment], first: int) -> list[CheckFinding]:
    """First fault at samples that no segment covers, if there is one."""
    compared = (run.errors, run.main, segments, first)
    wrong = fault_between_segments(*compared, extra={})
    if wrong is None:
        return []
    quantity, used, reason = wrong
    outcome = Outcome.EXCEEDS_BOUND
    if run.engine.coordinates.absolute:
        most = run.errors.max_roundoff(np.ones(run.errors.n))  # nothing is amplified in a single state
        extra = {quantity: most[quantity] for quantity in STATE_QUANTITIES}
        limited = fault_between_segments(*compared, extra=extra) is None
        outcome = Outcome.ROUNDOFF_LIMITED if limited else Outcome.EXCEEDS_BOUND
    return [CheckFinding(quantity, "own_state_ratio", used, 1.0, outcome, reason)]


def fault_between_segments(
    errors: ErrorModel, trajectory: Trajectory, found: list[RestartSegment], first: int, extra: Mapping[str, Array]
) -> tuple[str, float, str] | None:
    """Quantity, ratio to its tolerance and reason of the first fault at samples that no segment covers, or None.

    `extra` is that of :func:`own_state_ratios`.
    """
    try:
        for k in doubtful_increments(errors.scene, trajectory, first):
            increment = compare_segment(errors, trajectory, int(k), int(k) + 1)
            # the same excuse as in whole segments: rounding of places as large as the orbit's radius
            rounded = extra and all(within_roundoff(errors, increment, name) for name in increment.allowed)
            if not increment.right and not rounded:
                used = {
                    name: worst(increment.difference[name], allowed, increment.everywhere)[0]
                    for name, allowed in increment.allowed.items()
                }
                name, when = max(used, key=lambda each: used[each]), trajectory.t_s[k + 1]
                said = f"it moves up to t = {when:.6g} s otherwise than its rates say, {used[name]:.3g} times the bound"
                return name, used[name], said
        ratios = own_state_ratios(errors, trajectory, found, first, extra)
    except (EngineError, ArithmeticError) as error:
        return "reaction", np.inf, f"no accelerations belong to the engine's own state: {error}"
    for name, (share, when) in ratios.items():
        if share > 1.0:
            said = f"{share:.3g} times the expected-error bound at t = {when:.6g} s, for the engine's own state there"
            return name, share, said
    return None


def doubtful_increments(scene: Scene, trajectory: Trajectory, first: int) -> NDArray[np.int_]:
    """Samples before the intervals in which an angle grows otherwise than its rates say, (k,).

    The trapezoidal rule is off by h³/12 times the rate's second derivative, of which the first and second differences
    of the rates next to the interval, times h and :data:`UNDERSAMPLED`, are an estimate, and
    :data:`barchain.solutions.reference.PARTED_RAD` is allowed. Samples far apart beside the motion hardly show that
    derivative: such intervals are not wrong, but in doubt. So are those next to a rate that is far above the rates of
    most samples: it would allow any angle. Intervals with an impulse are left out.
    """
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    t, angle, rate = trajectory.t_s, trajectory.angle_rad, trajectory.rate_rad_s
    if len(t) < 3:
        return np.zeros(0, int)
    h = np.diff(t)[:, None]
    off = np.abs(np.diff(angle, axis=0) - 0.5 * h * (rate[1:] + rate[:-1]))
    bent = np.abs(np.diff(rate, 2, axis=0))
    bent = np.concatenate([bent[:1], np.maximum(bent[1:], bent[:-1]), bent[-1:]])
    allowed = PARTED_RAD + UNDERSAMPLED * h * (np.abs(np.diff(rate, axis=0)) + bent)
    fastest = np.abs(rate).max(axis=1)
    usual = FAR_ABOVE * float(np.median(fastest))
    doubted = ~np.all(off <= allowed, axis=1) | (np.maximum(fastest[1:], fastest[:-1]) > usual)
    doubted[:first] = False
    for at in scene.effects.breaks_s:
        doubted[(t[:-1] <= at) & (at <= t[1:])] = False
    return np.flatnonzero(doubted)


def own_state_ratios(
    errors: ErrorModel, trajectory: Trajectory, found: list[RestartSegment], first: int, extra: Mapping[str, Array]
) -> dict[str, tuple[float, float]]:
    """Largest ratio of each of `STATE_QUANTITIES` to its tolerance at uncovered samples, and its instant, s.

    The tolerance relative to the quantity's size is that at the starts of the segments. `extra`, (n,) in the quantity's
    unit, is added at each sample.

    Raises
    ------
    EngineError
        If the reference has no accelerations for one of the states.
    """

    def reference_at(k: int) -> Trajectory:
        return restarted_run(errors.scene, trajectory, k, trajectory.t_s[k : k + 1], RTOL)

    def size(at: Trajectory, name: str) -> float:
        return largest_entry(getattr(at, FIELDS[name]))

    covered = np.zeros(min(errors.n, len(trajectory.t_s)), bool)
    covered[: first + 1] = True
    for s in found:
        covered[s.first : s.last + 1] = True
    left, highest = np.flatnonzero(~covered), dict[str, tuple[float, float]]()
    if not len(left) or not found:
        return highest
    names = [name for name in STATE_QUANTITIES if name in found[0].allowed]
    at_starts = [reference_at(s.first) for s in found]
    sizes = {name: [size(at, name) for at in at_starts] for name in names}
    shares = {
        name: max(float(s.allowed[name][0]) / max(z, TINY) for s, z in zip(found, sizes[name], strict=True))
        for name in names
    }
    for k in map(int, left):
        right = reference_at(k)
        apart = differences(trajectory.samples(slice(k, k + 1)), right)
        for name in names:
            allowed = shares[name] * max(size(right, name), float(np.median(sizes[name])))
            allowed += float(extra[name][k]) if name in extra else 0.0
            used = float(apart[name][0]) / max(allowed, TINY)
            if not used <= highest.get(name, (0.0, 0.0))[0]:  # not-a-number is worse than all
                highest[name] = (np.inf if np.isnan(used) else used, float(trajectory.t_s[k]))
    return highest
