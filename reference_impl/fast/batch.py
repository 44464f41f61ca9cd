"""Many chains in sequence, in one compiled loop that releases the GIL."""

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
    """Chains of a batch, one row each; N bars, P prescribed rotations."""

    mu_m3_s2: Array
    """(runs,)"""
    gravity: int
    """One of `layout.GRAVITY_CODES`, equal for all chains"""
    bars: Array
    """(runs, 10, N) rows as in `layout.CompiledChain.bars`"""
    laws: Array
    """(runs, P, 7)"""
    effects: Effects
    """Equal for all chains; effects with modes are not supported, as a batch sets no modes"""
    y0: Array
    """(runs, size)"""
    atol: Array
    """(runs, size)"""
    contact_free_radius_m: Array
    """(runs,) see `stepper.SurfaceBounds`"""
    contact_free_perigee_m: Array
    """(runs,)"""
    largest_pull_m_s2: Array
    """(runs,)"""


class BatchResult(NamedTuple):
    """Results of a batch at n samples."""

    angle_rad: Array
    """(runs, n, N)"""
    reaction_N: Array
    """(runs, n, N-1) magnitudes of the joint reactions"""
    code: Array
    """(runs,) return code of each integration, see :mod:`reference_impl.fast.stepper`"""
    steps: Array
    """(runs,)"""
    evaluations: Array
    """(runs,)"""


def run_batch(batch: Batch, t_s: Array, segments_s: Array) -> BatchResult:
    """Integrate every chain of `batch` over the samples `t_s`.

    A run that may have touched the surface, or failed, has NaN after its last sample and a return code other than
    ARRIVED.

    Parameters
    ----------
    batch : Batch
    t_s : ndarray, shape (n,)
    segments_s : ndarray, shape (k, 2)
        Starts and ends of the smooth segments between known instants.
    """
    runs, _, bars = batch.bars.shape
    n = len(t_s)
    result = BatchResult(
        np.full((runs, n, bars), np.nan),
        np.full((runs, n, bars - 1), np.nan),
        np.zeros(runs),
        np.zeros(runs),
        np.zeros(runs),
    )
    sample_states = np.empty((n, batch.y0.shape[1]))
    integrate_all(
        batch,
        t_s,
        segments_s,
        new_stepper(batch.y0[0]),
        workspace(bars, batch.laws.shape[1], batch.effects),
        sample_states,
        result,
    )
    return result


@compiled
def integrate_all(
    batch: Batch, t_s: Array, segments_s: Array, s: Stepper, work: Workspace, sample_states: Array, result: BatchResult
) -> None:
    """Run all chains of a batch in sequence.

    Parameters
    ----------
    batch : Batch
    t_s : ndarray, shape (n,)
    segments_s : ndarray, shape (k, 2)
    s : Stepper
        Used for all runs, one after the other.
    work : Workspace
        Intermediate results of an evaluation.
    sample_states : ndarray, shape (n, size)
        States of the present run at its samples; overwritten.
    result : BatchResult
        Output.
    """
    for r in range(len(batch.mu_m3_s2)):
        chain = CompiledChain(batch.mu_m3_s2[r], batch.gravity, batch.bars[r], batch.laws[r], batch.effects)
        restart(batch.y0[r], sample_states[0], s)
        surface_bounds = SurfaceBounds(
            batch.contact_free_radius_m[r], batch.contact_free_perigee_m[r], batch.largest_pull_m_s2[r]
        )
        code = ARRIVED
        for k in range(len(segments_s)):
            start, end = segments_s[k, 0], segments_s[k, 1]
            if code == ARRIVED:
                code = advance_to(start, end, surface_bounds, t_s, sample_states, batch.atol[r], s, chain, work)
        result.code[r], result.steps[r], result.evaluations[r] = code, s.clock[STEPS], s.clock[EVALUATIONS]
        record_samples(r, int(s.clock[SAMPLED]), t_s, sample_states, s.end, chain, work, result)


@compiled
def restart(y0: Array, first: Array, s: Stepper) -> None:
    """Reset the stepper to the start of another run, with its first sample.

    Parameters
    ----------
    y0 : ndarray, shape (size,)
        Initial state.
    first : ndarray, shape (size,)
        State at the first sample: output.
    s : Stepper
        Output.
    """
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
    sample_states: Array,
    rates: Array,
    chain: CompiledChain,
    work: Workspace,
    result: BatchResult,
) -> None:
    """Record angles and magnitudes of the reactions at the samples reached.

    Parameters
    ----------
    r : int
        Number of the run, counted from 0.
    count : int
        Number of samples reached.
    t_s : ndarray, shape (n,)
    sample_states : ndarray, shape (n, size)
    rates : ndarray, shape (size,)
        Buffer for the derivative of a state; overwritten.
    chain : CompiledChain
    work : Workspace
        Intermediate results of an evaluation; overwritten.
    result : BatchResult
        Output.
    """
    n = chain.bars.shape[1]
    for k in range(count):
        evaluate(t_s[k], sample_states[k], rates, chain, work)
        for j in range(n):
            result.angle_rad[r, k, j] = sample_states[k, j]
        for j in range(n - 1):
            result.reaction_N[r, k, j] = np.hypot(work.bars[RX, j], work.bars[RY, j])
