"""The ensemble study: many perturbed copies of a scene, and quantiles of attitude and reactions over time."""

from __future__ import annotations

import dataclasses
import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from barchain.record.scene_description import scene_facts
from barchain.runs.estimate import need_runnable
from barchain.runs.executors import ALL_CORES, DaskCluster, KeptAnswers
from barchain.studies.distributions import VariationError
from barchain.studies.ensemble.chunks import (
    LEAST_RUNS,
    SAMPLES,
    RunTally,
    columns,
    quantile_table,
    run_chunks,
    run_rows,
    run_table,
)
from barchain.studies.ensemble.population import Ensemble, check_effects, populations
from barchain.studies.ensemble.variation import parse
from reports.results.ensemble import FILES, add_rows
from scenarios import Scene, load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import pandas as pd

    from adapters.trajectory import Array
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.ensemble.chunks import ChunkFiles, RunColumns
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
RTOL = 1e-8
RUNS = 1000
SAMPLES_OF_A_RUN = 101
MOST_HELD = 10_000_000  # angles and reactions that the function for Python returns, 80 MB
MOST_NUMBERS = 1_000_000_000  # 8 GB
CHECKED_AT_ONCE = 50_000  # bars of the copies that are drawn together


@dataclass(frozen=True)
class EnsembleSummary:
    """Result of an ensemble whose size does not grow with the number of runs."""

    scene: Scene
    """As it was run, unperturbed"""
    quantiles: pd.DataFrame
    """Tidy: t_s, quantity (attitude, reaction), item (bar or joint, from 1), quantile, value, unit, runs (that reached
    the instant)"""
    tally: RunTally
    """Outcomes and evaluations of all runs"""
    seconds: dict[str, float]
    """Wall time: run (with drawing), reduce"""

    @property
    def failures(self) -> tuple[str, ...]:
        """Number of failed runs with the first reason, in one line; empty if none failed."""
        return self.tally.failures

    @property
    def passed(self) -> bool:
        """Whether no run failed."""
        return not self.failures


@dataclass(frozen=True)
class EnsembleResult(EnsembleSummary):
    """Result of an ensemble with its runs."""

    runs: pd.DataFrame
    """One row a run: what was drawn, outcome (finished, ended, failed), reason, steps, evaluations"""
    angle_rad: Array | None
    """(runs, n, N); None if all samples together are more than ten million numbers"""
    reaction_size_N: Array | None
    """(runs, n, N-1) magnitudes of the reactions, None as the angles; ``reaction_N`` of a trajectory has vectors"""


@dataclass(frozen=True)
class EnsembleStudy(Ensemble):
    """The ensemble study."""

    files: ClassVar[StudyFiles] = FILES

    def record(self) -> dict[str, Any]:
        """Scene, distributions and settings; outcomes and times are added at the end."""
        return {
            "scene": {"name": self.scene.name} | scene_facts(self.scene),
            "vary": [v.text for v in self.variations],
            "runs": self.runs,
            "rtol": self.rtol,
            "seed": self.seed,
        }

    def run(self, store: StudyStore, reporter: Reporter) -> EnsembleSummary:
        """Draw, run and reduce the copies.

        Raises
        ------
        ClusterLostError
            If the executor is a cluster, and fails; results so far are in the folder.
        """
        assert isinstance(self.executor, KeptAnswers)
        store.record["dask"] = isinstance(self.executor.inside, DaskCluster)
        with reporter.counted("runs", self.runs) as done:
            made, quantiles, seconds = reduced(self, store.answers, done)
        tally = RunTally()
        store.write("quantiles", quantiles)
        write_runs(store, run_rows(made, tally))
        store.record["outcomes"] = dict(tally.outcomes.most_common())
        store.record["evaluations"] = tally.evaluations
        store.record["phases_s"] = seconds
        add_rows(store.summary, quantiles, store.record)
        shutil.rmtree(store.answers)  # the tables say all; the samples may take gigabytes
        return EnsembleSummary(self.scene, quantiles, tally, seconds)


