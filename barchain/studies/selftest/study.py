"""A self-test from start to tables: what the command line and notebooks call."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from barchain.record.environment import provenance
from barchain.run.job import SOLUTION_ROLES, Role
from barchain.studies.selftest.detection_limit import brackets, most_trials, settled
from barchain.studies.selftest.faults.catalogue import CONTROLS
from barchain.studies.selftest.matrix import HOST, Matrix, matrix
from barchain.studies.selftest.store import SelftestStore
from barchain.studies.selftest.trial import selftest_cases
from reports.tables.selftest import FOLDER

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager
    from pathlib import Path

    from barchain.studies.selftest.faults.fault import Fault
    from barchain.studies.selftest.trial import SelftestCase
    from scenarios import Scene

    Counter = Callable[[str, int], AbstractContextManager[Callable[[int], None]]]


@dataclass(frozen=True)
class SelftestPlan:
    """What is to be tried."""

    scenes: tuple[Scene, ...]
    faults: tuple[Fault, ...]
    host: str = HOST
    smallest: bool = False
    """Whether the smallest sizes are looked for"""
    workers: int | None = None


def selftest(plan: SelftestPlan, out: Path, *, command: str, counted: Counter) -> Matrix:
    """Try every fault in every scene, and write the tables into ``out/selftest``.

    Parameters
    ----------
    plan : Plan
    out : Path
        Result folder; a comparison that is there already is left alone.
    command : str
        What was typed, for the record.
    counted : callable
        Given what is done and how often, a context with a callback to count it.

    Returns
    -------
    Matrix

    Raises
    ------
    SelftestError
        If a truth or a control can't be run.
    """
    start = time.perf_counter()
    store = SelftestStore(out / FOLDER, new_record(plan, command))
    with counted("certified_solutions", len(plan.scenes) * len(SOLUTION_ROLES)) as done:
        found = selftest_cases(plan.scenes, plan.host, workers=plan.workers, done=done)
    with counted("faults", len(plan.scenes) * (len(plan.faults) + len(CONTROLS))) as done:
        tried, ready = matrix(plan.faults, found, plan.host, workers=plan.workers, done=done)
    store.keep_matrix(tried)
    if plan.smallest:
        look_for_smallest(plan, tried, ready, store, counted)
    store.record.update(finished=True, seconds=time.perf_counter() - start)
    store.write_record()
    return tried


def look_for_smallest(
    plan: SelftestPlan, tried: Matrix, ready: list[SelftestCase], store: SelftestStore, counted: Counter
) -> None:
    """Bisect the sizes."""
    pairs = brackets(tried.cells, ready)
    with counted("sizes", most_trials(pairs)) as done:
        store.keep_smallest(settled(pairs, workers=plan.workers, done=done))


def new_record(plan: SelftestPlan, command: str) -> dict[str, Any]:
    """selftest.json before the first run."""
    return provenance(command) | {
        "host": plan.host,
        "roles": [str(Role.MAIN), str(Role.FINER)],
        "scenes": {s.name: scene_words(s) for s in plan.scenes},
        "faults": {f.name: fault_words(f) for f in (*CONTROLS.values(), *plan.faults)},
    }


def scene_words(scene: Scene) -> dict[str, Any]:
    """What the record says of a scene."""
    return {
        "title": scene.title,
        "bars": scene.bars,
        "duration_s": scene.run.duration_s,
        "samples": scene.run.samples,
        "effects": sorted(scene.effects.names),
    }


def fault_words(fault: Fault) -> dict[str, Any]:
    """What the record says of a fault."""
    size = fault.size
    return {
        "words": fault.words,
        "stands_for": fault.stands_for,
        "group": str(fault.group),
        "natural": size.natural if size else None,
        "none": size.none if size else None,
        "unit": size.unit if size else "",
        "invisible": fault.invisible,
    }
