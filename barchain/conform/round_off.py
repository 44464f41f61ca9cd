"""Differences of the size of rounding that do not fall with the setting: round-off, and the noise to declare for it.

A sum of S steps or stages of numbers of size x is off by eps x S at most, if all roundings have one sign, and the error
grows from there. A mistake in the equations leaves the same error at two settings; rounding leaves another one.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import Coordinates
from barchain.judge.diagnosis.mistake import QUANTITY_WORDS
from barchain.judge.verdict import JUDGED_METRICS
from barchain.metrics.quantities import TRACK, differences
from reports.tables.crossval import QUANTITY_UNITS
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from barchain.judge.evidence import Evidence
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


def round_off(verdict: Verdict, coordinates: Coordinates, evidence: Evidence, solution: ReferenceSolution) -> str:
    """Words on errors that are round-off, with the noise to declare; empty if they are not.

    Parameters
    ----------
    verdict : Verdict
        Tells the quantities that it rejects.
    coordinates : Coordinates
        Of the engine.
    evidence : Evidence
        Runs at the judged and at the finer setting.
    solution : ReferenceSolution
        Judging solution.
    """
    main, finer = evidence.main.trajectory, evidence.finer.trajectory
    if main is None or finer is None or len(main.t_s) != len(finer.t_s) or len(main.t_s) > len(solution.trajectory.t_s):
        return ""
    n = len(main.t_s)
    right = solution.trajectory.samples(slice(n))
    errors, finer_errors, apart = differences(main, right), differences(finer, right), differences(main, finer)
    most, noise = largest(coordinates, solution, n), dict[str, float]()
    rows = (r for r in verdict.rows if r["metric"] in JUDGED_METRICS and Outcome(r["outcome"]) not in ACCEPTED)
    for quantity in dict.fromkeys(row["quantity"] for row in rows):
        if quantity not in most or quantity not in finer_errors:
            return ""
        error, other = (float(np.max(found[quantity])) for found in (errors, finer_errors))
        falls = other < LEAST_SHARE * error
        if falls or float(np.max(apart[quantity])) < LEAST_APART * error or max(error, other) > most[quantity]:
            return ""
        noise[quantity] = SPARE * max(error, other)
    if not noise:
        return ""
    said = ", ".join(f"{q} = {size:.1e} ({QUANTITY_UNITS[q]} of the {QUANTITY_WORDS[q]})" for q, size in noise.items())
    size = "the errors are of its size, and a finer setting gives others that are no smaller"
    return f"Round-off: {size}; declare `noise` of {said}"


def largest(coordinates: Coordinates, solution: ReferenceSolution, samples: int) -> dict[str, float]:
    """Largest error by rounding of each quantity at some first samples, in its unit."""
    scene, t = solution.scene, solution.trajectory
    unit = ROUNDINGS * float(np.finfo(float).eps)
    ratio = scene.radius0_m / min(scene.chain.length_m) if coordinates is Coordinates.ABSOLUTE else 1.0
    turned = np.abs(t.angle_rad[:samples]).max() if t.angle_rad is not None else 1.0
    attitude = unit * max(ratio, float(turned), 1.0) * solution.amplification[:samples]
    found = {q: float(np.max(attitude * values[:samples])) for q, values in solution.response.items() if q not in TRACK}
    track = {"com": t.com_m, "com_velocity": t.com_velocity_m_s}
    found |= {q: unit * float(np.linalg.norm(v[:samples], axis=1).max()) for q, v in track.items() if q in TRACK}
    return {q: size for q, size in found.items() if math.isfinite(size)}
