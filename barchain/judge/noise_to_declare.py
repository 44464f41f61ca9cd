"""Differences of the size of rounding that do not fall with the setting: round-off, and the noise to declare for it.

A sum of S steps or stages of numbers of size x is off by eps x S at most, if all roundings have one sign, and the error
grows from there. A mistake in the equations leaves the same error at two settings; rounding leaves another one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.scales import kepler_growth
from barchain.judge.verdict import JUDGED_METRICS
from barchain.metrics.quantities import TRACK, differences
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Coordinates
    from adapters.trajectory import Trajectory
    from barchain.judge.verdict import Verdict
    from barchain.solutions.reference import ReferenceSolution

ROUNDINGS = 1e4
"""Most roundings of one sign that add up: steps of a scene, times the stages of a step. An extrapolation of order 16 in
absolute coordinates was off by 4500"""
LEAST_SHARE = 0.5
"""Least ratio of the error at the finer setting to that at the judged one, of an error that does not fall"""
LEAST_APART = 0.5
"""Least difference of the two runs, relative to their error, of an error that is none of the equations"""
ACCEPTED = (Outcome.PASS, Outcome.REPORTED)
SPARE = 2.0
"""Noise to declare over the largest error that was seen"""
ROUND_OFF = "Round-off: the errors are of its size, and a finer setting gives others that are no smaller"


def round_off(
    verdict: Verdict, coordinates: Coordinates, main: Trajectory, finer: Trajectory, solution: ReferenceSolution
) -> dict[str, float]:
    """Noise to declare for the quantities that a verdict rejects, in their units; empty if an error is no round-off.

    Parameters
    ----------
    verdict : Verdict
    coordinates : Coordinates
        In which positions may have been rounded.
    main, finer : Trajectory
        Runs at the judged and at the finer setting.
    solution : ReferenceSolution
        Judging solution.
    """
    if len(main.t_s) != len(finer.t_s) or len(main.t_s) > len(solution.trajectory.t_s):
        return {}
    right, noise = solution.trajectory.samples(slice(len(main.t_s))), dict[str, float]()
    errors, finer_errors, apart = differences(main, right), differences(finer, right), differences(main, finer)
    rows = (r for r in verdict.rows if r["metric"] in JUDGED_METRICS and Outcome(r["outcome"]) not in ACCEPTED)
    limits = {row["quantity"]: row["limit_s"] for row in rows}
    for quantity, limit_s in limits.items():
        if quantity not in finer_errors:
            return {}
        inside = main.t_s <= limit_s  # two right runs part later
        error, other, between = (float(v[quantity][inside].max()) for v in (errors, finer_errors, apart))
        most = largest(quantity, coordinates, solution, int(np.count_nonzero(inside)))
        if other < LEAST_SHARE * error or between < LEAST_APART * error or not max(error, other) <= most:
            return {}
        noise[quantity] = SPARE * max(error, other)
        if quantity == "attitude":  # the declared noise is what the scene amplifies
            made = np.maximum(errors[quantity], finer_errors[quantity])[inside]
            noise[quantity] = SPARE * float((made / solution.amplification[: len(made)]).max())
    return noise


def largest(quantity: str, coordinates: Coordinates, solution: ReferenceSolution, samples: int) -> float:
    """Largest error by rounding of a quantity at some first samples, in its unit; 0 of one that is not known."""
    scene, seen, rows = solution.scene, solution.trajectory, slice(samples)
    unit = ROUNDINGS * float(np.finfo(float).eps)
    if quantity in TRACK:
        values = seen.com_m if quantity == "com" else seen.com_velocity_m_s
        grown = np.linalg.norm(values[rows], axis=1) * kepler_growth(scene, seen.t_s[rows] - seen.t_s[0])
        return unit * float(grown.max())
    if quantity not in solution.response:
        return 0.0
    ratio = scene.radius0_m / min(scene.chain.length_m) if coordinates.absolute else 1.0
    turned = 1.0 if seen.angle_rad is None else float(np.abs(seen.angle_rad[rows]).max())
    grown = solution.amplification[rows] * solution.response[quantity][rows]
    return unit * max(ratio, turned, 1.0) * float(grown.max())
