"""Errors of files that begin where no error of the scene does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.checks.restart import GRADIENT_SLACK
from barchain.judge.parted_track import EITHER_WAY
from barchain.judge.scales import scales
from barchain.metrics.model_difference import SECOND_MOMENT_ACCELERATION, stretched_inertia_kg_m2
from barchain.metrics.quantities import TRACK, differences, sizes

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array
    from barchain.result_files.samples import Samples


FEWEST_BEFORE = 8
"""Least samples before one at which a change is held against earlier ones; and the share of the file, its reciprocal"""
SMALLEST_CHANGE = 1e-9
"""Change between files, relative to a quantity's size, that earlier changes need not foretell"""
MOST_FASTER = 1e3
"""Largest ratio of a change to what earlier ones grow to: doubled times make that of a right method up to 16 times"""
MOST_MADE = 100.0
"""Error of several steps and of what amplifies beside the attitude, over that of one step of the request"""


def leaves_too_fast(main: Samples, rtol: float, noise_m: float) -> str:
    """Where a file that agrees leaves the solution beyond its own predictability limit, as a sentence; empty if not.

    A file of low accuracy has an early limit. The solution is known until a later one. At any time before, a step may
    have made an error of the request at which the file agrees, which the scene amplifies.

    Parameters
    ----------
    main : Samples
    rtol : float
        The request; 0 of a file that agrees to its digits.
    noise_m : float
        Error bar of the track that its author states.
    """
    if jump := track_jump(main, rtol, noise_m):
        return jump
    known = main.solution.trajectory.t_s <= main.solution.limit_s
    own = differences(main.trajectory, main.solution.trajectory)
    seen = {quantity: off[known[: len(off)]] for quantity, off in own.items() if quantity in main.judged}
    where = too_fast(main, seen, rtol)
    return f"the file leaves the solution {where}" if where else ""


def track_jump(main: Samples, rtol: float, noise_m: float) -> str:
    """Where the track leaves the solution at once, as a sentence; empty where all forces and errors allow it.

    Attitudes that have parted may move the track by metres in the end, but not from one row to the next. A difference d
    of two tracks bends by the field's gradient, at most 3 mu/r^3 times d, and by second moments at two attitudes. The
    rest is made by errors in each row: digits, the solution's error, and those of some steps of the request.

    Parameters
    ----------
    main : Samples
    rtol, noise_m : float
        As of :func:`leaves_too_fast`.
    """
    scene, t, solution = main.solution.scene, main.trajectory.t_s, main.solution
    if "com" not in main.judged or without_forecast(main) or len(t) < FEWEST_BEFORE:
        return ""
    apart, step_s = main.trajectory.com_m - solution.trajectory.com_m[: len(t)], np.diff(t)
    bent_m_s = np.linalg.norm(np.diff(np.diff(apart, axis=0) / step_s[:, None], axis=0), axis=1)
    off, radius = np.linalg.norm(apart, axis=1), np.linalg.norm(solution.trajectory.com_m[: len(t)], axis=1).min()
    field = scene.central_body.mu_m3_s2 / radius**3
    tilted = SECOND_MOMENT_ACCELERATION * field * stretched_inertia_kg_m2(scene) / scene.mass_kg / radius
    before, after = step_s[:-1], step_s[1:]
    # a difference of slopes is the integral of d'' under a hat from the row before to the one after
    under_hat = before * (off[:-2] + 2.0 * off[1:-1]) / 6.0 + after * (2.0 * off[1:-1] + off[2:]) / 6.0
    least_s = np.minimum(before, after)
    made_m = main.written["com"] + solution.error["com"][: len(t)] + MOST_MADE * rtol * scene.radius0_m + noise_m
    free_m = least_s * (GRADIENT_SLACK * field * under_hat + EITHER_WAY * tilted * 0.5 * (before + after))
    bent_m, allowed_m = least_s * bent_m_s, free_m + made_m[:-2] + 2.0 * made_m[1:-1] + made_m[2:]
    wrong = np.flatnonzero(bent_m > allowed_m)
    if not wrong.size:
        return ""
    return (
        f"the track leaves the solution by {bent_m[wrong[0]]:.3g} m from t = {t[wrong[0] + 1]:.6g} s to the next rows"
    )


def without_forecast(main: Samples) -> bool:
    """Whether an error may begin at a jump of forces."""
    effects = main.solution.scene.effects
    return bool(effects.breaks_s or effects.on_faces)


def too_fast(main: Samples, own: Mapping[str, Array], rtol: float = 0.0) -> str:
    """Where an error begins that grows faster than the scene lets errors grow, in words; empty where none does.

    What a change between files is taken for, an error, grows with the amplification, and slowly besides. Garbage
    begins at once. Scenes in which forces jump are left out: an error may begin at a jump.

    Parameters
    ----------
    main : Samples
    own : mapping
        Difference of the file from its finer one, or from the solution, by quantity, (n,).
    rtol : float
        Error that a step in between may have made, relative to a quantity's scale.
    """
    amplification = main.solution.amplification
    if without_forecast(main):
        return ""
    size, unit = sizes(main.solution.trajectory), scales(main.solution)
    for quantity, change in own.items():
        n = min(len(change), len(amplification))
        if quantity in TRACK or quantity not in size:
            continue
        least = SMALLEST_CHANGE * float(size[quantity].max()) + 2.0 * main.written[quantity]
        between = MOST_MADE * rtol * amplification * unit[quantity]
        for k in range(max(FEWEST_BEFORE, n // FEWEST_BEFORE), n):
            grown = float(change[: k // 2 + 1].max()) * amplification[k] / amplification[k // 2]
            if change[k] > max(MOST_FASTER * max(grown, float(least[k])), float(between[k])):
                when = main.trajectory.t_s[k]
                return f"at t = {when:.4g} s, in the {quantity}, far faster than errors grow in the scene"
    return ""
