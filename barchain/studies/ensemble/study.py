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

from barchain.runs.executors import ALL_CORES, DaskCluster, KeptAnswers
from barchain.runs.facts import scene_facts
from barchain.runs.timing.estimate import need_runnable
from barchain.studies.ensemble.chunks import LEAST_RUNS, SAMPLES, columns, run_chunks
from barchain.studies.ensemble.population import EnsemblePlan, check_effects, populations
from barchain.studies.ensemble.statistics import RunTally, quantile_table, run_rows, run_table, run_text
from barchain.studies.ensemble.variation import VariationError, parse
from reports.tables.ensemble import FILES
from reports.tables.files import ANSWERS
from scenarios import Scene, load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import pandas as pd

    from adapters.trajectory import Array
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.ensemble.chunks import ChunkFiles
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
RTOL = 1e-8
RUNS = 1000
SAMPLES_OF_A_RUN = 101
MOST_HELD = 10_000_000  # angles and reactions that the function for Python returns, 80 MB
MOST_NUMBERS = 1_000_000_000  # 8 GB
CHECKED_AT_ONCE = 50_000  # bars of the copies that are drawn together


@dataclass(frozen=True)
class EnsembleOptions:
    """Options of an ensemble."""

    scene: Scene | str | Path
    vary: Iterable[str]
    """Distributions, e.g. ``"angle_deg=normal(80, 1)"``; see :mod:`barchain.studies.ensemble.variation`"""
    runs: int = RUNS
    seed: int = 1
    """Equal seeds draw equal copies, on threads and on a cluster"""
    rtol: float = RTOL
    """Requested accuracy of a step"""
    orbits: float | None = None
    """Part of the scene that is run, from its start; all of it by default"""
    samples: int = SAMPLES_OF_A_RUN
    """Number of equally spaced instants"""
    quantiles: tuple[float, ...] = QUANTILES
    executor: Executor = ALL_CORES
    """Place of the runs; on this machine they share a process, with one thread for each of its workers"""


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
    reaction_N: Array | None
    """(runs, n, N-1) sizes; None as the angles"""


def ensemble(
    scene: Scene | str | Path, vary: Iterable[str], *, progress: Callable[[int], None] = lambda _: None, **options: Any
) -> EnsembleResult:
    """Run many perturbed copies of a scene in the compiled reference.

    Parameters
    ----------
    scene : Scene, str or Path
    vary : iterable of str
        Distributions, e.g. ``"angle_deg=normal(80, 1)"``.
    progress : callable
        Called with the number of runs after each part.
    **options
        Of :class:`EnsembleOptions`.

    Returns
    -------
    EnsembleResult

    Raises
    ------
    SceneError, VariationError, ClusterError
    """
    with tempfile.TemporaryDirectory() as folder:
        planned = make_plan(EnsembleOptions(scene, vary, **options))
        assert not isinstance(planned.executor, KeptAnswers)  # which a study's run is given, not its options
        plan = dataclasses.replace(planned, executor=KeptAnswers(Path(folder), planned.executor))
        made, quantiles, seconds = reduced(plan, Path(folder), progress)
        tally = RunTally()
        runs = run_table(run_rows(made, tally))
        n, bars, angle_rad, reaction_N = plan.scene.run.samples, plan.scene.bars, None, None
        if plan.runs * columns(plan.scene) <= MOST_HELD:
            samples = made.samples().T
            angle_rad = np.ascontiguousarray(samples[:, : n * bars]).reshape(plan.runs, n, bars)
            reaction_N = np.ascontiguousarray(samples[:, n * bars :]).reshape(plan.runs, n, bars - 1)
    return EnsembleResult(plan.scene, quantiles, tally, seconds, runs, angle_rad, reaction_N)


