"""Plan of an ensemble: the scene as it is run, and the quantities that vary, checked before anything is drawn."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.studies.ensemble.cluster import DaskAddress, check_cluster
from barchain.studies.ensemble.limits import WORKERS_S
from barchain.studies.ensemble.variation import VariationError, parse
from scenarios import Scene, load_scene

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.studies.ensemble.variation import Variation

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
RTOL = 1e-8
RUNS = 1000
SAMPLES = 101
MOST_NUMBERS = 1_000_000_000  # 8 GB of angles and reactions


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
    workers: int | None = None
    """Threads; one for each core by default"""
    dask: str | None = None
    """Address of a Dask scheduler that gets the runs instead"""
    dask_wait_s: float = WORKERS_S
    """Longest time that the scheduler may have no worker"""


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
    workers: int | None
    cluster: DaskAddress | None


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
    variations = tuple(parse(text, scene.bars) for text in options.vary)
    check_overlaps(variations)
    check_numbers(scene, options.runs)
    check_draws(variations, scene, options)
    cluster = None if options.dask is None else DaskAddress(options.dask, options.dask_wait_s)
    if cluster is not None:
        check_cluster(cluster)
    return EnsemblePlan(
        scene, variations, options.runs, options.seed, options.rtol, options.quantiles, options.workers, cluster
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
    """Reject draws outside the range of a quantity before a folder is made or a scheduler is asked.

    Draws are the same here and in the run. They are a fraction of the numbers that :func:`check_numbers` allows.
    """
    for variation in variations:
        variation.draw(options.runs, scene.bars, options.seed)


def check_numbers(scene: Scene, runs: int) -> None:
    """Reject an ensemble that memory does not hold."""
    numbers = runs * scene.run.samples * (2 * scene.bars - 1)
    if numbers > MOST_NUMBERS:
        raise VariationError(
            f"--runs {runs}: {numbers:.1e} numbers would have to be held, allowed: {MOST_NUMBERS:.0e}; "
            "fewer runs or --samples"
        )
