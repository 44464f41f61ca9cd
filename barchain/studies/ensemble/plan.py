"""Plan of an ensemble: the scene as it is run, and the quantities that vary, checked before anything is drawn."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.runs.executors import ALL_CORES
from barchain.runs.timing.estimate import need_runnable
from barchain.studies.ensemble.bins import BINS, PILOT_RUNS
from barchain.studies.ensemble.population import check_effects, populations
from barchain.studies.ensemble.variation import VariationError, parse
from scenarios import Scene, load_scene

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.runs.executors import Executor
    from barchain.studies.ensemble.variation import Variation

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
RTOL = 1e-8
RUNS = 1000
SAMPLES = 101
MOST_HELD = 10_000_000  # angles and reactions for exact quantiles, 80 MB; more are counted in bins
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
    samples: int = SAMPLES
    """Number of equally spaced instants"""
    quantiles: tuple[float, ...] = QUANTILES
    executor: Executor = ALL_CORES
    """Place of the runs; on this machine they share a process, with one thread for each of its workers"""


@dataclass(frozen=True)
class EnsemblePlan:
    """Copies to be drawn and run."""

    scene: Scene
    """As it is run, unperturbed"""
    variations: tuple[Variation, ...]
    runs: int
    seed: int
    rtol: float
    quantiles: tuple[float, ...]
    executor: Executor

    @property
    def exact(self) -> bool:
        """Whether all samples are held for exact quantiles: if they are few, or take no more room than bins."""
        return self.runs <= max(PILOT_RUNS + BINS, MOST_HELD // columns(self.scene))


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
    check_overlaps(variations)
    check_numbers(scene, options.runs)
    check_draws(variations, scene, options)
    options.executor.check()
    return EnsemblePlan(
        scene, variations, options.runs, options.seed, options.rtol, options.quantiles, options.executor
    )


def shortened(scene: Scene, orbits: float | None, samples: int) -> Scene:
    """`scene` over its first orbits, sampled at `samples` instants."""
    duration = scene.run.duration_s if orbits is None else min(scene.run.duration_s, orbits * scene.period_s)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration, samples=samples))


def check_overlaps(variations: tuple[Variation, ...]) -> None:
    """Reject two variations of one quantity of one bar."""
    for k, v in enumerate(variations):
        if any(overlap(v, other) for other in variations[:k]):
            raise VariationError(
                f"--vary {v.text}: {v.key} of the same bars is given twice; allowed: once for each bar"
            )


def overlap(a: Variation, b: Variation) -> bool:
    """Whether two variations change the same quantity of some bar."""
    return a.key == b.key and (not a.bar or not b.bar or a.bar == b.bar)


def check_draws(variations: tuple[Variation, ...], scene: Scene, options: EnsembleOptions) -> None:
    """Reject effects and draws that a run could not have, before a folder is made or a scheduler is asked.

    Draws are the same here and in the run.
    """
    check_effects(scene, variations)
    size = max(1, CHECKED_AT_ONCE // scene.bars)
    for _ in populations(scene, variations, options.runs, options.seed, size):
        pass


def columns(scene: Scene) -> int:
    """Angles and reactions of a run at all samples."""
    return scene.run.samples * (2 * scene.bars - 1)


def check_numbers(scene: Scene, runs: int) -> None:
    """Reject an ensemble whose samples, or whose first runs and bins, memory does not hold."""
    numbers = columns(scene) * min(runs, PILOT_RUNS + BINS)
    if numbers > MOST_NUMBERS:
        raise VariationError(
            f"--runs {runs} --samples {scene.run.samples}: {numbers:.1e} numbers would have to be held, "
            f"allowed: {MOST_NUMBERS:.0e}; fewer samples"
        )
