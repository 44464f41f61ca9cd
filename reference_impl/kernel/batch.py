"""Many chains at once, without the interpreter lock: in lanes where lanes serve, otherwise one after another."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reference_impl.kernel.layout import (
    GIVEN_BACK,
    ILL_CONDITIONED,
    UNEQUAL,
    BatchMembers,
    MemberResults,
    new_stepper,
    workspace,
)
from reference_impl.kernel.library import integrate_batch, integrate_in_lanes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from reference_impl.kernel.effects import Effects
    from reference_impl.kernel.packing import Vector
    from reference_impl.model.arrays import Array


class Batch(NamedTuple):
    """Chains of a batch, one row each; N bars, P prescribed rotations."""

    mu_m3_s2: Array
    """(runs,)"""
    gravity: int
    """One of `layout.GRAVITY_CODES`, equal for all chains"""
    bars: Array
    """(runs, 15, N) rows as in `layout.CompiledChain.bars`"""
    laws: Array
    """(runs, P, 4+8T)"""
    effects: Effects
    """Equal for all chains; effects with modes are not supported, as a batch sets no modes"""
    y0: Array
    """(runs, size)"""
    atol: Array
    """(runs, size)"""
    contact_free_radius_m: Array
    """(runs,) see `layout.SurfaceBounds`"""
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
    """(runs,) return code of each integration, see :mod:`reference_impl.kernel.layout`"""
    steps: Array
    """(runs,)"""
    evaluations: Array
    """(runs,)"""


def run_batch(batch: Batch, t_s: Vector, segments_s: Array) -> BatchResult:
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
    members, results = members_of(batch), new_results(batch, t_s)
    work = workspace(batch.bars.shape[2], batch.laws.shape[1], bool(batch.effects))
    integrate_batch(members, t_s, segments_s, new_stepper(batch.y0[0]), work, results)
    return batch_result(results, len(t_s))


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


def members_of(batch: Batch) -> BatchMembers:
    """Members of a batch as the kernel reads them."""
    bars = batch.bars.shape[2]
    bounds = batch.contact_free_radius_m, batch.contact_free_perigee_m, batch.largest_pull_m_s2
    return BatchMembers(
        batch.mu_m3_s2,
        batch.gravity,
        batch.bars.reshape(-1, bars),
        batch.laws.reshape(-1, batch.laws.shape[2]),
        batch.effects,
        np.stack(bounds, axis=1),
        batch.y0,
        batch.atol,
    )


def run_members(batch: Batch, t_s: Array, segments_s: Array) -> BatchResult:
    """Integrate every chain of `batch` over the samples `t_s`, as :func:`run_batch`.

    Lanes run free chains of equal levers with gravity alone. Chains with prescribed rotations or effects, with unequal
    levers, and ill-conditioned chains, run one after another. So do chains that lanes give back: those that may touch
    the surface, lose a pivot, or turn beyond the range of the sine.

    Parameters
    ----------
    batch : Batch
    t_s : ndarray, shape (n,)
    segments_s : ndarray, shape (k, 2)
        Starts and ends of the smooth segments between known instants.
    """
    if batch.laws.shape[1] or batch.effects or len(segments_s) != 1 or len(t_s) < 2:
        return run_batch(batch, t_s, segments_s)
    in_lanes = (batch.bars[:, ILL_CONDITIONED, 0] == 0.0) & (batch.bars[:, UNEQUAL, 0] == 0.0)
    if not in_lanes.any():
        return run_batch(batch, t_s, segments_s)
    result = empty_result(batch, t_s)
    chosen = np.nonzero(in_lanes)[0]
    write_rows(result, chosen, run_lanes(rows_of(batch, chosen), t_s))
    alone = np.nonzero(result.code == GIVEN_BACK)[0]
    if len(alone):
        write_rows(result, alone, run_batch(rows_of(batch, alone), t_s, segments_s))
    return result


def run_lanes(batch: Batch, t_s: Array) -> BatchResult:
    """Integrate every chain of `batch` in lanes; others have the code GIVEN_BACK and no samples."""
    result = new_results(batch, t_s)
    integrate_in_lanes(members_of(batch), t_s, result)
    return batch_result(result, len(t_s))


def empty_result(batch: Batch, t_s: Array) -> BatchResult:
    """Result without samples, all chains given back."""
    runs, _, bars = batch.bars.shape
    angle, reaction = np.full((runs, len(t_s), bars), np.nan), np.full((runs, len(t_s), bars - 1), np.nan)
    return BatchResult(angle, reaction, np.full(runs, GIVEN_BACK), np.zeros(runs), np.zeros(runs))


def rows_of(batch: Batch, rows: NDArray[np.intp]) -> Batch:
    """Some chains of a batch."""
    if len(rows) == len(batch.mu_m3_s2):
        return batch
    own = [name for name in Batch._fields if name not in ("gravity", "effects")]
    return batch._replace(**{name: getattr(batch, name)[rows] for name in own})


def write_rows(result: BatchResult, rows: NDArray[np.intp], part: BatchResult) -> None:
    """Write the results of some chains into those of all."""
    for whole, own in zip(result, part, strict=True):
        whole[rows] = own
