"""Runs of an ensemble in parts: on all cores by threads, or on a Dask cluster; the same numbers either way."""

from __future__ import annotations

import os
import socket
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import numpy as np

from adapters.engine import EngineError, Setting
from adapters.reference.compiled_engine import ReferenceFast
from barchain.studies.ensemble.population import Population, batch
from reference_impl.fast.batch import BatchResult, run_batch
from reference_impl.fast.stepper import ARRIVED
from reference_impl.integrate.stepper import smooth_segments

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.trajectory import Array

RUNS_PER_TASK = 250  # some tens of milliseconds: progress is smooth, and a killed worker costs little
RETRIES = 5  # times that a cluster may lose one part's worker


class ClusterError(RuntimeError):
    """The Dask cluster can't be used."""


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
    seen = run_batch(batch(task.part, task.rtol), scene.times_s, smooth)
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


def on_threads(parts: list[EnsembleTask], workers: int | None, done: Callable[[int], None]) -> list[EnsembleTaskResult]:
    """Results in order, from threads of this process: compiled code holds no interpreter lock."""
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        futures = {pool.submit(run_task, part): part for part in parts}
        for future in as_completed(futures):
            done(futures[future].part.runs)
            future.result()  # a defect of barchain shows at once
    return [future.result() for future in futures]


def on_cluster(parts: list[EnsembleTask], address: str, done: Callable[[int], None]) -> list[EnsembleTaskResult]:
    """Results in order, from the Dask cluster at `address`; a part whose worker dies is run again on another.

    Raises
    ------
    ClusterError
        If distributed is not installed, nothing answers there, or a part was lost time after time.
    """
    try:
        from distributed import Client, KilledWorker, as_completed  # noqa: PLC0415  # an extra
    except ImportError:
        raise ClusterError("--dask: distributed is not installed; try: pip install '.[cluster]'") from None
    look_up(address)
    try:
        client = Client(address, timeout="5s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise ClusterError(f"--dask {address}: no Dask scheduler answers there ({error})") from None
    found: dict[int, EnsembleTaskResult] = {}
    with client, client.as_current():
        futures = {client.submit(run_task, part, pure=False, retries=RETRIES): k for k, part in enumerate(parts)}
        try:
            for future, part in as_completed(futures, with_results=True):
                found[futures[future]] = part
                done(parts[futures[future]].part.runs)
        except KilledWorker as error:
            raise ClusterError(f"--dask {address}: {error}") from None
    return [found[k] for k in range(len(parts))]


def look_up(address: str) -> None:
    """Knock at a TCP address before Dask does, which goes on trying in the background and talks of it.

    Raises
    ------
    ClusterError
        If it is none, or nothing answers there.
    """
    where = urlsplit(address if "://" in address else f"tcp://{address}")
    if where.scheme not in {"tcp", "tls"}:
        return  # Dask's own business
    try:
        if where.hostname is None or where.port is None:
            raise ClusterError(f"--dask {address}: given, allowed: HOST:PORT, e.g. tcp://10.0.0.1:8786")
        socket.create_connection((where.hostname, where.port), timeout=5.0).close()
    except (OSError, ValueError) as error:
        raise ClusterError(f"--dask {address}: no Dask scheduler answers there ({error})") from None


def assembled(parts: list[EnsembleTaskResult]) -> Iterator[tuple[str, Array]]:
    """Results of all parts, in order: name and array (runs, ...)."""
    for name in BatchResult._fields:
        yield name, np.concatenate([getattr(p.seen, name) for p in parts])
