"""The self-test: known faults inserted into an engine, and the checks that detect them."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.registry import find_own_engine
from barchain.faults.catalogue import CONTROLS, FIXED_SCENES, find
from barchain.runs.declared import engine_class
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import SOLUTION_ROLES, Role
from barchain.solutions.reference_runs import NUMPY
from barchain.studies.selftest.detection_limit import brackets, most_trials, settled
from barchain.studies.selftest.matrix import HOST, Matrix, SelftestError, matrix
from barchain.studies.selftest.runs import RunCache, in_workers
from barchain.studies.selftest.scenes import STAGES, find_scene
from barchain.studies.selftest.trial_runner import TrialRunner
from reports.tables.faults.selftest import FILES

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.faults.fault import Fault
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.selftest.check_results import FaultCell
    from barchain.studies.selftest.runs import Runner
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles
    from scenarios import Scene


@dataclass(frozen=True)
class SelftestOptions:
    """Options of a self-test."""

    scenes: Iterable[str] = ()
    """Names or files; eight short scenes by default"""
    faults: Iterable[str] = ()
    """Names; all by default"""
    host: str = HOST
    """Engine that the faults are inserted into; faults in the code itself need the reference"""
    smallest: bool = False
    """Whether the smallest detected size of each continuous fault is looked for"""
    executor: Executor = ALL_CORES
    """Place of the runs; all cores of this machine by default"""


@dataclass(frozen=True)
class SelftestPlan:
    """Scenes, faults and their host."""

    scenes: tuple[Scene, ...]
    faults: tuple[Fault, ...]
    host: str = HOST
    smallest: bool = False
    executor: Executor = ALL_CORES
    left_out: dict[str, str] = field(default_factory=dict)
    """Scenes that the host does not support, with the reason"""


@dataclass(frozen=True)
class SelftestStudy:
    """The self-test."""

    runner: Runner | None = None
    """Makes runs, see :mod:`barchain.studies.selftest.runs`; by default the plan's executor"""
    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: SelftestOptions) -> SelftestPlan:
        """Scenes that the host supports, and faults.

        Raises
        ------
        SceneError, UnknownFaultError, UnknownEngineError
            For a scene, a fault or an engine that does not exist.
        ClusterError
            For a Dask cluster that can't be used.
        """
        engine = engine_class(find_own_engine(options.host))
        faults = [find(n, FIXED_SCENES) for n in dict.fromkeys(options.faults or FIXED_SCENES) if n not in CONTROLS]
        scenes = list(map(find_scene, dict.fromkeys(options.scenes or STAGES)))
        reasons = {s.name: engine.unsupported(s) for s in scenes}
        able = tuple(s for s in scenes if not reasons[s.name])
        left_out = {name: reason for name, reason in reasons.items() if reason}
        options.executor.check()
        return SelftestPlan(able, tuple(faults), options.host, options.smallest, options.executor, left_out)

    def record(self, plan: SelftestPlan) -> dict[str, Any]:
        """Host, scenes and faults in words."""
        return {
            "host": plan.host,
            "roles": [str(Role.MAIN), str(Role.FINER)],
            "scenes": {s.name: scene_words(s) for s in plan.scenes},
            "faults": {f.name: fault_words(f) for f in (*CONTROLS.values(), *plan.faults)},
        }

    def run(self, plan: SelftestPlan, store: StudyStore, reporter: Reporter) -> Matrix:
        """Try every fault in every scene.

        Raises
        ------
        SelftestError
            If a reference solution or a control can't be run.
        """
        runner = TrialRunner(RunCache(self.runner or in_workers(plan.executor)))
        with reporter.counted("reference solutions", len(plan.scenes) * len(SOLUTION_ROLES)) as done:
            runner.solve(plan.scenes, NUMPY, done)
        for scene, reason in runner.failed.items():
            raise SelftestError(f"{scene}: {reason}")
        with (
            reporter.counted("faults", len(plan.scenes) * (len(plan.faults) + len(CONTROLS))) as done,
            kept_if_interrupted(store) as seen,
        ):
            tried = matrix(plan.faults, plan.scenes, runner, plan.host, done=done, seen=seen)
        store.write("selftest", (row for cell in tried.cells for row in cell.rows()))
        store.record.update(passed=tried.passed, unkilled=[f.name for f in tried.unkilled])
        if plan.smallest:
            look_for_smallest(plan, tried, runner, store, reporter)
        return tried


@contextlib.contextmanager
def kept_if_interrupted(store: StudyStore) -> Iterator[Callable[[FaultCell], None]]:
    """Write the cells so far if the matrix is interrupted: a fault that no check detects is told then too."""
    cells: list[FaultCell] = []
    try:
        yield cells.append
    except KeyboardInterrupt:
        if cells:
            store.write("selftest", (row for cell in cells for row in cell.rows()))
        raise


def look_for_smallest(
    plan: SelftestPlan, tried: Matrix, runner: TrialRunner, store: StudyStore, reporter: Reporter
) -> None:
    """Bisect the size of each continuous fault, after the matrix is on disk."""
    store.write_record()
    pairs = brackets(tried.cells, plan.scenes, plan.host)
    with reporter.counted("sizes", most_trials(pairs)) as done:
        for pair in settled(pairs, runner, done):
            pair.add_rows(store.summary)


def scene_words(scene: Scene) -> dict[str, Any]:
    """Entry of a scene in the record."""
    return {
        "title": scene.title,
        "bars": scene.bars,
        "duration_s": scene.run.duration_s,
        "samples": scene.run.samples,
        "effects": sorted(scene.effects.names),
    }


def fault_words(fault: Fault) -> dict[str, Any]:
    """Entry of a fault in the record."""
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
