"""Tasks of a round-off study for other processes, each some rows of one table."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from adapters.registry import ENGINES
from barchain.studies.roundoff.engines import engine_rows
from barchain.studies.roundoff.evaluation import longitude_rows, rows_of, time_rows
from barchain.studies.roundoff.states import EvaluationCase, StateKind
from barchain.studies.roundoff.third_parties import present
from barchain.studies.roundoff.trajectories import ScaledScene, chosen_step_rows, equal_step_rows, growth_rows
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

PARTS = ("evaluation", "trajectories", "engines", "times")
SCENE = "paper/fig15"  # the 80° chain turning with its orbit, which stays regular: what grows is round-off alone
DECADES = tuple(10.0**-k for k in range(2, 13))
REACH = 0.1  # of the Earth's radius, that the chain may span: a longer one would touch the ground
ALL, SHORT = ("float32", "float64", "long double"), ("float32", "float64")
COORDINATES = ("minimal", "relative", "absolute")
SWEEPS = {
    "exudyn": (4096, 12288, 36864, 122880),
    "exudyn-absolute": (4096, 12288, 36864, 122880),
    "exudyn-index3": (4096, 12288, 28672, 61440, 122880),
    "exudyn-absolute-index3": (4096, 12288, 28672, 61440, 122880),
    "pymunk": (4096, 16384, 98304, 163840, 262144),
    "pymunk-absolute": (4096, 16384, 57344, 102400, 163840),
    "mujoco": (4096, 24576, 122880),
    "pinocchio": (1e-6, 1e-9, 1e-12),
    "reference": (1e-6, 1e-9, 1e-12),
    "reference-absolute": (1e-6, 1e-9, 1e-12),
}
"""Steps in an orbit, or tolerances, of other engines: index 3 and pymunk from truncation far into round-off"""
FULL_STEPS = tuple(1024 * 2**k for k in range(8))
FULL_SWEEPS = {name: FULL_STEPS for name, values in SWEEPS.items() if values[0] > 1.0} | {
    "pymunk": (*FULL_STEPS, 262144, 524288)
}
PART, FULL_PART = 1.0 / 256.0, 1.0 / 64.0  # of an orbit: noise is there from the first steps on, and steps cost


@dataclass(frozen=True)
class RoundoffTask:
    """Some rows of a table, from a function that a process imports and calls."""

    table: str
    title: str
    function: Callable[..., list[dict[str, Any]]]
    """Of a module, so that a process can import it"""
    arguments: tuple[Any, ...]
    solution: ScaledScene | None = None
    """Whose high-precision solution is the function's first argument"""


def tasks_of(parts: Sequence[str], sizes: Sequence[float] = (), *, full: bool = False) -> tuple[RoundoffTask, ...]:
    """Tasks of some parts, which may run side by side; the times of evaluations are taken by others.

    Parameters
    ----------
    parts : sequence of str
        Of :data:`PARTS`.
    sizes : sequence of float
        Sizes at which one evaluation is judged, of :data:`DECADES`; all by default.
    full : bool
        Every size, arithmetic and number of bars, finer steps, longer runs: half an hour instead of minutes.

    Raises
    ------
    ValueError
        If a size is none of these.
    """
    check_sizes(sizes)
    tasks: list[RoundoffTask] = []
    if "evaluation" in parts:
        tasks += [*of_sizes(evaluations(full), sizes), *longitudes()]
    if "trajectories" in parts:
        tasks += [*growths(full), *trajectories(full)]
    if "engines" in parts:
        tasks += engines(full)
    return tuple(tasks)


def timed_tasks(parts: Sequence[str], *, full: bool = False) -> tuple[RoundoffTask, ...]:
    """Tasks whose times count: one evaluation in both coordinates."""
    bars = (5, 50, 500) if full else (5, 50)
    task = RoundoffTask("times", "relative over absolute", time_rows, (bars,))
    return (task,) if "times" in parts else ()


def check_sizes(sizes: Sequence[float]) -> None:
    """Reject sizes at which no evaluation is judged.

    Raises
    ------
    ValueError
        If there is one.
    """
    for size in sizes:
        if not any(math.isclose(size, known) for known in DECADES):
            raise ValueError(f"{size:g} given, allowed: powers of ten from {min(DECADES):g} to {max(DECADES):g}")


def of_sizes(tasks: list[RoundoffTask], sizes: Sequence[float]) -> list[RoundoffTask]:
    """Tasks of some sizes; all without sizes."""
    return [t for t in tasks if not sizes or any(math.isclose(t.arguments[0].ratio, size) for size in sizes)]


