"""Run an ensemble and reduce it to quantiles over time."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from barchain.studies.ensemble.population import populate
from barchain.studies.ensemble.tasks import assembled, on_cluster, on_threads, tasks
from barchain.studies.ensemble.variation import VariationError, parse
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.studies.ensemble.population import Population
    from barchain.studies.ensemble.tasks import EnsembleTaskResult
    from barchain.studies.ensemble.variation import Variation
    from scenarios import Scene

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
RTOL = 1e-8
SAMPLES = 101
MOST_NUMBERS = 1_000_000_000  # 8 GB of angles and reactions


@dataclass(frozen=True)
class EnsembleResult:
    """What an ensemble showed."""

    scene: Scene
    """As it was run, unperturbed"""
    quantiles: pd.DataFrame
    """Tidy: t_s, quantity (attitude, reaction), item (bar or joint, from 1), quantile, value, unit, runs (that reached
    the instant)"""
    runs: pd.DataFrame
    """One row a run: what was drawn, outcome (finished, ended, failed), reason, steps, evaluations"""
    seconds: dict[str, float]
    """Wall time: draw, run, reduce"""
    angle_rad: Array
    """(runs, n, N)"""
    reaction_N: Array
    """(runs, n, N-1) sizes"""


def ensemble(
    scene: Scene | str | Path,
    vary: Iterable[str],
    *,
    runs: int = 1000,
    seed: int = 1,
    rtol: float = RTOL,
    orbits: float | None = None,
    samples: int = SAMPLES,
    quantiles: tuple[float, ...] = QUANTILES,
    workers: int | None = None,
    dask: str | None = None,
    progress: Callable[[int], None] = lambda _: None,
) -> EnsembleResult:
    """Run many perturbed copies of a scene in the compiled reference.

    Parameters
    ----------
    scene : Scene, str or Path
    vary : iterable of str
        What varies, e.g. ``"angle_deg=normal(80, 1)"``; see :mod:`barchain.studies.ensemble.variation`.
    runs : int
    seed : int
        Equal seeds draw equal copies, whatever runs them.
    rtol : float
        Requested accuracy of a step.
    orbits : float, optional
        How much of the scene is run, from its start; all of it by default.
    samples : int
        Equally spaced instants.
    quantiles : tuple of float
    workers : int, optional
        Threads; as many as there are cores by default.
    dask : str, optional
        Address of a Dask scheduler that gets the runs instead.
    progress : callable
        Told the number of runs after each part.

    Returns
    -------
    EnsembleResult

    Raises
    ------
    SceneError, VariationError, ClusterError
    """
    found = shortened(load_scene(scene) if not hasattr(scene, "chain") else scene, orbits, samples)  # type: ignore[arg-type]
    clock = [time.perf_counter()]
    population, variations = drawn(found, tuple(vary), runs, seed)
    parts = tasks(population, rtol)
    clock.append(time.perf_counter())
    done = on_cluster(parts, dask, progress) if dask else on_threads(parts, workers, progress)
    clock.append(time.perf_counter())
    arrays = dict(assembled(done))
    table = pd.concat(
        [
            reduced(found.times_s, "attitude", "rad", arrays["angle_rad"], quantiles),
            reduced(found.times_s, "reaction", "N", arrays["reaction_N"], quantiles),
        ],
        ignore_index=True,
    )
    each = run_table(population, variations, done, arrays)
    clock.append(time.perf_counter())
    seconds = dict(zip(("draw", "run", "reduce"), map(float, np.diff(clock)), strict=True))
    return EnsembleResult(found, table, each, seconds, arrays["angle_rad"], arrays["reaction_N"])


def shortened(scene: Scene, orbits: float | None, samples: int) -> Scene:
    """`scene` over its first orbits, seen at `samples` instants."""
    duration = scene.run.duration_s if orbits is None else min(scene.run.duration_s, orbits * scene.period_s)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration, samples=samples))


def drawn(scene: Scene, vary: tuple[str, ...], runs: int, seed: int) -> tuple[Population, tuple[Variation, ...]]:
    """Copies of `scene`, and what varies in them."""
    variations = tuple(parse(text, scene.bars) for text in vary)
    for k, v in enumerate(variations):
        if any(overlap(v, other) for other in variations[:k]):
            raise VariationError(
                f"--vary {v.text}: {v.key} of the same bars is given twice; allowed: once for each bar"
            )
    numbers = runs * scene.run.samples * (2 * scene.bars - 1)
    if numbers > MOST_NUMBERS:
        raise VariationError(
            f"--runs {runs}: {numbers:.1e} numbers would have to be held, allowed: {MOST_NUMBERS:.0e}; "
            "fewer runs or --samples"
        )
    return populate(scene, variations, runs, seed), variations


def overlap(a: Variation, b: Variation) -> bool:
    """Whether two variations speak of the same number of some bar."""
    return a.key == b.key and (not a.bar or not b.bar or a.bar == b.bar)


def reduced(t_s: Array, quantity: str, unit: str, values: Array, quantiles: tuple[float, ...]) -> pd.DataFrame:
    """Quantiles over the runs of `values`, shape (runs, n, items), as a tidy table; NaN counts as not reached."""
    runs, n, items = values.shape
    if not items:
        return pd.DataFrame()
    columns = np.ascontiguousarray(values.reshape(runs, n * items).T)
    reached = runs - np.isnan(columns).sum(axis=1)
    found = np.full((len(quantiles), n * items), np.nan)
    whole = reached == runs
    found[:, whole] = np.quantile(columns[whole], quantiles, axis=1)
    for k in np.nonzero(~whole & (reached > 0))[0]:
        found[:, k] = np.nanquantile(columns[k], quantiles)
    shape = (len(quantiles), n, items)
    grid = np.broadcast_arrays(
        np.asarray(quantiles)[:, None, None], t_s[None, :, None], np.arange(1, items + 1)[None, None, :]
    )
    return pd.DataFrame(
        {
            "t_s": grid[1].ravel(),
            "quantity": quantity,
            "item": grid[2].ravel(),
            "quantile": grid[0].ravel(),
            "value": found.reshape(shape).ravel(),
            "unit": unit,
            "runs": np.broadcast_to(reached.reshape(n, items), shape).ravel(),
        }
    )


def run_table(
    population: Population, variations: tuple[Variation, ...], parts: list[EnsembleTaskResult], arrays: dict[str, Array]
) -> pd.DataFrame:
    """One row for each run."""
    ended = [text for p in parts for text in p.ended]
    failed = [text for p in parts for text in p.failed]
    columns: dict[str, object] = {"run": np.arange(1, population.runs + 1)}
    for v in variations:
        columns |= drawn_columns(population, v)
    columns["outcome"] = ["failed" if f else "ended" if e else "finished" for e, f in zip(ended, failed, strict=True)]
    columns["reason"] = [f or e for e, f in zip(ended, failed, strict=True)]
    columns["steps"], columns["evaluations"] = arrays["steps"].astype(int), arrays["evaluations"].astype(int)
    return pd.DataFrame(columns)


def drawn_columns(population: Population, v: Variation) -> dict[str, Array]:
    """Columns of the values that one variation drew, in the units it was given in."""
    name = v.key.replace("_deg", "_rad")
    values = np.degrees(getattr(population, name)) if v.key.endswith("_deg") else getattr(population, name)
    if values.ndim == 1:
        return {v.key: values}
    if v.bar is None:
        return {v.key: values[:, 0]}
    bars = range(1, values.shape[1] + 1) if v.bar == 0 else [v.bar]
    return {f"{v.key}[{bar}]": values[:, bar - 1] for bar in bars}
