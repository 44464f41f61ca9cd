"""The round-off study: digits of the reactions that each kind of coordinates leaves.

Its tasks are cases that run side by side; then evaluations are timed alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from barchain.record.environment import package_version
from barchain.runs.call import Call, CallFailedError
from barchain.runs.cases import Shared, Task, run_cases
from barchain.runs.executors import ALL_CORES, KeptAnswers
from barchain.runs.message import MessageError, message_bytes, plain_text, read_message
from barchain.studies.roundoff.engine_laws import engine_laws
from barchain.studies.roundoff.laws import best_laws, best_table, evaluation_laws, growth_laws
from barchain.studies.roundoff.plan import PARTS, SCENE, tasks_of, timed_tasks
from barchain.studies.roundoff.states import EQUATOR_M, MEMBERS
from barchain.studies.roundoff.trajectories import solution_bytes, solution_from
from barchain.studies.study import StudyEnd
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT_DIGITS, long_doubles
from reports.tables.outcome import Outcome
from reports.tables.roundoff import FILES

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from barchain.record.study_store import StudyStore
    from barchain.runs.call import Answer
    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.studies.roundoff.plan import RoundoffTask
    from barchain.studies.roundoff.trajectories import HighPrecisionSolution, ScaledScene
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles

    Rows = list[dict[str, Any]]

TASK_LIMIT_S = 600.0
SOLUTION_LIMIT_S = 3600.0  # without a high-precision solution none of its tasks is run
FIRST, LATER = (0.0,), (1.0,)
"""Priorities of high-precision solutions and of tasks"""
PLAIN = (str, int, float, type(None))
OBJECTS = tuple(
    {"name": name, "length_m": length_m, "ratio": length_m / EQUATOR_M}
    for name, length_m in (
        ("20 km tether", 20e3), ("1 km tether", 1e3), ("100 m truss", 100.0), ("7 m robot arm link", 7.0),
        ("10 cm CubeSat", 0.1), ("5 mm hinge", 5e-3), ("10 µm MEMS beam", 1e-5),
    )
)  # fmt: skip
"""Objects on the axis of sizes, from the longest"""
DERIVED = {
    "laws": ("evaluation", evaluation_laws),
    "growth_laws": ("growth", growth_laws),
    "engine_laws": ("engines", engine_laws),
}
"""Tables that follow from others"""


@dataclass(frozen=True)
class RoundoffStudy:
    """Tasks of some parts."""

    tasks: tuple[RoundoffTask, ...]
    timed: tuple[RoundoffTask, ...] = ()
    """Tasks whose times count: they are made after all else, one by one"""
    full: bool = False
    parts: tuple[str, ...] = PARTS
    executor: Executor = ALL_CORES
    """Place of the tasks that are not timed"""
    files: ClassVar[StudyFiles] = FILES

    @property
    def turns(self) -> int:
        """Number of tasks to be reported."""
        return len(self.tasks) + len(self.timed)

    def record(self) -> dict[str, Any]:
        """Parts, arithmetics, and the objects named on the axes; failed tasks are added as they come."""
        return {
            "packages": {"gmpy2": package_version("gmpy2")},
            "full": self.full,
            "parts": {part: {} for part in self.parts},
            "scene": SCENE,
            "members": MEMBERS,
            "exact_digits": EXACT_DIGITS,
            "unit_roundoff": {name: a.unit_roundoff for name, a in ARITHMETICS.items()},
            "long_doubles": long_doubles(),
            "objects": list(OBJECTS),
            "failed": [],
        }

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Run everything and write the tables; an interrupted run leaves the rows so far."""
        assert isinstance(self.executor, KeptAnswers)
        failed = store.record["failed"]
        rows: dict[str, dict[int, Rows]] = {}
        try:
            for tasks, place in ((self.tasks, self.executor), (self.timed, self.executor.one_by_one())):
                for k, found in run_cases(enumerate(cases_of(tasks)), place):
                    table, title = tasks[k].table, tasks[k].title
                    if isinstance(found, str):
                        failed.append({"table": table, "task": title, "reason": found})
                        reporter.step(table, f"{title}: {found}", str(Outcome.FAILED))
                    else:
                        rows.setdefault(table, {})[k] = found
                        store.write(table, in_order(rows[table]))
                        reporter.step(table, title, str(Outcome.PASS))
        finally:
            write_laws(store, rows)
        return StudyEnd(tuple(f"{f['table']}: {f['task']}: {f['reason']}" for f in failed))


