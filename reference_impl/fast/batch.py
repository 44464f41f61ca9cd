"""Many chains in sequence, in one compiled loop that releases the interpreter lock."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import starmap
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reference_impl.fast.accelerations import evaluate
from reference_impl.fast.layout import RX, RY, CompiledChain, Workspace, workspace
from reference_impl.fast.stepper import (
    ARRIVED,
    EVALUATIONS,
    SAMPLED,
    STEPS,
    Stepper,
    SurfaceBounds,
    advance_to,
    new_stepper,
)
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Matrix, Struct, Vector

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.fast.layout import Effects
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


@dataclass(frozen=True)
class Members(Struct):
    """Members of a batch in compiled code."""

    chains: tuple[CompiledChain, ...]
    bounds: tuple[SurfaceBounds, ...]
    y0: Matrix
    """(runs, size)"""
    atol: Matrix
    """(runs, size)"""


@dataclass(frozen=True)
class MemberResults(Struct):
    """Results of a batch in compiled code; `runs` members, n samples."""

    angle_rad: Matrix
    """(runs n, N)"""
    reaction_N: Matrix
    """(runs n, N-1)"""
    code: Vector
    """(runs,)"""
    steps: Vector
    """(runs,)"""
    evaluations: Vector
    """(runs,)"""


def run_batch(batch: Batch, t_s: Vector, segments_s: Matrix) -> BatchResult:
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
    members = Members(
        tuple(starmap(chain_of(batch), zip(batch.mu_m3_s2, batch.bars, batch.laws, strict=True))),
        tuple(starmap(SurfaceBounds, zip(*bounds_of(batch), strict=True))),
        batch.y0,
        batch.atol,
    )
    results, n = new_results(batch, t_s), len(t_s)
    work = workspace(batch.bars.shape[2], batch.laws.shape[1], bool(batch.effects))
    integrate_all(members, t_s, segments_s, new_stepper(batch.y0[0]), work, np.empty((n, batch.y0.shape[1])), results)
    return batch_result(results, n)


def new_results(batch: Batch, t_s: Vector) -> MemberResults:
    """Results of a batch without any sample."""
    runs, _, bars = batch.bars.shape
    rows = runs * len(t_s)
    angle, reaction = np.full((rows, bars), np.nan), np.full((rows, bars - 1), np.nan)
    return MemberResults(angle, reaction, np.zeros(runs), np.zeros(runs), np.zeros(runs))


def batch_result(results: MemberResults, samples: int) -> BatchResult:
    """Results by member and sample."""
    runs = len(results.code)
    angle, reaction = (x.reshape(runs, samples, -1) for x in (results.angle_rad, results.reaction_N))
    return BatchResult(angle, reaction, results.code, results.steps, results.evaluations)


def chain_of(batch: Batch) -> Callable[[float, Matrix, Matrix], CompiledChain]:
    """Function that makes one member's chain."""
    return lambda mu, bars, laws: CompiledChain(mu, batch.gravity, bars, laws, batch.effects)


def bounds_of(batch: Batch) -> tuple[Vector, Vector, Vector]:
    """Columns of the members' bounds."""
    return batch.contact_free_radius_m, batch.contact_free_perigee_m, batch.largest_pull_m_s2


@compiled
def integrate_all(
    members: Members,
    t_s: Vector,
    segments_s: Matrix,
    s: Stepper,
    work: Workspace,
    sample_states: Matrix,
    results: MemberResults,
) -> None:
    """Run all chains of a batch in sequence.

    Parameters
    ----------
    members : Members
    t_s : ndarray, shape (n,)
    segments_s : ndarray, shape (k, 2)
    s : Stepper
        Used for all runs, one after the other.
    work : Workspace
        Intermediate results of an evaluation.
    sample_states : ndarray, shape (n, size)
        States of the present run at its samples; overwritten.
    results : MemberResults
        Output.
    """
    for r in range(len(members.chains)):
        chain, bounds = members.chains[r], members.bounds[r]
        restart(members.y0[r], sample_states[0], s)
        code = ARRIVED
        for k in range(len(segments_s)):
            start, end = segments_s[k, 0], segments_s[k, 1]
            if code == ARRIVED:
                code = advance_to(start, end, bounds, t_s, sample_states, members.atol[r], s, chain, work)
        results.code[r], results.steps[r], results.evaluations[r] = code, s.clock[STEPS], s.clock[EVALUATIONS]
        record_samples(r, int(s.clock[SAMPLED]), t_s, sample_states, s.end, chain, work, results)


@inlined
def restart(y0: Vector, first: Vector, s: Stepper) -> None:
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


@inlined
def record_samples(
    r: int,
    count: int,
    t_s: Vector,
    sample_states: Matrix,
    rates: Vector,
    chain: CompiledChain,
    work: Workspace,
    results: MemberResults,
) -> None:
    """Struct angles and magnitudes of the reactions at the samples reached.

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
    results : MemberResults
        Output.
    """
    n = chain.bars.shape[1]
    for k in range(count):
        row = r * len(t_s) + k
        evaluate(t_s[k], sample_states[k], rates, chain, work)
        for j in range(n):
            results.angle_rad[row, j] = sample_states[k, j]
        for j in range(n - 1):
            results.reaction_N[row, j] = np.hypot(work.bars[RX, j], work.bars[RY, j])


Library("batch", (integrate_all,))
