"""Time of the parts of an evaluation and a step of the compiled reference.

    python benchmarks/profile_fast.py

Least of many short repeats, ns. Parts are timed alone, in loops of their own: what they share in a whole evaluation
(values still in registers, work done beside other work) makes their sum larger or smaller than the whole.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast import dop853, layout
from reference_impl.fast.accelerations import angular_accelerations, com_acceleration, evaluate
from reference_impl.fast.bar_positions import centres_from_first
from reference_impl.fast.dop853 import advance
from reference_impl.fast.field import end_accelerations, gravity
from reference_impl.fast.joints import reactions
from reference_impl.fast.layout import RX, CompiledChain, Workspace
from reference_impl.fast.trigonometry import unit_vectors
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Matrix, Vector
from reference_impl.model.chain import ChainModel

if TYPE_CHECKING:
    from collections.abc import Callable

STEP_S = 1e-3
BATCHES = 1500
PARTS = (
    "one evaluation", "sines and cosines", "places of the bars", "gravity and its torque", "free ends, c n nᵀ",
    "sweeps: reactions", "angular accelerations", "centre of mass",
)  # fmt: skip


@compiled
def repeat(which: int, times: int, y: Vector, rates: Vector, c: CompiledChain, w: Workspace) -> None:
    """Call one part `times` times, each on what the one before left."""
    n = c.bars.shape[1]
    for _ in range(times):
        if which == 0:
            evaluate(0.0, y, rates, c, w)
        elif which == 1:
            unit_vectors(n, y, w.bars)
        elif which == 2:
            centres_from_first(n, c.bars, w.bars)
        elif which == 3:
            gravity(n, c, y[n], y[n + 1], 0.0, 0.0, w.bars)
        elif which == 4:
            end_accelerations(n, c, y, w.bars)
        elif which == 5:
            reactions(n, c.bars, w.bars)
        elif which == 6:
            angular_accelerations(n, c, w.bars, rates)
        else:
            rates[0], rates[1] = com_acceleration(n, c, y, w.bars)
        y[0] += 1e-30 * (rates[n + 2] + w.bars[RX, 0])


@compiled
def repeat_steps(times: int, y: Vector, slopes: Matrix, end: Vector, c: CompiledChain, w: Workspace) -> None:
    """Take the same step `times` times."""
    for _ in range(times):
        advance(0.0, STEP_S, y, slopes, end, c, w)
        y[0] += 1e-30 * end[0]


Library("profile", (repeat, repeat_steps))


def case(bars: int) -> tuple[np.ndarray, np.ndarray, layout.CompiledChain, layout.Workspace]:
    """The 80° chain of `bars` bars of 100 m in a circular orbit."""
    mass, length = np.full(bars, 100.0), np.full(bars, 100.0)
    model = ChainModel(3.986004418e14, mass, length, mass * length**2 / 12.0, "gradient")
    com, velocity = np.array([6.728e6, 0.0]), np.array([0.0, 7697.0])
    y = layout.pack(com, velocity, np.full(bars, np.radians(-10.0)), np.full(bars, 1.1e-3))
    return y, np.zeros_like(y), layout.compiled_chain(model), layout.workspace(bars, 0)


def least_ns(call: Callable[[int], None], times: int, batches: int) -> float:
    """Least time of one of `times` calls, over `batches` of them, ns."""
    call(1)
    best = np.inf
    for _ in range(batches):
        start = time.perf_counter()
        call(times)
        best = min(best, (time.perf_counter() - start) / times)
    return 1e9 * best


def main() -> None:
    """Print the table."""
    print(f"{'ns':28s}{'N = 5':>10s}{'N = 500':>12s}{'a bar':>8s}")
    few, many = case(5), case(500)
    for k, name in enumerate(PARTS):
        five = least_ns(lambda t, k=k: repeat(k, t, *few), 300, BATCHES)  # type: ignore[misc]
        long = least_ns(lambda t, k=k: repeat(k, t, *many), 10, BATCHES // 5)  # type: ignore[misc]
        print(f"{name:28s}{five:10.1f}{long:12.0f}{long / 500:8.2f}")
    y, _, chain, work = few
    slopes, end = np.zeros((dop853.ROWS, len(y))), np.zeros_like(y)
    step = least_ns(lambda t: repeat_steps(t, y, slopes, end, chain, work), 50, BATCHES)
    print(f"{'one step of 12 evaluations':28s}{step:10.1f}")
    for bars in (100, 1000, 10_000, 100_000):
        chained = case(bars)
        whole = least_ns(lambda t, c=chained: repeat(0, t, *c), max(1, 5000 // bars), 50)  # type: ignore[misc]
        print(f"one evaluation, N = {bars:<8d}{whole:10.0f}{'':12s}{whole / bars:8.2f}")


if __name__ == "__main__":
    main()