def evaluations(full: bool) -> list[RoundoffTask]:
    """One evaluation in all formulations; fewer where exact arithmetic takes long."""
    few, every = ("relative", "absolute"), ("relative", "minimal", "absolute", "absolute accelerations")
    ordinary = (StateKind.GENERIC, StateKind.STRAIGHT, StateKind.HORIZONTAL)
    found = [evaluation(k, 5, r, every, ALL) for k, r in itertools.product(StateKind, DECADES)]
    found += [
        evaluation(k, 2, r, every, ALL) for k, r in itertools.product(StateKind, DECADES if full else DECADES[::2])
    ]
    found += [evaluation(k, 5, r, production(), ("float64",)) for k, r in itertools.product(StateKind, DECADES)]
    others = itertools.product(ordinary[:2], DECADES) if present() else ()
    found += [evaluation(k, 5, r, present(), ("float64",)) for k, r in others]
    found += [evaluation(StateKind.STRAIGHT, 5, r, ("absolute positions", "relative positions"), ALL if full else SHORT)
              for r in (DECADES if full else DECADES[::2])]  # fmt: skip
    fifty = itertools.product(StateKind if full else ordinary, DECADES if full else DECADES[3::3])
    found += [evaluation(k, 50, r, few, ALL if full else SHORT) for k, r in fifty]
    hundreds = itertools.product(StateKind if full else ordinary[:2], DECADES[2:] if full else DECADES[3::3])
    found += [evaluation(k, 500, r, few, ALL if full else ("float64",)) for k, r in hundreds]
    return [t for t in found if t.arguments[0].bars * t.arguments[0].ratio <= REACH]


def production() -> tuple[str, ...]:
    """The reference, and its compiled form where that is installed."""
    return ("reference",) if ENGINES["reference-fast"].missing else ("reference", "reference-fast")


def evaluation(
    kind: StateKind, bars: int, ratio: float, formulations: tuple[str, ...], arithmetics: tuple[str, ...]
) -> RoundoffTask:
    """Errors of some formulations at one case."""
    title = f"{kind}, {bars} bars, {ratio:.0e}"
    arguments = (EvaluationCase(kind, bars, ratio), formulations, arithmetics)
    return RoundoffTask("evaluation", title, rows_of, arguments)


def longitudes() -> list[RoundoffTask]:
    """Errors by sector of the longitude."""
    return [
        RoundoffTask(
            "longitudes",
            f"longitudes, {kind}",
            longitude_rows,
            (EvaluationCase(kind, 5, 1e-5, 256), ("relative", "absolute"), SHORT),
        )
        for kind in (StateKind.GENERIC, StateKind.STRAIGHT)
    ]


def trajectories(full: bool) -> list[RoundoffTask]:
    """One orbit, at many steps and tolerances."""
    ratios = DECADES[1::1] if full else (1e-3, 1e-5, 1e-7, 1e-9)
    family = ScaledScene(load_scene(SCENE), ratios, 32)
    finest = {("rk4", "float64"): 13 if full else 9, ("rk4", "float32"): 7, ("dop853", "float64"): 7 if full else 6,
              ("dop853", "float32"): 4}  # fmt: skip
    found = []
    for (method, arithmetic), last in finest.items():
        for name, power in itertools.product(COORDINATES, range(1, last + 1)):
            if method == "rk4" and power > 8 and name != "absolute" and not full:
                continue  # truncation, which is the same in all coordinates, still rules there
            title = f"{name}, {arithmetic}, {method}, {2**power * family.samples} steps"
            arguments = (arithmetic, name, method, 2**power)
            found.append(RoundoffTask("trajectories", title, equal_step_rows, arguments, family))
    exponents = {"float64": range(3, 16, 1 if full else 2), "float32": range(2, 8)}
    for name, (arithmetic, powers) in itertools.product(COORDINATES, exponents.items()):
        rtols = tuple(10.0**-k for k in powers)
        title = f"{name}, {arithmetic}, dop853, own steps"
        found.append(RoundoffTask("trajectories", title, chosen_step_rows, (arithmetic, name, rtols), family))
    return found[::-1]  # the longest first


def growths(full: bool) -> list[RoundoffTask]:
    """Many orbits, at a step where truncation is below round-off."""
    orbits, ratios = (32, (1e-3, 1e-5, 1e-7)) if full else (5, (1e-3, 1e-5))
    family = ScaledScene(load_scene(SCENE), ratios, 32, orbits, 4 * orbits)
    return [
        RoundoffTask(
            "growth", f"{name}, float64, {orbits} orbits", growth_rows, ("float64", name, "dop853", 64), family
        )
        for name in COORDINATES
    ]


def engines(full: bool) -> list[RoundoffTask]:
    """Other engines, in both frames; an engine that is not installed gives a single row with the reason."""
    ratios = DECADES[1:8] if full else (1e-3, 1e-5, 1e-7)
    family = ScaledScene(load_scene(SCENE), ratios, 32, FULL_PART if full else PART)
    found = []
    for name, values in (SWEEPS | FULL_SWEEPS if full else SWEEPS).items():
        runs = [(0, values[0])] if ENGINES[name].missing else itertools.product(range(len(ratios)), values)
        found += [engine_run(family, name, size, value) for size, value in runs]
    return found


def engine_run(family: ScaledScene, name: str, size: int, value: float) -> RoundoffTask:
    """One engine at one size and setting."""
    title = f"{name}, {family.ratios[size]:.0e}, {value:g}"
    return RoundoffTask("engines", title, engine_rows, (name, size, value), family)
