"""Checks of samples that no restart segment covers: reactions by the own state, increments of angles by the rates.

Beyond the predictability limit of a long run the reference restarts from some samples only
(`barchain.judge.checks.restart`). At samples in between two questions hardly need integration. Do the reactions belong
to the engine's own state? Does each angle grow from one sample to the next as its rates say? Where it seems not to, the
reference restarts there too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import EngineError
from barchain.judge.checks.restart import RTOL, RestartSegment, compare_segment, restarted_run
from barchain.metrics.quantities import differences
from reports.tables.crossval import PARTED_RAD

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.error_model import ErrorModel
    from scenarios import Scene

STATE_QUANTITIES = ("reaction", "torque")
"""Quantities that follow from a state alone"""
TINY = float(np.finfo(float).tiny)
UNDERSAMPLED = 4.0
"""Change of a rate inside an interval relative to that between its ends; in random scenes up to 1.2"""


def uncovered_samples(found: list[RestartSegment], n: int, first: int) -> NDArray[np.int_]:
    """Samples of n from `first` on that no segment compares, (k,)."""
    covered = np.zeros(n, bool)
    covered[: first + 1] = True
    for segment in found:
        covered[segment.first : segment.last + 1] = True
    return np.flatnonzero(~covered)


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
    left = uncovered_samples(found, min(errors.n, len(trajectory.t_s)), first)
    worst = dict[str, tuple[float, float]]()
    if not len(left) or not found:
        return worst
    names = [name for name in STATE_QUANTITIES if name in found[0].allowed]
    at_starts = [reference_at(errors.scene, trajectory, s.first) for s in found]
    sizes = {name: [size(at, name) for at in at_starts] for name in names}
    shares = {
        name: max(float(s.allowed[name][0]) / max(z, TINY) for s, z in zip(found, sizes[name], strict=True))
        for name in names
    }
    for k in map(int, left):
        right = reference_at(errors.scene, trajectory, k)
        apart = differences(trajectory.samples(slice(k, k + 1)), right)
        for name in names:
            allowed = shares[name] * max(size(right, name), float(np.median(sizes[name])))
            allowed += float(extra[name][k]) if name in extra else 0.0
            used = float(apart[name][0]) / max(allowed, TINY)
            if not used <= worst.get(name, (0.0, 0.0))[0]:  # not-a-number is worse than all
                worst[name] = (np.inf if np.isnan(used) else used, float(trajectory.t_s[k]))
    return worst


def reference_at(scene: Scene, trajectory: Trajectory, k: int) -> Trajectory:
    """Reference at sample `k` of a run: one sample."""
    return restarted_run(scene, trajectory, k, trajectory.t_s[k : k + 1], RTOL, 0.0)


def size(trajectory: Trajectory, name: str) -> float:
    """Largest absolute value of ``reaction`` or ``torque``, in its unit."""
    values = trajectory.reaction_N if name == "reaction" else trajectory.torque_N_m
    return 0.0 if values is None else float(np.abs(values).max(initial=0.0))


def doubtful_increments(scene: Scene, trajectory: Trajectory, first: int) -> NDArray[np.int_]:
    """Samples before the intervals in which an angle grows otherwise than its rates say, (k,).

    The trapezoidal rule is off by h³/12 times the rate's second derivative, of which the first and second differences
    of the rates next to the interval, times h and :data:`UNDERSAMPLED`, are an estimate, and
    :data:`barchain.solutions.reference.PARTED_RAD` is allowed. Samples far apart beside the motion hardly show that
    derivative: such intervals are not wrong, but in doubt. Intervals with an impulse are left out.
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
    doubted = ~np.all(off <= allowed, axis=1)
    doubted[:first] = False
    for at in scene.effects.breaks_s:
        doubted[(t[:-1] <= at) & (at <= t[1:])] = False
    return np.flatnonzero(doubted)


def fault_between_segments(
    errors: ErrorModel, trajectory: Trajectory, found: list[RestartSegment], first: int, extra: Mapping[str, Array]
) -> tuple[str, float, str] | None:
    """Quantity, ratio to its tolerance and reason of the first fault at samples that no segment covers, or None.

    `extra` is that of :func:`own_state_ratios`.
    """
    try:
        for k in doubtful_increments(errors.scene, trajectory, first):
            increment = compare_segment(errors, trajectory, int(k), int(k) + 1)
            if not increment.right:
                used = max(
                    float((increment.difference[name] / increment.allowed[name])[-1]) for name in increment.allowed
                )
                when = trajectory.t_s[k + 1]
                said = f"an angle grows up to t = {when:.6g} s otherwise than its rates say, {used:.3g} times the bound"
                return "attitude", used, said
        worst = own_state_ratios(errors, trajectory, found, first, extra)
    except (EngineError, ArithmeticError) as error:
        return "reaction", np.inf, f"no accelerations belong to the engine's own state: {error}"
    for name, (share, when) in worst.items():
        if share > 1.0:
            said = f"{share:.3g} times the expected-error bound at t = {when:.6g} s, for the engine's own state there"
            return name, share, said
    return None