def ensemble_study(
    scene: Scene | str | Path,
    vary: Iterable[str],
    runs: int = RUNS,
    *,
    seed: int = 1,
    rtol: float = RTOL,
    orbits: float | None = None,
    samples: int = SAMPLES_OF_A_RUN,
    quantiles: tuple[float, ...] = QUANTILES,
    executor: Executor = ALL_CORES,
) -> EnsembleStudy:
    """Ensemble study; its parameters are those of :func:`ensemble`.

    Raises
    ------
    SceneError
        For a scene that does not exist.
    VariationError
        For a distribution that can't be read, for a quantity that varies twice, or for more numbers than memory holds.
    ClusterError
        For a Dask cluster that can't be used.
    """
    short = shortened(scene if isinstance(scene, Scene) else load_scene(scene), orbits, samples)
    need_runnable([short])
    variations = tuple(parse(text, short.bars) for text in vary)
    for k, v in enumerate(variations):
        if any(v.overlaps(other) for other in variations[:k]):
            raise VariationError(
                f"--vary {v.text}: {v.key} of the same bars is given twice; allowed: once for each bar"
            )
    check_numbers(short, runs)
    check_effects(short, variations)
    for _ in populations(short, variations, runs, seed, max(1, CHECKED_AT_ONCE // short.bars)):
        pass  # draws that a run could not have end the command before a folder is made or a scheduler is asked
    executor.check()
    return EnsembleStudy(short, variations, runs, seed, rtol, quantiles, executor)


def ensemble(
    scene: Scene | str | Path,
    vary: Iterable[str],
    runs: int = RUNS,
    *,
    seed: int = 1,
    rtol: float = RTOL,
    orbits: float | None = None,
    samples: int = SAMPLES_OF_A_RUN,
    quantiles: tuple[float, ...] = QUANTILES,
    executor: Executor = ALL_CORES,
    progress: Callable[[int], None] = lambda _: None,
) -> EnsembleResult:
    """Run many perturbed copies of a scene in the compiled reference, and take quantiles over time.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its name, or the path of its file.
    vary : iterable of str
        Distributions, e.g. ``["angle_deg=normal(80, 1)", "mass_kg[2]=lognormal(100, 0.1)"]``: ``normal(mean,
        deviation)``, ``uniform(low, high)``, ``lognormal(median, sigma)``, ``triangular(low, mode, high)`` of a key of
        the scene, for all bars alike, for bar ``[2]``, or for each by itself, ``[*]``.
    runs : int
        Number of copies.
    seed : int
        Equal seeds draw equal copies, on threads and on a cluster.
    rtol : float
        Requested relative accuracy of a step.
    orbits : float, optional
        Part of the scene that is run, from its start, in orbits; all of it by default.
    samples : int
        Number of equally spaced instants.
    quantiles : tuple of float
        Shares from 0 to 1.
    executor : Executor
        Place of the runs; all cores of this machine by default.
    progress : callable
        Called with the number of runs after each part.

    Returns
    -------
    EnsembleResult
        ``quantiles``, a tidy table over time; ``runs``, a row for each copy; ``angle_rad`` (runs, n, N) and
        ``reaction_size_N`` (runs, n, N-1), the magnitudes of the reactions.

    Raises
    ------
    SceneError
        If the scene does not exist.
    VariationError
        If a distribution can't be read, a quantity varies twice, or memory does not hold the numbers.
    ClusterError
        If a Dask cluster can't be used.
    """
    with tempfile.TemporaryDirectory() as folder:
        study = ensemble_study(
            scene, vary, runs, seed=seed, rtol=rtol, orbits=orbits, samples=samples, quantiles=quantiles,
            executor=executor,
        )  # fmt: skip
        study = dataclasses.replace(study, executor=KeptAnswers(Path(folder), study.executor))
        made, found, seconds = reduced(study, Path(folder), progress)
        tally = RunTally()
        table = run_table(run_rows(made, tally))
        n, bars, angle_rad, size_N = study.scene.run.samples, study.scene.bars, None, None
        if study.runs * columns(study.scene) <= MOST_HELD:
            held = made.samples().T
            angle_rad = np.ascontiguousarray(held[:, : n * bars]).reshape(study.runs, n, bars)
            size_N = np.ascontiguousarray(held[:, n * bars :]).reshape(study.runs, n, bars - 1)
    return EnsembleResult(study.scene, found, tally, seconds, table, angle_rad, size_N)


def reduced(
    study: EnsembleStudy, folder: Path, progress: Callable[[int], None]
) -> tuple[ChunkFiles, pd.DataFrame, dict[str, float]]:
    """Run the copies, their answers kept in a folder, and take quantiles; the wall time of both.

    Raises
    ------
    VariationError
        If the file system of the folder has no room for all samples.
    ClusterLostError
        If the cluster fails.
    """
    clock = [time.perf_counter()]
    need_room(study, folder)
    made = run_chunks(study, progress)
    clock.append(time.perf_counter())
    quantiles = quantile_table(made)
    clock.append(time.perf_counter())
    return made, quantiles, dict(zip(("run", "reduce"), map(float, np.diff(clock)), strict=True))


def write_runs(store: StudyStore, parts: Iterable[RunColumns]) -> None:
    """Write the table of all runs part by part: those of a million need not be held at once."""
    writer = None
    with store.replacing(store.files.series_name("runs")) as file:
        for part in parts:
            table = pa.table({name: list(column) for name, column in part.items()})
            writer = writer or pq.ParquetWriter(file, table.schema)
            writer.write_table(table)
        if writer is not None:
            writer.close()


def need_room(study: EnsembleStudy, folder: Path) -> None:
    """Reject an ensemble whose samples, beside those that are there, the file system does not hold."""
    there = sum(file.stat().st_size for file in folder.glob("*"))
    needed, free = SAMPLES.itemsize * columns(study.scene) * study.runs - there, shutil.disk_usage(folder).free
    if needed > free:
        raise VariationError(
            f"--runs {study.runs} --samples {study.scene.run.samples}: {needed:.1e} B of samples, but {folder} has "
            f"{free:.1e} B left; fewer of either, or another --out"
        )


def shortened(scene: Scene, orbits: float | None, samples: int) -> Scene:
    """`scene` over its first orbits, sampled at `samples` instants."""
    duration = scene.run.duration_s if orbits is None else min(scene.run.duration_s, orbits * scene.period_s)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration, samples=samples))


def check_numbers(scene: Scene, runs: int) -> None:
    """Reject an ensemble whose least chunk, or whose values of one instant, memory does not hold."""
    numbers = max(columns(scene) * min(runs, LEAST_RUNS), runs)
    if numbers > MOST_NUMBERS:
        raise VariationError(
            f"--runs {runs} --samples {scene.run.samples}: {numbers:.1e} numbers would have to be held, "
            f"allowed: {MOST_NUMBERS:.0e}; fewer samples"
        )
