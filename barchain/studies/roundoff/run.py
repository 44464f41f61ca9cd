"""The round-off study: its tasks side by side on all cores, then timing alone."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import as_completed
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pebble import ProcessPool

from barchain.boundary.threads import one_thread_each
from barchain.studies.roundoff.parts.times import time_rows
from barchain.studies.roundoff.parts.trajectories import solution_of
from barchain.studies.roundoff.rows import RoundoffRows
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from concurrent.futures import Future

    from barchain.record.study_store import StudyStore
    from barchain.studies.roundoff.parts.trajectories import HighPrecisionSolution
    from barchain.studies.roundoff.plan import RoundoffPlan, RoundoffTask
    from barchain.studies.study import Reporter

Rows = list[dict[str, Any]]
TASK_LIMIT_S = 600.0


def call(function: str, arguments: tuple[Any, ...]) -> Rows:
    """Run a task in this process."""
    module, _, name = function.partition(":")
    found: Rows = getattr(import_module(module), name)(*arguments)
    return found


@dataclass(frozen=True)
class RoundoffResult:
    """Findings of a study beside its tables."""

    failures: tuple[str, ...]
    """Tasks that failed, one line each"""

    @property
    def passed(self) -> bool:
        """Whether all tasks ended well."""
        return not self.failures


class RoundoffRun:
    """One run of the study."""

    def __init__(self, plan: RoundoffPlan, store: StudyStore, reporter: Reporter) -> None:
        """Prepare; `reporter` gets table, task and outcome after each task."""
        self.plan, self.record, self.report = plan, store.record, reporter.step
        self.rows = RoundoffRows(store, plan.parts)

    def run(self) -> RoundoffResult:
        """Run everything and write the tables; an interrupted run leaves the rows so far."""
        try:
            with one_thread_each():
                self.run_tasks()
            if self.plan.time_bars:
                self.rows.keep("times", time_rows(self.plan.time_bars))
                self.report("times", "relative over absolute", str(Outcome.PASS))
        finally:
            self.rows.finish()
        return RoundoffResult(tuple(f"{f['table']}: {f['task']}: {f['reason']}" for f in self.record["failed"]))

    def run_tasks(self) -> None:
        """All tasks in a pool of processes, the high-precision solutions first."""
        context = multiprocessing.get_context("spawn")
        pool = ProcessPool(self.plan.workers or multiprocessing.cpu_count(), context=context)
        try:
            high_precision_solutions = {
                family: pool.schedule(solution_of, (family,)) for family in self.plan.high_precision_solutions
            }
            waiting = {self.schedule(pool, t): k for k, t in enumerate(self.plan.tasks) if t.solution is None}
            for k, task in enumerate(self.plan.tasks):
                if task.solution is not None:
                    waiting[self.schedule(pool, task, high_precision_solutions[task.solution].result())] = k
            for future in as_completed(waiting):
                self.keep(waiting[future], future)
        finally:
            pool.stop()
            pool.join()

    def schedule(self, pool: ProcessPool, task: RoundoffTask, *solution: HighPrecisionSolution) -> Future[Rows]:
        """Queue a task; one that hangs is ended, and costs its own rows."""
        found: Future[Rows] = pool.schedule(call, (task.function, (*solution, *task.arguments)), timeout=TASK_LIMIT_S)
        return found

    def keep(self, place: int, future: Future[Rows]) -> None:
        """Take a task's rows; one that fails costs its own rows, and is noted."""
        task = self.plan.tasks[place]
        try:
            self.rows.keep(task.table, future.result(), place)
        except Exception as error:
            said = f"{type(error).__name__}: {error}".splitlines()[0]
            self.record["failed"].append({"table": task.table, "task": task.title, "reason": said})
            self.report(task.table, f"{task.title}: {said}", str(Outcome.FAILED))
            return
        self.report(task.table, task.title, str(Outcome.PASS))
