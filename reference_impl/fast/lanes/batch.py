"""A batch of chains: in lanes where lanes serve, otherwise one chain after another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast.batch import Batch, BatchResult, batch_result, new_results, run_batch
from reference_impl.fast.lanes.layout import start_columns
from reference_impl.fast.lanes.queue import GIVEN_BACK, new_lanes, run_queue
from reference_impl.fast.layout import ILL_CONDITIONED

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from reference_impl.model.arrays import Array


def run_members(batch: Batch, t_s: Array, segments_s: Array) -> BatchResult:
    """Integrate every chain of `batch` over the samples `t_s`, as :func:`reference_impl.fast.batch.run_batch`.

    Lanes run free chains with gravity alone. Chains with prescribed rotations or effects, and ill-conditioned chains,
    run one after another. So do chains that lanes give back: those that may touch the surface, lose a pivot, or turn
    beyond the range of the sine.

    Parameters
    ----------
    batch : Batch
    t_s : ndarray, shape (n,)
    segments_s : ndarray, shape (k, 2)
        Starts and ends of the smooth segments between known instants.
    """
    if batch.laws.shape[1] or batch.effects or len(segments_s) != 1 or len(t_s) < 2:
        return run_batch(batch, t_s, segments_s)
    in_lanes = batch.bars[:, ILL_CONDITIONED, 0] == 0.0
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
    result.code[:] = GIVEN_BACK
    run_queue(batch.gravity, start_columns(batch), new_lanes(batch.bars.shape[2], t_s), result)
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
