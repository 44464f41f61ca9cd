"""Runs of an ensemble in parts: on all cores by threads, or on a Dask cluster; the same numbers either way."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import EngineError, Setting
from adapters.reference.compiled_engine import ReferenceFast
from barchain.studies.ensemble.cluster_code import need_same_code
from barchain.studies.ensemble.population import Population, batch
from reference_impl.fast.batch import BatchResult
from reference_impl.fast.lanes.batch import run_members
from reference_impl.fast.stepper import ARRIVED
from reference_impl.integrate.stepper import smooth_segments

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from adapters.trajectory import Array

RUNS_PER_TASK = 250  # some tens of milliseconds: progress is smooth, and a killed worker costs little


@dataclass(frozen=True)
class EnsembleTask:
    """A part of the population to be run."""

    part: Population
    rtol: float


@dataclass(frozen=True)
class EnsembleTaskResult:
    """Result of a task."""

    seen: BatchResult
    ended: tuple[str, ...]
    """Of each run: why it ended early; empty if it did not"""
    failed: tuple[str, ...]
    """Of each run: why it failed; empty if it did not"""


def tasks(population: Population, rtol: float) -> list[EnsembleTask]:
    """Parts of `population`, the same however many workers there are."""
    starts = range(0, population.runs, RUNS_PER_TASK)
    return [EnsembleTask(population.part(k, min(k + RUNS_PER_TASK, population.runs)), rtol) for k in starts]


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


def run_there(task: EnsembleTask, versions: dict[str, str]) -> EnsembleTaskResult:
    """Run one part on a worker of a cluster, if it has the sender's code."""
    need_same_code(versions)
    return run_task(task)


def on_threads(
    parts: Mapping[int, EnsembleTask], workers: int | None, keep: Callable[[int, EnsembleTaskResult], None]
) -> None:
    """Run parts on threads of this process: compiled code holds no interpreter lock. `keep` gets each result."""
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        futures = {pool.submit(run_task, part): k for k, part in parts.items()}
        try:
            for future in as_completed(futures):
                keep(futures[future], future.result())
        finally:
            pool.shutdown(wait=False, cancel_futures=True)  # an interrupt waits for the parts at work only


def assembled(parts: list[EnsembleTaskResult]) -> Iterator[tuple[str, Array]]:
    """Results of all parts, in order: name and array (runs, ...)."""
    for name in BatchResult._fields:
        yield name, np.concatenate([getattr(p.seen, name) for p in parts])
