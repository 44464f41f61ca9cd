"""Run an ensemble and reduce it to quantiles over time."""

from __future__ import annotations

import time
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from barchain.studies.ensemble.kept_parts import KeptParts
from barchain.studies.ensemble.plan import EnsembleOptions, make_plan
from barchain.studies.ensemble.samples import HeldSamples
from barchain.studies.ensemble.tasks import results

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.studies.ensemble.counts import Quantiles
    from barchain.studies.ensemble.plan import EnsemblePlan
    from barchain.studies.ensemble.rows import RunTally
    from scenarios import Scene


@dataclass(frozen=True)
class EnsembleSummary:
    """Result of an ensemble whose size does not grow with the number of runs."""

    scene: Scene
    """As it was run, unperturbed"""
    quantiles: pd.DataFrame
    """Tidy: t_s, quantity (attitude, reaction), item (bar or joint, from 1), quantile, value, unit, runs (that reached
    the instant), error_bound (of an estimated quantile; 0 of an exact one)"""
    estimated: bool
    """Whether quantiles are estimated from counts in bins"""
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
    """(runs, n, N); None if quantiles are estimated"""
    reaction_N: Array | None
    """(runs, n, N-1) sizes; None if quantiles are estimated"""


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
    plan = make_plan(EnsembleOptions(scene, vary, **options))
    kept = KeptParts(plan)
    found = run_ensemble(plan, kept, progress)
    held = kept.samples
    angle_rad, reaction_N = (held.angle_rad, held.reaction_N) if isinstance(held, HeldSamples) else (None, None)
    return EnsembleResult(**vars(found), runs=kept.run_table(), angle_rad=angle_rad, reaction_N=reaction_N)


def run_ensemble(
    plan: EnsemblePlan, kept: KeptParts, progress: Callable[[int], None] = lambda _: None
) -> EnsembleSummary:
    """Draw the copies, run them, and reduce their trajectories to quantiles.

    Parameters
    ----------
    plan : EnsemblePlan
    kept : KeptParts
        Results of the first runs, of an interrupted ensemble or of none; it gets every further part.
    progress : callable
        Called with the number of runs after each part.

    Raises
    ------
    ClusterLostError
        If the plan's cluster fails.
    """
    clock = [time.perf_counter()]
    progress(kept.runs)
    with kept.written(), closing(results(plan, kept.runs)) as parts:
        for task, result in parts:
            kept.add(task, result)
            progress(task.part.runs)
    clock.append(time.perf_counter())
    table = quantile_table(plan, kept.samples.quantiles(plan.quantiles))
    clock.append(time.perf_counter())
    seconds = dict(zip(("run", "reduce"), map(float, np.diff(clock)), strict=True))
    return EnsembleSummary(plan.scene, table, not plan.exact, kept.tally, seconds)


def quantile_table(plan: EnsemblePlan, found: Quantiles) -> pd.DataFrame:
    """Quantiles of the angles and of the sizes of the reactions."""
    angles = plan.scene.run.samples * plan.scene.bars
    attitude = tidy(plan, "attitude", "rad", found.of(slice(angles)))
    if plan.scene.bars == 1:
        return attitude
    return pd.concat([attitude, tidy(plan, "reaction", "N", found.of(slice(angles, None)))], ignore_index=True)


def tidy(plan: EnsemblePlan, quantity: str, unit: str, found: Quantiles) -> pd.DataFrame:
    """Quantiles of one quantity as a tidy table; columns go item by item of each instant."""
    n = plan.scene.run.samples
    shape = (len(plan.quantiles), n, found.value.shape[1] // n)
    return pd.DataFrame(
        {
            "t_s": np.broadcast_to(plan.scene.times_s[:, None], shape).ravel(),
            "quantity": quantity,
            "item": np.broadcast_to(np.arange(1, shape[2] + 1), shape).ravel(),
            "quantile": np.broadcast_to(np.asarray(plan.quantiles)[:, None, None], shape).ravel(),
            "value": found.value.ravel(),
            "unit": unit,
            "runs": np.broadcast_to(found.runs, found.value.shape).ravel(),
            "error_bound": found.error_bound.ravel(),
        }
    )
