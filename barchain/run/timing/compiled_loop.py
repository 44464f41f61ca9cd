"""Evaluations of the compiled reference in a compiled loop: a call from Python takes as long as five bars."""

from __future__ import annotations

from reference_impl.fast.accelerations import evaluate
from reference_impl.fast.layout import CompiledChain, Workspace
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Vector

BARELY = 1e-30  # of a rate: it leaves an angle unchanged, and keeps the compiler from evaluating only once


@compiled
def repeat(times: int, y: Vector, rates: Vector, chain: CompiledChain, work: Workspace) -> None:
    """Evaluate `times` times; each evaluation depends on the one before."""
    n = chain.bars.shape[1]
    for _ in range(times):
        evaluate(0.0, y, rates, chain, work)
        y[0] += BARELY * rates[n + 2]


Library("timing", (repeat,))
