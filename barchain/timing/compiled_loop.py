"""Evaluations of the compiled reference in a compiled loop: Python's own call takes as long as five bars do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reference_impl.fast.accelerations import evaluate
from reference_impl.fast.jit import compiled

if TYPE_CHECKING:
    from reference_impl.fast.layout import CompiledChain, Workspace
    from reference_impl.model.arrays import Array

BARELY = 1e-30  # of a rate: added to an angle, it changes nothing and keeps the compiler from calling only once


@compiled
def repeat(times: int, y: Array, rates: Array, chain: CompiledChain, work: Workspace) -> None:
    """Evaluate `times` times, each on what the one before left."""
    n = chain.bars.shape[1]
    for _ in range(times):
        evaluate(0.0, y, rates, chain, work)
        y[0] += BARELY * rates[n + 2]
