"""Runs of a cost study: scenes cut to their first orbits, every engine's accuracy sweep, and which runs are tried."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from barchain.runs.asking import declarations_of
from barchain.runs.job import Job, Role
from barchain.runs.left_out import LeftOut, cannot
from barchain.studies.cost.errors import MEASURED
from reports.results.cost import INDEPENDENT, OWN_EQUATIONS
from reports.results.outcome import Outcome
from reports.results.rows import NotRun

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.engine import AccuracySweep, Setting
    from adapters.registry import Registration
    from reports.results.rows import Row
    from scenarios import Scene

SAMPLES = 21  # few, so that no engine is timed at interpolating samples; certified solutions have these instants
SHORTENED = "the time budget is half used"
"""Why a run may then take less time"""
REPEATED_LOAD = "repeated_load"
"""Option of an engine that applies each load twice, at half strength. The motion stays the same up to round-off, and
the additional time is that of the loads once more"""
LONGEST_LOADED_S = 0.1  # of a run whose loads are timed: the finest setting below, where fixed costs are least

PointName = tuple[str, str, str]
"""Scene, engine and setting"""


def kind_of(registration: Registration) -> str:
    """Kind of an engine: one of :data:`reports.results.cost.KINDS`."""
    return INDEPENDENT if registration.external else OWN_EQUATIONS


def name_of(job: Job) -> PointName:
    """Name of the point that a run measures."""
    return job.scene.name, job.engine, str(job.setting)


def shortened(scene: Scene, orbits: float = 1.0) -> Scene:
    """`scene` over its first orbits, or its whole run if that is shorter, at :data:`SAMPLES` instants."""
    duration_s = min(orbits * scene.period_s, scene.run.duration_s)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration_s, samples=SAMPLES))


def distinct(scene: Scene, sweep: AccuracySweep) -> list[Setting]:
    """Settings of an accuracy sweep, coarse to fine, without those that round to the same steps as a coarser one."""
    if sweep.parameter is AccuracyParameter.RTOL:
        return list(sweep.settings)
    kept: dict[float, Setting] = {}
    for setting in sweep.settings:
        kept.setdefault(step_s(scene, setting.value), setting)
    return list(kept.values())


def sweeps(scene: Scene, engines: dict[str, Registration]) -> tuple[dict[str, list[Job]], list[LeftOut]]:
    """Runs of each engine on a scene, coarse to fine, and the engines left out."""
    runs: dict[str, list[Job]] = {}
    out: list[LeftOut] = []
    for name, registration in engines.items():
        reason = cannot(scene, name, registration)
        if reason is not None:
            out.append(reason)
            continue
        settings = distinct(scene, declarations_of(registration).sweep)
        runs[name] = [Job(scene, name, registration, s, Role.MAIN) for s in settings]
    return runs, out


def too_long(coarser: list[tuple[Job, Row]], job: Job, limit_s: float, *, hasty: bool = False) -> Row | None:
    """Columns of a run that is skipped: a coarser run timed out, or this one is expected to; None of one to be made.

    `hasty` if the limit is one that was shortened for the budget.
    """
    ends = {row["outcome"] for _, row in coarser}
    if ends & {Outcome.TIMED_OUT.value, NotRun.LIMIT, NotRun.BUDGET}:
        return late("a coarser setting is past the time limit already", hasty=NotRun.BUDGET in ends)
    timed = [(c, float(row["seconds"])) for c, row in coarser if row.get("seconds", 0.0) > 0.0]
    if not timed:
        return None
    last, seconds = timed[-1]
    growth = 1.0
    if job.setting.parameter is AccuracyParameter.STEPS_PER_ORBIT:
        growth = step_s(job.scene, last.setting.value) / step_s(job.scene, job.setting.value)
    elif len(timed) > 1:
        growth = max(1.0, seconds / timed[-2][1])
    expected_s = seconds * growth
    if expected_s <= limit_s:
        return None
    return late(f"past the time limit, {limit_s:g} s", f": about {expected_s:.2g} s expected", hasty=hasty)


def late(said: str, more: str = "", *, hasty: bool) -> Row:
    """Columns of a run that is skipped for the time limit, or for one that is shortened for the budget."""
    outcome, why = (NotRun.BUDGET, f", as {SHORTENED}") if hasty else (NotRun.LIMIT, "")
    return {"outcome": str(outcome), "reason": f"{said}{why}{more}"}


def too_fine(coarser: list[Row]) -> Row | None:
    """Columns of a run that is skipped: both coarser runs lie below the certified solution's own error; else None."""
    before = coarser and coarser[-1]["outcome"] == NotRun.BLURRED
    if before or (len(coarser) > 1 and all(map(blurred, coarser[-2:]))):
        return {
            "outcome": str(NotRun.BLURRED),
            "reason": "coarser settings lie under the certified solution's own error",
        }
    return None


def blurred(row: Row) -> bool:
    """Whether all errors of a point are below the certified solution's own."""
    present = {channel.name for channel in MEASURED if row.get(channel.column_of("error"), np.nan) >= 0.0}
    return bool(present) and present <= set(str(row.get("under_floor") or "").split(","))


def load_jobs(sweeps: Iterable[list[Job]], points: Mapping[PointName, Row]) -> list[Job]:
    """Runs whose loads are timed: the finest good setting of each engine with the option that is brief enough.

    Parameters
    ----------
    sweeps : iterable of list of Job
        Settings of each engine, coarse to fine.
    points : mapping
        Measured points.
    """
    found = []
    for jobs in sweeps:
        good = [j for j in jobs if points[name_of(j)]["outcome"] == Outcome.PASS.value]
        brief = [j for j in good if points[name_of(j)]["seconds"] <= LONGEST_LOADED_S]
        if good and REPEATED_LOAD in declarations_of(good[0].registration).options:
            found.append(brief[-1] if brief else good[0])
    return found
