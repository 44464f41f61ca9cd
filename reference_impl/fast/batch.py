"""Many chains, one after another, in one compiled loop that holds no interpreter lock."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reference_impl.fast.accelerations import evaluate
from reference_impl.fast.jit import compiled
from reference_impl.fast.layout import RX, RY, CompiledChain, workspace
from reference_impl.fast.stepper import ARRIVED, EVALUATIONS, SAMPLED, STEPS, SurfaceBounds, advance_to, new_stepper

if TYPE_CHECKING:
    from reference_impl.fast.layout import Effects, Workspace
    from reference_impl.fast.stepper import Stepper
    from reference_impl.model.arrays import Array


class Batch(NamedTuple):
    """Chains to run, one row each; N bars, P prescribed rotations."""

    mu_m3_s2: Array
    """(runs,)"""
    gravity: int
    """One of `layout.GRAVITY_CODES`, the same for all"""
    bars: Array
    """(runs, 9, N)"""
    laws: Array
    """(runs, P, 7)"""
    effects: Effects
    """The same for all, none with a mode: nothing here would set it"""
    y0: Array
    """(runs, size)"""
    atol: Array
    """(runs, size)"""
    contact_free_radius_m: Array
    """(runs,) see `walk.Ground`"""
    contact_free_perigee_m: Array
    """(runs,)"""
    largest_pull_m_s2: Array
    """(runs,)"""


class BatchResult(NamedTuple):
    """What a batch showed at n samples."""

    angle_rad: Array
    """(runs, n, N)"""
    reaction_N: Array
    """(runs, n, N-1) sizes of the joint reactions"""
    code: Array
    """(runs,) how each walk ended, one of the codes of :mod:`reference_impl.fast.stepper`"""
    steps: Array
    """(runs,)"""
    evaluations: Array
    """(runs,)"""


def run_batch(batch: Batch, t_s: Array, stretches_s: Array) -> BatchResult:
    """Walk every chain of `batch` over the samples `t_s`.

    A run that can't go on by itself (it may have touched the surface, or failed) has NaN from there on, and says so
    in its code.

    Parameters
    ----------
    batch : Batch
    t_s : ndarray, shape (n,)
    stretches_s : ndarray, shape (k, 2)
        Smooth parts of the walk, from break to break.
    """
    runs, _, bars = batch.bars.shape
    n = len(t_s)
    seen = BatchResult(
        np.full((runs, n, bars), np.nan),
        np.full((runs, n, bars - 1), np.nan),
        np.zeros(runs),
        np.zeros(runs),
        np.zeros(runs),
    )
    scratch = np.empty((n, batch.y0.shape[1]))
    integrate_all(
        batch,
        t_s,
        stretches_s,
        new_stepper(batch.y0[0]),
        workspace(bars, batch.laws.shape[1], batch.effects),
        scratch,
        seen,
    )
    return seen


@compiled
def integrate_all(
    batch: Batch, t_s: Array, stretches_s: Array, s: Stepper, scratch: Workspace, rows: Array, seen: BatchResult
) -> None:
    """Run all chains of a batch in turn."""
    for r in range(len(batch.mu_m3_s2)):
        chain = CompiledChain(batch.mu_m3_s2[r], batch.gravity, batch.bars[r], batch.laws[r], batch.effects)
        restart(batch.y0[r], rows[0], s)
        ground = SurfaceBounds(
            batch.contact_free_radius_m[r], batch.contact_free_perigee_m[r], batch.largest_pull_m_s2[r]
        )
        code = ARRIVED
        for k in range(len(stretches_s)):
            if code == ARRIVED:
                code = advance_to(
                    stretches_s[k, 0], stretches_s[k, 1], ground, t_s, rows, batch.atol[r], s, chain, scratch
                )
        seen.code[r], seen.steps[r], seen.evaluations[r] = code, s.clock[STEPS], s.clock[EVALUATIONS]
        record_samples(r, int(s.clock[SAMPLED]), t_s, rows, s.end, chain, scratch, seen)


@compiled
def restart(y0: Array, first: Array, s: Stepper) -> None:
    """Stand at the start of another walk, its first sample taken."""
    for i in range(len(s.clock)):
        s.clock[i] = 0.0
    s.clock[SAMPLED] = 1.0
    for i in range(len(y0)):
        s.y[i] = first[i] = y0[i]


@compiled
def record_samples(
    r: int,
    count: int,
    t_s: Array,
    rows: Array,
    rates: Array,
    chain: CompiledChain,
    scratch: Workspace,
    seen: BatchResult,
) -> None:
    """Angles and sizes of the reactions at the samples reached."""
    n = chain.bars.shape[1]
    for k in range(count):
        evaluate(t_s[k], rows[k], rates, chain, scratch)
        for j in range(n):
            seen.angle_rad[r, k, j] = rows[k, j]
        for j in range(n - 1):
            seen.reaction_N[r, k, j] = np.hypot(scratch.bars[RX, j], scratch.bars[RY, j])
