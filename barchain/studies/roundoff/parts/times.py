"""Cost of relative coordinates: time of an evaluation over that in absolute coordinates."""

from __future__ import annotations

import gc
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.runs.timing.divided_chain import SCENE, divided
from barchain.runs.timing.evaluation import batch_s, calibrated, numpy_loop
from barchain.runs.timing.statistics import interval
from barchain.studies.roundoff.formulations.states import EvaluationCase, StateKind, exact_case
from reference_impl.precision.arithmetic import ARITHMETICS, exact_numbers
from reference_impl.precision.formulations import absolute, relative
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable

TURNS, MEMBERS, LEAST_S = 9, 256, 0.02


@dataclass(frozen=True)
class Pair:
    """One evaluation in both coordinates."""

    code: str
    arithmetic: str
    bars: int
    relative: Callable[[int], None]
    absolute: Callable[[int], None]
    states: int = 1
    """Evaluated in one call"""

    def row(self) -> dict[str, Any]:
        """Row of times.csv; both are timed in turn, so that disturbances meet both."""
        counts = [calibrated(loop, LEAST_S) for loop in (self.relative, self.absolute)]
        gc.collect()
        gc.disable()
        try:
            times = np.array([[batch_s(f, n) / n for f, n in zip((self.relative, self.absolute), counts, strict=True)]
                              for _ in range(TURNS)]) / self.states  # fmt: skip
        finally:
            gc.enable()
        ours, theirs = np.median(times, axis=0)
        ratio = interval(float(ours / theirs), [(1.0, times[:, 0]), (-1.0, times[:, 1])])
        head = {"code": self.code, "arithmetic": self.arithmetic, "bars": self.bars, "turns": TURNS}
        spread = {"ratio": ratio.value, "low": ratio.low, "high": ratio.high}
        return head | {"relative_s": float(ours), "absolute_s": float(theirs)} | spread


def many_states(arithmetic: str, bars: int) -> Pair:
    """Both formulations of the study on many states at once."""
    a = ARITHMETICS[arithmetic]
    with exact_numbers():
        exact = exact_case(EvaluationCase(StateKind.GENERIC, bars, 1e-5, MEMBERS))
        chain, state, places = exact.bars.cast(a), exact.state.cast(a), exact.state.absolute.cast(a)

    def by_relative(times: int) -> None:
        for _ in range(times):
            relative(a, chain, state)

    def by_absolute(times: int) -> None:
        for _ in range(times):
            absolute(a, chain, places)

    return Pair("many states at once", arithmetic, bars, by_relative, by_absolute, MEMBERS)


def one_state(bars: int) -> Pair:
    """The reference's own right-hand sides, both with six unknowns a bar."""
    scene = divided(load_scene(SCENE), bars)
    return Pair("reference", "float64", bars, numpy_loop(scene, "redundant"), numpy_loop(scene, "absolute"))


def from_angles(bars: int) -> Pair:
    """Evaluation with positions computed from the angles, as the reference runs by default."""
    scene = divided(load_scene(SCENE), bars)
    code = "reference, places from angles"
    return Pair(code, "float64", bars, numpy_loop(scene, "minimal"), numpy_loop(scene, "absolute"))


def time_rows(bars: tuple[int, ...]) -> list[dict[str, Any]]:
    """Rows of times.csv."""
    pairs = [make(n) for n in bars for make in (one_state, from_angles, lambda n: many_states("float64", n),
                                                lambda n: many_states("float32", n))]  # fmt: skip
    return [pair.row() for pair in pairs]
