"""Parts of an ensemble, drawn and run in order: on threads of this process, or in processes of a cluster."""

from __future__ import annotations

import os
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import EngineError, Setting
from adapters.reference.compiled_engine import ReferenceFast
from barchain.runs.call import Call, CallFailedError
from barchain.runs.executors import LocalProcesses
from barchain.studies.ensemble.population import Population, batch, populations
from barchain.studies.ensemble.task_results import EnsembleTaskResult, packed, unpacked
from reference_impl.integrate.stepper import smooth_segments
from reference_impl.kernel.batch import run_members
from reference_impl.kernel.layout import ARRIVED

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator

    from barchain.runs.call import Answer
    from barchain.runs.executors import Executor
    from barchain.runs.session import Session
    from barchain.studies.ensemble.plan import EnsemblePlan
    from reference_impl.kernel.batch import BatchResult

RUNS_PER_TASK = 250  # some ten milliseconds: progress is smooth, and a killed worker costs little
AHEAD_HERE, AHEAD_THERE = 4, 32  # parts of each thread that are under way; a cluster takes many in a batch
MOST_WAITING = 2**28  # B of results that wait for an earlier part; two for each thread may be more
PART_LIMIT_S = 3600.0  # a part of 250 runs takes some hundredths of a second, of a long scene minutes


@dataclass(frozen=True)
class EnsembleTask:
    """A part of the population to be run."""

    part: Population
    rtol: float
    first: int = 0
    """Number of its first run, counted from 0"""

    @property
    def result_bytes(self) -> int:
        """Size of its samples."""
        scene = self.part.scene
        return 8 * self.part.runs * scene.run.samples * (2 * scene.bars - 1)


Done = tuple[EnsembleTask, EnsembleTaskResult]


def tasks(plan: EnsemblePlan, first: int = 0) -> Iterator[EnsembleTask]:
    """Parts from run `first` on, drawn as they are asked for; the same however many workers there are."""
    parts = populations(plan.scene, plan.variations, plan.runs, plan.seed, RUNS_PER_TASK)
    for k, part in enumerate(parts):
        if k * RUNS_PER_TASK >= first:
            yield EnsembleTask(part, plan.rtol, k * RUNS_PER_TASK)


def results(plan: EnsemblePlan, first: int = 0) -> Generator[Done]:
    """Parts from run `first` on with their results, in order.

    Raises
    ------
    CallFailedError
        If a part gives no result.
    ClusterLostError
        If the executor is a cluster, and fails.
    """
    if isinstance(plan.executor, LocalProcesses):
        return on_threads(tasks(plan, first), plan.executor.workers or os.cpu_count() or 1)
    return in_processes(tasks(plan, first), plan.executor)


def most_under_way(task: EnsembleTask, threads: int, ahead: int) -> int:
    """Parts that may be begun, wait for a thread, or wait for an earlier part."""
    return max(2 * threads, min(ahead * threads, MOST_WAITING // task.result_bytes))


def on_threads(parts: Iterator[EnsembleTask], threads: int) -> Generator[Done]:
    """Run parts on threads of this process, in order: compiled code holds no interpreter lock."""
    under_way = deque[tuple[EnsembleTask, Future[EnsembleTaskResult]]]()
    with ThreadPoolExecutor(threads) as pool:
        try:
            for part in parts:
                under_way.append((part, pool.submit(run_task, part)))
                if len(under_way) >= most_under_way(part, threads, AHEAD_HERE):
                    yield earliest(under_way)
            while under_way:
                yield earliest(under_way)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)  # an interrupt waits for the parts at work only


def earliest(under_way: deque[tuple[EnsembleTask, Future[EnsembleTaskResult]]]) -> Done:
    """Earliest part with its result, once it is there."""
    part, future = under_way.popleft()
    return part, future.result()


def in_processes(parts: Iterator[EnsembleTask], executor: Executor) -> Generator[Done]:
    """Run parts in processes of an executor, in order; errors as :func:`results`."""
    under_way, found = dict[int, EnsembleTask](), dict[int, EnsembleTaskResult]()
    with executor.session() as session:
        submit_more(parts, under_way, session)
        for first, answer in session.answers():
            found[first] = needed_result(under_way[first], answer)
            while under_way and (k := next(iter(under_way))) in found:
                yield under_way.pop(k), found.pop(k)
                submit_more(parts, under_way, session)


def submit_more(parts: Iterator[EnsembleTask], under_way: dict[int, EnsembleTask], session: Session) -> None:
    """Submit as many parts as may be under way."""
    for part in parts:
        under_way[part.first] = part
        session.submit(part.first, Call(packed_part, (part,), PART_LIMIT_S))
        if len(under_way) >= most_under_way(part, session.side_by_side(), AHEAD_THERE):
            return


def needed_result(task: EnsembleTask, answer: Answer) -> EnsembleTaskResult:
    """Result of a part from another process.

    Raises
    ------
    CallFailedError
        If there is none, or a damaged one.
    """
    found, scene = unpacked(answer.needed()), task.part.scene
    if found is None or not found.fits(task.part.runs, scene.run.samples, scene.bars):
        raise CallFailedError("a part of the ensemble came back damaged")
    return found


def packed_part(part: EnsembleTask) -> bytes:
    """Run a part, and return its result for another process."""
    return packed(run_task(part))


def run_task(task: EnsembleTask) -> EnsembleTaskResult:
    """Run one part; a copy that the compiled loop gives back is run by itself, event and error words included."""
    scene = task.part.scene
    breaks_s = tuple(t for p in scene.effects.prescribed_rotation for t in p.breaks_s)
    smooth = np.array(smooth_segments(scene.times_s, breaks_s))
    seen = run_members(batch(task.part, task.rtol), scene.times_s, smooth)
    ended, failed = [""] * task.part.runs, [""] * task.part.runs
    for run in np.nonzero(seen.code != ARRIVED)[0]:
        ended[run], failed[run] = run_alone(task, int(run), seen)
    return EnsembleTaskResult(seen, tuple(ended), tuple(failed))


def run_alone(task: EnsembleTask, run: int, seen: BatchResult) -> tuple[str, str]:
    """Run one copy in the engine, write its samples into `seen`, and return how it ended and why it failed."""
    try:
        found = ReferenceFast().run(task.part.copy(run), Setting(ReferenceFast.sweep.parameter, task.rtol))
    except EngineError as error:
        seen.angle_rad[run], seen.reaction_N[run] = np.nan, np.nan
        return "", str(error)
    assert found.angle_rad is not None
    assert found.reaction_N is not None
    n = len(found.t_s)
    seen.angle_rad[run, :n], seen.angle_rad[run, n:] = found.angle_rad, np.nan
    seen.reaction_N[run, :n], seen.reaction_N[run, n:] = np.linalg.norm(found.reaction_N, axis=2), np.nan
    seen.steps[run], seen.evaluations[run] = found.info["steps"], found.info["evaluations"]
    return found.ended, ""
