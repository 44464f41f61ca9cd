"""Diagnosis beside an inconsistent verdict: sizes of the differences, and the mistakes that explain them."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.judge.diagnosis.diagnose import Diagnosis, diagnose
from barchain.judge.diagnosis.mistake import explained_words
from barchain.judge.diagnosis.own_motion import MOST_SAMPLES
from barchain.metrics.quantities import FIELDS, TRACK
from barchain.solutions.at_times import solution_at
from reports.results.comparison import EXPLAINED
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.own_motion import OwnRuns
    from barchain.judge.diagnosis.reading_search import Tolerance
    from barchain.judge.verdict import Row, Verdict
    from barchain.solutions.reference import ReferenceSolution

NORMALISED = "normalised_error"
UNEXPLAINED = "no known mistake that was tried explains it, and `barchain conform` tries more"
OPEN_RAD = 1.0
"""Tolerance of the attitude from which on a run is not compared: the engine's two runs have parted"""


def needs_diagnosis(verdict: Verdict) -> bool:
    """Whether a verdict calls a quantity inconsistent with the judging solution."""
    return verdict.outcome is Outcome.INCONSISTENT and any(map(is_inconsistent, verdict.rows))


def is_inconsistent(row: Row) -> bool:
    """Whether a row says that both errors do not explain a difference."""
    return bool(row["metric"] == NORMALISED and row["outcome"] == str(Outcome.INCONSISTENT))


def diagnosed_verdict(
    verdict: Verdict, trajectory: Trajectory, solution: ReferenceSolution, runs: OwnRuns | None = None
) -> Verdict:
    """Verdict whose inconsistent rows tell the size of the difference, and the first one the explanation.

    Parameters
    ----------
    verdict : Verdict
    trajectory : Trajectory
        Main run of the engine.
    solution : ReferenceSolution
        Judging solution.
    runs : callable, optional
        Dense runs of the engine, as of :func:`barchain.judge.diagnosis.diagnose.diagnose`.
    """
    if verdict.series is None or not needs_diagnosis(verdict):
        return verdict
    found = diagnosis_of_verdict(verdict, trajectory, solution, runs)
    return dataclasses.replace(verdict, rows=diagnosed_rows(verdict.rows, found))


def diagnosis_of_verdict(
    verdict: Verdict, trajectory: Trajectory, solution: ReferenceSolution, runs: OwnRuns | None = None, **absent: Any
) -> Diagnosis:
    """Diagnosis of a result that a verdict rejects; one inside its bounds is looked at by its explained error alone.

    Of a long result every k-th sample is looked at, as its own samples: the work grows with the square of their number.
    """
    every = thinned(len(trajectory.t_s))
    if every > 1:
        rows = slice(None, None, every)
        assert verdict.series is not None
        verdict = dataclasses.replace(verdict, series=verdict.series.iloc[rows])
        trajectory, runs = trajectory.samples(rows), None
        solution = solution_at(solution, solution.trajectory.t_s[rows])
    found = diagnose(solution.scene, trajectory, solution, verdict_tolerance(verdict), runs, **absent)
    if not found.inside_tolerances:
        return found
    return diagnose(solution.scene, trajectory, solution, verdict_tolerance(verdict, bounds=False), runs, **absent)


def thinned(samples: int) -> int:
    """Distance of the samples of a result that its diagnosis looks at: 1 for all of them."""
    return math.ceil((samples - 1) / (MOST_SAMPLES - 1)) or 1


def verdict_tolerance(verdict: Verdict, *, bounds: bool = True) -> Tolerance:
    """Tolerances of a verdict: explained error or expected-error bound, the larger one.

    Without `bounds` the explained error alone: a small wrong effect may stay inside the bound of a coarse setting. The
    tolerances of all but the track are infinite beyond the predictability limit, and from the sample on at which that
    of the attitude reaches :data:`OPEN_RAD`: a mistake may make a regular motion chaotic.
    """
    assert verdict.series is not None
    series = verdict.series
    limits = {row["quantity"]: row["limit_s"] for row in verdict.rows if row["metric"] == NORMALISED}
    found: dict[str, Array] = {}
    for name in (q for q in FIELDS if f"{q}_tolerance" in series):
        explained = series[f"{name}_tolerance"].to_numpy(float)
        larger = np.fmax(explained, series[f"{name}_bound"].to_numpy(float)) if bounds else explained
        beyond = np.isnan(larger)
        if name not in TRACK and limits.get(name) is not None:
            beyond |= series["t_s"].to_numpy(float) > limits[name]
        found[name] = np.where(beyond, np.inf, larger)
    if "attitude" in found:
        known = np.isfinite(found["attitude"])  # a sample that is left out opens nothing
        opened = np.logical_or.accumulate(known & (found["attitude"] >= OPEN_RAD))
        found = {q: v if q in TRACK else np.where(opened, np.inf, v) for q, v in found.items()}
    return found


def diagnosed_rows(rows: list[Row], diagnosis: Diagnosis) -> list[Row]:
    """Rows of a verdict with a diagnosis in the reasons of the inconsistent ones."""
    wrong = {w.quantity: w for w in diagnosis.wrong}
    told, new = bool(diagnosis.explanations), []
    said = f"{EXPLAINED}{explained_words(diagnosis.explanations, diagnosis.next_best)}" if told else UNEXPLAINED
    for row in rows:
        if is_inconsistent(row) and (row["quantity"] in wrong or said):
            size = wrong[row["quantity"]].words if row["quantity"] in wrong else ""
            new.append(row | {"reason": "; ".join(filter(None, (size, said, row["reason"])))})
            said = ""  # told once
        else:
            new.append(row)
    return new
