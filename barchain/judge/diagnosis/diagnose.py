"""Diagnosis of a result: whether it is wrong, where, and which mistakes explain it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import sizes_of
from barchain.judge.diagnosis.explanation import Explanation, indistinguishable
from barchain.judge.diagnosis.fit import QUANTITY_OF, given_result
from barchain.judge.diagnosis.search import FULL, MistakeSearch
from barchain.judge.diagnosis.words import WrongQuantity, diagnosis_words
from barchain.metrics.quantities import differences

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.judge.diagnosis.fit import GivenResult, Tolerance
    from barchain.judge.diagnosis.search import Effort
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

FEW_SAMPLES = 3
"""Samples up to which one wrong sample is nothing special"""


@dataclass(frozen=True)
class Diagnosis:
    """Mistakes that explain a wrong result."""

    wrong: tuple[WrongQuantity, ...]
    """Quantities outside their tolerances; empty for a result inside all tolerances"""
    explanations: tuple[Explanation, ...] = ()
    """Explanations with equal residuals, best first: indistinguishable on this scene"""
    next_best: Explanation | None = None
    """Best of the other mistakes that were tried"""
    parts: tuple[Explanation, ...] = ()
    """Mistakes that each explain some quantities alone, where nothing explains all"""

    @property
    def inside_tolerances(self) -> bool:
        """Whether no quantity is wrong."""
        return not self.wrong

    @property
    def names(self) -> frozenset[tuple[str, ...]]:
        """Names of the mistakes of each explanation."""
        return frozenset(e.names for e in self.explanations)

    def __str__(self) -> str:
        """The diagnosis in one sentence, or a sentence for each explanation."""
        return diagnosis_words(self.wrong, self.explanations, self.next_best, self.parts)


def diagnose(
    scene: Scene,
    trajectory: Trajectory,
    judging: ReferenceSolution,
    tolerance: Tolerance,
    effort: Effort = FULL,
) -> Diagnosis:
    """Find the mistakes that explain a wrong result.

    Each known mistake is applied to the right motion. A mistake explains the result if the altered motion agrees with
    the result within the tolerances in every quantity, and far better than the right motion does.

    Parameters
    ----------
    scene : Scene
        Scene that the engine was to run, with the samples of `judging`.
    trajectory : Trajectory
        Result of the engine, n samples.
    judging : ReferenceSolution
        Judging solution of the scene.
    tolerance : mapping of str to ndarray, shape (n,)
        Explained error of each quantity (``com`` m, ``com_velocity`` m/s, ``attitude`` rad, ``rate`` rad/s,
        ``reaction`` N, ``torque`` N m, ``impulse`` N s); infinite where a quantity is not compared.
    effort : Effort
        Extent of the search; everything by default.

    Returns
    -------
    Diagnosis
        Without mistakes if the result is inside the tolerances.

    Raises
    ------
    ValueError
        If `judging` is the solution of another scene.
    """
    if scene.digest != judging.scene.digest:
        raise ValueError(f"the judging solution is that of {judging.scene.name}, not of {scene.name}")
    result = given_result(trajectory, judging, tolerance)
    wrong = wrong_quantities(result)
    if not wrong or not result.finite:
        return Diagnosis(wrong)
    return searched(MistakeSearch(result, judging, effort), wrong)


def searched(search: MistakeSearch, wrong: tuple[WrongQuantity, ...]) -> Diagnosis:
    """Diagnosis by a search: mistakes alone, then pairs, then fitted numbers, then several at once."""
    without = search.unaltered.own_error
    explaining = [e for e in search.alone if e.explains(without)]
    others = [e for e in search.alone if not e.explains(without)]
    if not explaining:
        explaining = search.pairs or search.fitted or search.amounts
    equal = indistinguishable(explaining)
    if equal:
        return Diagnosis(wrong, equal, next((e for e in [*explaining[len(equal) :], *others]), None))
    parts, outside = search.in_parts, search.unaltered.outside
    if parts and outside == frozenset().union(*(t.altered for t in parts)):
        return Diagnosis(
            wrong, (Explanation(tuple(t.mistake for t in parts), search.merged_parts()),), next(iter(others), None)
        )
    alone = tuple(Explanation((t.mistake,), t.fit.of(t.altered)) for t in parts)
    return Diagnosis(wrong, (), next(iter(others), None), alone)


def wrong_quantities(result: GivenResult) -> tuple[WrongQuantity, ...]:
    """Quantities outside their tolerances, with the size of the difference; not-a-number is outside."""
    apart = differences(result.given, result.right)
    sizes = {QUANTITY_OF[field]: size for field, size in sizes_of(result.right).items()}
    found = []
    for name in (n for n in apart if n in result.quantities):
        inside = np.isfinite(result.tolerance[name])
        over = inside & ~(apart[name] <= result.tolerance[name])
        if over.any():
            first = int(np.argmax(over))
            alone = result.n > FEW_SAMPLES and np.count_nonzero(over) == 1
            counted = over if alone else inside
            largest, size = float(apart[name][counted].max()), float(sizes[name][inside].max(initial=0.0))
            found.append(WrongQuantity(name, largest, size, first, float(result.right.t_s[first]), alone))
    return tuple(found)