def roundoff_study(
    parts: tuple[str, ...] = PARTS, sizes: tuple[float, ...] = (), *, full: bool = False, executor: Executor = ALL_CORES
) -> RoundoffStudy:
    """Round-off study; `parts`, `sizes` and `full` are those of :func:`barchain.studies.roundoff.plan.tasks_of`.

    Raises
    ------
    ClusterError
        For a Dask cluster that can't be used.
    ValueError
        For a size at which no evaluation is judged.
    """
    tasks = tasks_of(parts, sizes, full=full)
    executor.check()
    return RoundoffStudy(tasks, timed_tasks(parts, full=full), full, tuple(parts), executor)


def cases_of(tasks: tuple[RoundoffTask, ...]) -> Iterator[Case[Rows | str]]:
    """Cases of tasks; those of one family of scenes share its high-precision solution."""
    solutions = {t.solution: Shared(solution_case(t.solution)) for t in tasks if t.solution is not None}
    for task in tasks:
        yield task_case(task, None if task.solution is None else solutions[task.solution])


def solution_case(family: ScaledScene) -> Case[HighPrecisionSolution | str]:
    """High-precision solution of a family of scenes, or why there is none."""
    call = Call(solution_bytes, (family,), SOLUTION_LIMIT_S)
    (found,) = yield [Task(call, checked(lambda content: solution_from(family, content)), FIRST)]
    solution: HighPrecisionSolution | str = found
    return solution


def task_case(task: RoundoffTask, solution: Shared | None) -> Case[Rows | str]:
    """Rows of a task, or why there are none; one that hangs is ended, and costs its own rows."""
    given = task.arguments
    if solution is not None:
        (known,) = yield [solution]
        if isinstance(known, str):
            return f"no high-precision solution: {known}"
        given = (known, *given)
    (found,) = yield [Task(Call(task_bytes, (task.function, given), TASK_LIMIT_S), checked(rows_from), LATER)]
    rows: Rows | str = found
    return rows


def checked(read: Callable[[bytes], Any]) -> Callable[[Answer], Any]:
    """Reading of an answer, which gives the reason as text where there is none, or a damaged one."""

    def result(answer: Answer) -> Any:
        try:
            return read(answer.needed())
        except (CallFailedError, MessageError, KeyError) as error:
            return str(error)

    return result


def task_bytes(function: Callable[..., Rows], arguments: tuple[Any, ...]) -> bytes:
    """Message with a task's rows; the function is called here."""
    return message_bytes({"rows": function(*arguments)}, {})


def rows_from(content: bytes) -> Rows:
    """Rows of a message.

    Raises
    ------
    MessageError
        If they are no rows of text and numbers.
    """
    rows = read_message(content)[0].get("rows")
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise MessageError("its answer holds no rows")
    for row in rows:
        wrong = next((name for name, value in row.items() if not isinstance(value, PLAIN)), None)
        if wrong is not None:
            raise MessageError(f"{plain_text(wrong)} is a {type(row[wrong]).__name__}, expected text or a number")
    return rows


def in_order(rows: dict[int, Rows]) -> Rows:
    """Rows of tasks in the order of the tasks, whenever they came."""
    return [row for _, own in sorted(rows.items()) for row in own]


def write_laws(store: StudyStore, rows: dict[str, dict[int, Rows]]) -> None:
    """Write the tables that follow from others."""
    for name, (source, laws) in DERIVED.items():
        if source in rows:
            store.write(name, laws(store.frame(source, in_order(rows[source]))))
    if "trajectories" in rows:
        best = best_table(store.frame("trajectories", in_order(rows["trajectories"])))
        store.write("best", best)
        store.write("best_laws", best_laws(best))
