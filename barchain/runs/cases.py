"""Cases: generators that ask for work of other processes and receive its results, many side by side.

A case yields a list of what it needs next (:class:`Task`, :class:`Known`, :class:`Shared`), and receives the list of
their results. What it returns is its own result::

    def pair(scene, engine):
        main, finer = yield [run_task(main_job), run_task(finer_job)]
        (verdict,) = yield [call_task(judge, main, finer)]
        return verdict
"""

from __future__ import annotations

import heapq
import itertools
from collections import deque
from collections.abc import Generator
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence

    from barchain.runs.call import Answer, Call
    from barchain.runs.executors import Executor
    from barchain.runs.pool import Session

T = TypeVar("T")
Case = Generator[list["Task | Known | Shared"], list[Any], T]
AHEAD = 2  # calls that a place has for each process: the next one is there when one ends


@dataclass(frozen=True)
class Task:
    """Work of another process."""

    call: Call
    result: Callable[[Answer], Any]
    """Makes the result of the answer; called once, as soon as the answer is there"""
    priority: tuple[float, ...] = ()
    """Tasks with smaller ones begin first; those of equal ones in the order in which they were asked for"""
    instead: Callable[[], Any] = lambda: None
    """Result that makes the call needless, asked for at its turn; None: there is none"""


@dataclass(frozen=True)
class Known:
    """A result that is there already."""

    value: Any


class Shared:
    """A case whose result several others need; it starts when it is asked for first."""

    def __init__(self, case: Case[Any]) -> None:
        self.case = case
        self.running: Running | None = None


@dataclass
class Running:
    """A case that has started."""

    case: Case[Any]
    key: Hashable = None
    """None for a shared case"""
    results: list[Any] = field(default_factory=list)
    missing: int = 0
    """Results that are still to come"""
    waiting: list[tuple[Running, int]] = field(default_factory=list)
    """Cases that need the result, and its place among what they asked for"""
    ended: bool = False
    value: Any = None


def run_cases(cases: Iterable[tuple[Any, Case[T]]], executor: Executor) -> Iterator[tuple[Any, T]]:
    """Run cases, and yield the key and the result of each as it ends.

    Parameters
    ----------
    cases : iterable of (key, generator)
    executor : Executor
        Place of the work.

    Raises
    ------
    ClusterLostError
        If the executor is a cluster, and fails; results so far have been yielded.
    """
    with ExitStack() as context:
        runner = Runner(lambda: context.enter_context(executor.session()))
        for key, case in cases:
            runner.resume(Running(case, key), None)
        yield from runner.results()


def run_tasks(tasks: Sequence[Task], executor: Executor) -> list[Any]:
    """Results of tasks, in their order."""
    found = dict(run_cases(((number, alone(task)) for number, task in enumerate(tasks)), executor))
    return [found[number] for number in range(len(tasks))]


def alone(task: Task) -> Case[Any]:
    """Case of one task, whose result is its own."""
    (found,) = yield [task]
    return found


class Runner:
    """Cases that have started, and the work that they ask for."""

    def __init__(self, opened: Callable[[], Session]) -> None:
        """Prepare; `opened` opens the place of the work when there is any."""
        self.opened = opened
        self.queue: list[tuple[tuple[float, ...], int, Task, Running, int]] = []
        self.numbers = itertools.count()
        self.tasks: dict[int, tuple[Task, Running, int]] = {}
        """Tasks at work"""
        self.ended: deque[tuple[Hashable, Any]] = deque()

    def resume(self, running: Running, value: list[Any] | None) -> None:
        """Let a case go on with the results that it asked for, until it needs others or ends."""
        while True:
            try:
                asked = running.case.send(value)  # type: ignore[arg-type]  # None starts it
            except StopIteration as end:
                self.end(running, end.value)
                return
            running.results, running.missing = [None] * len(asked), len(asked)
            for place, one in enumerate(asked):
                self.ask(running, place, one)
            if running.missing:
                return
            value = running.results

    def ask(self, running: Running, place: int, one: Task | Known | Shared) -> None:
        """Take a result that is there, or see to it that it comes."""
        if isinstance(one, Known):
            self.take(running, place, one.value)
        elif isinstance(one, Task):
            heapq.heappush(self.queue, (one.priority, next(self.numbers), one, running, place))
        else:
            if one.running is None:
                one.running = Running(one.case)
                self.resume(one.running, None)
            if one.running.ended:
                self.take(running, place, one.running.value)
            else:
                one.running.waiting.append((running, place))

    def take(self, running: Running, place: int, value: Any) -> None:
        """Note a result."""
        running.results[place] = value
        running.missing -= 1

    def deliver(self, running: Running, place: int, value: Any) -> None:
        """Note a result, and let the case go on if it was the last."""
        self.take(running, place, value)
        if not running.missing:
            self.resume(running, running.results)

    def end(self, running: Running, value: Any) -> None:
        """Note the result of a case, and hand it to those that need it."""
        running.ended, running.value = True, value
        if running.key is not None:
            self.ended.append((running.key, value))
        for other, place in running.waiting:
            self.deliver(other, place, value)

    def results(self) -> Iterator[tuple[Any, Any]]:
        """Keys and results of cases as they end, until all have."""
        yield from self.taken()
        if not self.queue:
            return
        session = self.opened()
        self.submit(session)
        for number, answer in session.answers():
            task, running, place = self.tasks.pop(number)
            self.deliver(running, place, task.result(answer))
            yield from self.taken()
            self.submit(session)
        yield from self.taken()

    def submit(self, session: Session) -> None:
        """Hand over as many tasks as the place can take; later ones may be more urgent."""
        while self.queue and session.left < AHEAD * session.side_by_side():
            _, number, task, running, place = heapq.heappop(self.queue)
            if (found := task.instead()) is not None:
                self.deliver(running, place, found)
                continue
            self.tasks[number] = task, running, place
            session.submit(number, task.call)

    def taken(self) -> Iterator[tuple[Any, Any]]:
        """Results that have not been yielded."""
        while self.ended:
            yield self.ended.popleft()
