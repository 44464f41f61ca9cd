"""Samples that no stretch covers: each by itself, and each increment by its rates.

Beyond the predictability limit of a long run the reference is restarted here and there only (`barchain.restart`). At
the samples in between no integration is needed to ask two things: are the reactions those that belong to the engine's
own state there, and does each angle grow from one sample to the next by what its rates say?
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import EngineError
from barchain.quantities import differences
from barchain.restart import RTOL, Stretch, walked
from barchain.truth import PARTED_RAD

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from adapters.engine import Array, Trajectory
    from barchain.error_model import ErrorModel
    from scenarios import Scene

OF_A_STATE = ("reaction", "torque")
"""Quantities that a state decides"""
TINY = float(np.finfo(float).tiny)
UNDERSAMPLED = 4.0  # a swing between two samples changes rates more than its ends show; 1.2 in random scenes


def uncovered(found: list[Stretch], n: int, first: int) -> NDArray[np.int_]:
    """Samples of n from `first` on that no stretch compares."""
    covered = np.zeros(n, bool)
    covered[: first + 1] = True
    for stretch in found:
        covered[stretch.first : stretch.last + 1] = True
    return np.flatnonzero(~covered)


def own_states(
    errors: ErrorModel, seen: Trajectory, found: list[Stretch], first: int, room: Mapping[str, Array]
) -> dict[str, tuple[float, float]]:
    """Largest share of its allowance that each of `OF_A_STATE` uses at uncovered samples, and when, s.

    What is allowed at the starts of the stretches, over the size of the quantity there, is allowed everywhere; `room`
    adds to it at each sample of the reference solution, in the quantity's unit.

    Raises
    ------
    EngineError
        If the reference has no accelerations for one of the states.
    """
    left = uncovered(found, min(errors.n, len(seen.t_s)), first)
    worst = dict[str, tuple[float, float]]()
    if not len(left) or not found:
        return worst
    names = [name for name in OF_A_STATE if name in found[0].allowed]
    at_starts = [state_of(errors.scene, seen, s.first) for s in found]
    sizes = {name: [size(at, name) for at in at_starts] for name in names}
    shares = {
        name: max(float(s.allowed[name][0]) / max(z, TINY) for s, z in zip(found, sizes[name], strict=True))
        for name in names
    }
    for k in map(int, left):
        right = state_of(errors.scene, seen, k)
        apart = differences(seen.samples(slice(k, k + 1)), right)
        for name in names:
            allowed = shares[name] * max(size(right, name), float(np.median(sizes[name])))
            allowed += float(room[name][k]) if name in room else 0.0
            used = float(apart[name][0]) / max(allowed, TINY)
            if not used <= worst.get(name, (0.0, 0.0))[0]:  # not-a-number is worse than all
                worst[name] = (np.inf if np.isnan(used) else used, float(seen.t_s[k]))
    return worst


def state_of(scene: Scene, seen: Trajectory, k: int) -> Trajectory:
    """The reference at a sample of a run."""
    return walked(scene, seen, k, seen.t_s[k : k + 1], RTOL, 0.0)


def size(seen: Trajectory, name: str) -> float:
    """Largest size of a quantity."""
    values = seen.reaction_N if name == "reaction" else seen.torque_N_m
    return 0.0 if values is None else float(np.abs(values).max(initial=0.0))


def increments(scene: Scene, seen: Trajectory, first: int) -> tuple[float, float]:
    """Largest share of its allowance that an angle's increment uses against its rates, from a sample on, and when, s.

    The trapezoidal rule is off by h³/12 times the rate's second derivative, which samples as wide apart as some tenths
    of a turn hardly show: the rates' first and second differences next to the interval are allowed, times h and
    :data:`UNDERSAMPLED`, and :data:`barchain.truth.PARTED_RAD`. So this sees jumps of an angle, and angles that rest
    while rates go on. Where a blow makes rates jump, nothing is said.
    """
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    t, angle, rate = seen.t_s, seen.angle_rad, seen.rate_rad_s
    if len(t) < 3:
        return 0.0, 0.0
    h = np.diff(t)[:, None]
    off = np.abs(np.diff(angle, axis=0) - 0.5 * h * (rate[1:] + rate[:-1]))
    bent = np.abs(np.diff(rate, 2, axis=0))
    bent = np.concatenate([bent[:1], np.maximum(bent[1:], bent[:-1]), bent[-1:]])
    share = off / (PARTED_RAD + UNDERSAMPLED * h * (np.abs(np.diff(rate, axis=0)) + bent))
    share = share.max(axis=1)
    share[np.isnan(share)] = np.inf
    share[:first] = 0.0
    for at in scene.effects.breaks_s:
        share[(t[:-1] <= at) & (at <= t[1:])] = 0.0
    k = int(np.argmax(share))
    return float(share[k]), float(t[k + 1])


def wrong_between(
    errors: ErrorModel, seen: Trajectory, found: list[Stretch], first: int, room: Mapping[str, Array]
) -> tuple[str, float, str] | None:
    """Quantity, share of its allowance and words of what is most wrong at samples that no stretch covers, or None.

    `room` is what :func:`own_states` allows besides.
    """
    used, when = increments(errors.scene, seen, first)
    if used > 1.0:
        said = f"an angle's increment up to t = {when:.6g} s is {used:.3g} times farther off its rates than allowed"
        return "attitude", used, said
    try:
        worst = own_states(errors, seen, found, first, room)
    except (EngineError, ArithmeticError) as error:
        return "reaction", np.inf, f"no accelerations belong to the engine's own state: {error}"
    for name, (share, when) in worst.items():
        if share > 1.0:
            said = f"{share:.3g} times the expected-error bound at t = {when:.6g} s, for the engine's own state there"
            return name, share, said
    return None
