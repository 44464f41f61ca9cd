"""Run an ensemble and reduce it to quantiles over time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from barchain.studies.ensemble.cluster import run_on_cluster
from barchain.studies.ensemble.kept_parts import KeptParts
from barchain.studies.ensemble.plan import EnsembleOptions, make_plan
from barchain.studies.ensemble.population import populate
from barchain.studies.ensemble.tasks import assembled, on_threads, run_there, tasks

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.studies.ensemble.plan import EnsemblePlan
    from barchain.studies.ensemble.population import Population
    from barchain.studies.ensemble.tasks import EnsembleTask, EnsembleTaskResult
    from barchain.studies.ensemble.variation import Variation
    from scenarios import Scene


FAILED = "failed"


@dataclass(frozen=True)
class EnsembleResult:
    """Result of an ensemble."""

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

    @property
    def failures(self) -> tuple[str, ...]:
        """Number of failed runs with the first reason, in one line; empty if none failed."""
        failed = self.runs[self.runs["outcome"] == FAILED]
        if failed.empty:
            return ()
        first = failed.iloc[0]
        return (
            f"{len(failed)} of {len(self.runs)} runs failed, the first of them run {first['run']}: {first['reason']}",
        )

    @property
    def passed(self) -> bool:
        """Whether no run failed."""
        return not self.failures


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
        Of :class:`barchain.studies.ensemble.plan.EnsembleOptions`.

    Returns
    -------
    EnsembleResult

    Raises
    ------
    SceneError, VariationError, ClusterError
    """
    return run_ensemble(make_plan(EnsembleOptions(scene, vary, **options)), progress)


def run_ensemble(
    plan: EnsemblePlan, progress: Callable[[int], None] = lambda _: None, kept: KeptParts | None = None
) -> EnsembleResult:
    """Draw the copies, run them, and reduce their trajectories to quantiles.

    Parameters
    ----------
    plan : EnsemblePlan
    progress : callable
        Called with the number of runs after each part.
    kept : KeptParts, optional
        Parts of an interrupted ensemble; it gets every further part.

    Raises
    ------
    ClusterLostError
        If the plan's cluster fails.
    """
    clock = [time.perf_counter()]
    population = populate(plan.scene, plan.variations, plan.runs, plan.seed)
    parts = tasks(population, plan.rtol)
    clock.append(time.perf_counter())
    done = run_parts(plan, parts, progress, kept or KeptParts())
    clock.append(time.perf_counter())
    arrays = dict(assembled(done))
    table = quantile_table(plan, arrays)
    each = run_table(population, plan.variations, done, arrays)
    clock.append(time.perf_counter())
    seconds = dict(zip(("draw", "run", "reduce"), map(float, np.diff(clock)), strict=True))
    return EnsembleResult(plan.scene, table, each, seconds, arrays["angle_rad"], arrays["reaction_N"])


def run_parts(
    plan: EnsemblePlan, parts: list[EnsembleTask], progress: Callable[[int], None], kept: KeptParts
) -> list[EnsembleTaskResult]:
    """Results of all parts in order; those that are kept are not run again."""
    progress(sum(parts[k].part.runs for k in kept.parts))
    left = {k: part for k, part in enumerate(parts) if k not in kept.parts}

    def keep(k: int, result: EnsembleTaskResult) -> None:
        kept.add(k, result)
        progress(parts[k].part.runs)

    with kept.written():
        if plan.cluster is None:
            on_threads(left, plan.workers, keep)
        elif left:
            run_on_cluster(plan.cluster, run_there, left, keep)
    return [kept.parts[k] for k in range(len(parts))]


def quantile_table(plan: EnsemblePlan, arrays: dict[str, Array]) -> pd.DataFrame:
    """Quantiles over the runs of the angles and of the sizes of the reactions."""
    t_s, quantiles = plan.scene.times_s, plan.quantiles
    return pd.concat(
        [
            reduced(t_s, "attitude", "rad", arrays["angle_rad"], quantiles),
            reduced(t_s, "reaction", "N", arrays["reaction_N"], quantiles),
        ],
        ignore_index=True,
    )


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
    columns["outcome"] = [FAILED if f else "ended" if e else "finished" for e, f in zip(ended, failed, strict=True)]
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
