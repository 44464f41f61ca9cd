"""A call for another process, and its answer: bytes, or the reason why there is none."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from adapters.engine import EngineError

if TYPE_CHECKING:
    from collections.abc import Callable

BUSY = 20.0
"""Wall time of own work, relative to its limit, after which its process is ended in any case: it must stand still"""
TASKS_PER_PROCESS = 1000  # a leak of barchain's own code ends with its process


@dataclass(frozen=True)
class Call:
    """A function and its arguments, to be called in a process that this one does not share."""

    function: Callable[..., bytes]
    """Of a module, so that another process can import it"""
    given: tuple[Any, ...]
    limit_s: float
    """Time after which its process is ended, s: wall time, as an engine may sleep"""
    pool: str = "tasks"
    """Calls of one pool share processes, one after the other; empty: the function starts a process of its own"""
    calls_per_process: int = TASKS_PER_PROCESS
    own_work: bool = False
    """Whether the work is barchain's own: the limit is then processor time, which a busy machine does not use up"""

    @property
    def wall_s(self) -> float:
        """Wall time after which the process is ended in any case, s."""
        return self.limit_s * (BUSY if self.own_work else 1.0)


class CallEnd(StrEnum):
    """End of a call."""

    ANSWERED = "answered"
    RAISED = "raised"
    TIMED_OUT = "timed_out"
    OWN_TIMER = "own_timer"
    """The function's own timer, SIGALRM, ended its process"""
    DIED = "died"
    LOST = "lost"
    """The answer could not be brought back"""
    OTHER_CODE = "other_code"
    """The process has other versions than the sender"""


@dataclass(frozen=True)
class Answer:
    """Answer to a call."""

    content: bytes = b""
    end: CallEnd = CallEnd.ANSWERED
    reason: str = ""
    """One line; empty with an answer"""
    seconds: float = 0.0
    """Wall time of the call, the start of its process included"""

    def needed(self) -> bytes:
        """Content.

        Raises
        ------
        CallFailedError
            If there is none, with the reason.
        """
        if self.end is CallEnd.TIMED_OUT:
            raise CallLateError(self.reason)
        if self.end is not CallEnd.ANSWERED:
            raise CallFailedError(self.reason)
        return self.content


class WrongWorkerError(RuntimeError):
    """Raised on a worker that has other code than the sender of a call."""


class CallFailedError(EngineError):
    """Raised for a call that gave no answer, or a damaged one; the message is the reason."""


class CallLateError(CallFailedError):
    """Raised for a call that was ended at its limit of time."""


def pickled(call: Call) -> bytes:
    """Call for a process that trusts its sender."""
    return pickle.dumps(call, protocol=5)


def unpickled(content: bytes) -> Call:
    """Call from its sender, the process that runs the command: never from a worker."""
    found: Call = pickle.loads(content)
    return found