def reduced(
    plan: EnsemblePlan, folder: Path, progress: Callable[[int], None]
) -> tuple[ChunkFiles, pd.DataFrame, dict[str, float]]:
    """Run the copies, their answers kept in a folder, and take quantiles; the wall time of both.

    Raises
    ------
    VariationError
        If the file system of the folder has no room for all samples.
    ClusterLostError
        If the plan's cluster fails.
    """
    clock = [time.perf_counter()]
    need_room(plan, folder)
    made = run_chunks(plan, progress)
    clock.append(time.perf_counter())
    quantiles = quantile_table(made)
    clock.append(time.perf_counter())
    return made, quantiles, dict(zip(("run", "reduce"), map(float, np.diff(clock)), strict=True))


def need_room(plan: EnsemblePlan, folder: Path) -> None:
    """Reject an ensemble whose samples, beside those that are there, the file system does not hold."""
    there = sum(file.stat().st_size for file in (folder / ANSWERS).glob("*"))
    needed, free = SAMPLES.itemsize * columns(plan.scene) * plan.runs - there, shutil.disk_usage(folder).free
    if needed > free:
        raise VariationError(
            f"--runs {plan.runs} --samples {plan.scene.run.samples}: {needed:.1e} B of samples, but {folder} has "
            f"{free:.1e} B left; fewer of either, or another --out"
        )


def make_plan(options: EnsembleOptions) -> EnsemblePlan:
    """Plan of an ensemble.

    Raises
    ------
    SceneError
        For a scene that does not exist.
    VariationError
        For a distribution that can't be read, for a quantity that varies twice, or for more numbers than memory holds.
    ClusterError
        For a Dask cluster that can't be used.
    """
    given = options.scene if isinstance(options.scene, Scene) else load_scene(options.scene)
    scene = shortened(given, options.orbits, options.samples)
    need_runnable([scene])
    variations = tuple(parse(text, scene.bars) for text in options.vary)
    for k, v in enumerate(variations):
        if any(v.overlaps(other) for other in variations[:k]):
            raise VariationError(
                f"--vary {v.text}: {v.key} of the same bars is given twice; allowed: once for each bar"
            )
    check_numbers(scene, options.runs)
    check_effects(scene, variations)
    at_once = max(1, CHECKED_AT_ONCE // scene.bars)
    for _ in populations(scene, variations, options.runs, options.seed, at_once):
        pass  # draws that a run could not have end the command before a folder is made or a scheduler is asked
    options.executor.check()
    return EnsemblePlan(
        scene, variations, options.runs, options.seed, options.rtol, options.quantiles, options.executor
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


@dataclass(frozen=True)
class EnsembleStudy:
    """The ensemble study."""

    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: EnsembleOptions) -> EnsemblePlan:
        """Scene and variations, checked.

        Raises
        ------
        SceneError, VariationError, ClusterError
            For options that can't be met.
        """
        return make_plan(options)

    def record(self, plan: EnsemblePlan) -> dict[str, Any]:
        """Scene, distributions and settings; outcomes and times are added at the end."""
        return {
            "scene": {"name": plan.scene.name} | scene_facts(plan.scene),
            "vary": [v.text for v in plan.variations],
            "runs": plan.runs,
            "rtol": plan.rtol,
            "seed": plan.seed,
        }

    def run(self, plan: EnsemblePlan, store: StudyStore, reporter: Reporter) -> EnsembleSummary:
        """Draw, run and reduce the copies.

        Raises
        ------
        ClusterLostError
            If the plan's cluster fails; results so far are in the folder.
        """
        assert isinstance(plan.executor, KeptAnswers)
        store.record["dask"] = isinstance(plan.executor.inside, DaskCluster)
        with reporter.counted("runs", plan.runs) as done:
            made, quantiles, seconds = reduced(plan, store.folder, done)
        tally = RunTally()
        store.write("quantiles", quantiles)
        store.write_text("runs", run_text(run_rows(made, tally)))
        store.record["outcomes"] = dict(tally.outcomes.most_common())
        store.record["evaluations"] = tally.evaluations
        store.record["phases_s"] = seconds
        shutil.rmtree(store.folder / ANSWERS)  # the tables say all; the samples may take gigabytes
        return EnsembleSummary(plan.scene, quantiles, tally, seconds)
