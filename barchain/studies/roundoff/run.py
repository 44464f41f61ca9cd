"""The round-off study: its tasks side by side on all cores, then timing alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from barchain.runs.call import Call, CallFailedError
from barchain.runs.message import MessageError
from barchain.studies.roundoff.messages import rows_from, solution_bytes, solution_from, task_bytes
from barchain.studies.roundoff.parts.times import time_rows
from barchain.studies.roundoff.rows import RoundoffRows
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.runs.call import Answer
    from barchain.runs.session import Session
    from barchain.studies.roundoff.parts.trajectories import HighPrecisionSolution, ScaledScene
    from barchain.studies.roundoff.plan import RoundoffPlan, RoundoffTask
    from barchain.studies.study import Reporter

TASK_LIMIT_S = 600.0
SOLUTION_LIMIT_S = 3600.0  # without a high-precision solution none of its tasks is run


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
            self.run_tasks()
            if self.plan.time_bars:
                self.rows.keep("times", time_rows(self.plan.time_bars))
                self.report("times", "relative over absolute", str(Outcome.PASS))
        finally:
            self.rows.finish()
        return RoundoffResult(tuple(f"{f['table']}: {f['task']}: {f['reason']}" for f in self.record["failed"]))

    def run_tasks(self) -> None:
        """All tasks in processes of the executor, the high-precision solutions first."""
        with self.plan.executor.session() as session:
            for family in self.plan.high_precision_solutions:
                session.submit(family, Call(solution_bytes, (family,), SOLUTION_LIMIT_S))
            self.submit(session, None)
            for key, answer in session.answers():
                if isinstance(key, int):
                    self.keep(key, answer)
                else:
                    self.go_on(session, cast("ScaledScene", key), answer)

    def submit(self, session: Session, family: ScaledScene | None, *solution: HighPrecisionSolution) -> None:
        """Queue the tasks that take a solution; one that hangs is ended, and costs its own rows."""
        for k, task in enumerate(self.plan.tasks):
            if task.solution == family:
                session.submit(k, Call(task_bytes, (task.function, (*solution, *task.arguments)), TASK_LIMIT_S))

    def go_on(self, session: Session, family: ScaledScene, answer: Answer) -> None:
        """Queue the tasks of a high-precision solution that has come; without it they fail."""
        try:
            self.submit(session, family, solution_from(family, answer.needed()))
        except (CallFailedError, MessageError, KeyError) as error:
            for task in (t for t in self.plan.tasks if t.solution == family):
                self.fail(task, f"no high-precision solution: {error}")

    def keep(self, place: int, answer: Answer) -> None:
        """Take a task's rows; one that fails costs its own rows, and is noted."""
        task = self.plan.tasks[place]
        try:
            rows = rows_from(answer.needed())
        except (CallFailedError, MessageError) as error:
            self.fail(task, str(error))
            return
        self.rows.keep(task.table, rows, place)
        self.report(task.table, task.title, str(Outcome.PASS))

    def fail(self, task: RoundoffTask, reason: str) -> None:
        """Note a task without rows."""
        self.record["failed"].append({"table": task.table, "task": task.title, "reason": reason})
        self.report(task.table, f"{task.title}: {reason}", str(Outcome.FAILED))
