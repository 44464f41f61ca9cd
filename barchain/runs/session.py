"""Calls that are under way in one place, and their answers as they come."""

from __future__ import annotations

import queue
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from collections.abc import Hashable, Iterator
    from types import TracebackType

    from barchain.runs.call import Answer, Call


class Session(ABC):
    """A place while it runs calls; a context, at whose end calls at work are ended."""

    def __init__(self) -> None:
        self.done: queue.SimpleQueue[tuple[Hashable, Answer] | Exception] = queue.SimpleQueue()
        self.left: int = 0
        """Calls whose answer has not been taken"""

    @abstractmethod
    def start(self, key: Hashable, call: Call) -> None:
        """Begin a call, or queue it; its answer goes to `done`."""

    @abstractmethod
    def close(self) -> None:
        """End everything."""

    def side_by_side(self) -> int:
        """Calls that run at the same time, as far as is known."""
        return 1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def submit(self, key: Hashable, call: Call) -> None:
        """Take a call; calls begin in the order in which they are submitted."""
        self.left += 1
        self.start(key, call)

    def answers(self, *, wait: bool = True) -> Iterator[tuple[Any, Answer]]:
        """Answers with the keys of their calls: those that are there, or with `wait` all.

        Raises
        ------
        ClusterLostError
            If the place fails; answers so far have been given.
        """
        while self.left and (wait or not self.done.empty()):
            found = self.done.get()
            if isinstance(found, Exception):
                raise found
            self.left -= 1
            yield found
