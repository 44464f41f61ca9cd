"""A call for another process, and its answer: bytes, or the reason why there is none."""

from __future__ import annotations

import json
import pickle
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from adapters.engine import EngineError
from barchain.runs.frames import joined, parted
from barchain.runs.message import MessageError, plain_number, plain_text

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.runs.limits import OutsideLimits

BUSY = 20.0
"""Wall time of own work, relative to its limit, after which its process is ended in any case: it must stand still"""
TASKS_PER_PROCESS = 1000  # a leak of barchain's own code ends with its process


@dataclass(frozen=True)
class CallLimits:
    """What a worker must know of a call, to choose its process and to end it."""

    limit_s: float
    """Time that is allowed, s"""
    wall_s: float
    """Wall time after which the process is ended in any case, s"""
    pool: str
    """Calls of one pool share a process, one after the other; empty: a process of its own"""
    calls_per_process: int
    confined: OutsideLimits | None
    """Limits of memory and output, for an engine of another package"""


@dataclass(frozen=True)
class Call:
    """A function and its arguments, to be called in a process that this one does not share."""

    function: Callable[..., bytes]
    """Of a module, so that another process can import it"""
    given: tuple[Any, ...]
    limit_s: float
    """Time after which its process is ended, s: wall time, as an engine may sleep"""
    pool: str = "tasks"
    """Calls of one pool share processes, one after the other; empty: a process of its own"""
    calls_per_process: int = TASKS_PER_PROCESS
    own_work: bool = False
    """Whether the work is barchain's own: the limit is then processor time, which a busy machine does not use up"""
    confined: OutsideLimits | None = None
    """Limits of memory and output, for an engine of another package"""
    aside: tuple[Any, ...] = ()
    """Further arguments, after those given, that decide no answer: limits of time, the core that it runs on"""
    repetition: int = 0
    """Number of a measurement that is made several times: each has an answer of its own"""
    worth_keeping: Callable[[bytes], bool] = bool
    """Whether a command that goes on may take this answer; a failed run is tried again"""

    @property
    def limits(self) -> CallLimits:
        """What the worker must know."""
        wall_s = self.limit_s * (BUSY if self.own_work else 1.0)
        return CallLimits(self.limit_s, wall_s, self.pool, self.calls_per_process, self.confined)


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
    """Call for a worker, which trusts its sender: its limits, and what only the process that answers it unpacks."""
    work = call.function, (*call.given, *call.aside), call.limit_s if call.own_work else 0.0
    return joined([pickle.dumps(call.limits, protocol=5), pickle.dumps(work, protocol=5)])


def limits_of(call: bytes) -> CallLimits:
    """Limits of a pickled call."""
    found: CallLimits = pickle.loads(parted(call)[0])
    return found


def packed_answers(answers: Sequence[Answer]) -> bytes:
    """Answers as bytes."""
    heads = [[str(a.end), a.reason, a.seconds] for a in answers]
    return joined([json.dumps(heads).encode("ascii"), *(a.content for a in answers)])


def unpacked_answers(content: object, count: int) -> list[Answer]:
    """Answers to `count` calls, from a worker that is not trusted to send them well.

    Raises
    ------
    MessageError
        If they are no such answers.
    """
    if not isinstance(content, bytes):
        raise MessageError(f"its answer is a {type(content).__name__}, expected bytes")
    head, *contents = parted(content) or [b""]
    try:
        heads = json.loads(head.decode("ascii"))
        found = [Answer(c, CallEnd(end), plain_text(why), seconds_of(s)) for (end, why, s), c in zip(heads, contents)]  # noqa: B905
    except (ValueError, TypeError) as error:
        raise MessageError(f"its answer is damaged: {plain_text(error)}") from None
    if not len(found) == len(heads) == len(contents) == count:
        raise MessageError(f"its answer is to {len(contents)} calls, expected {count}")
    return found


def seconds_of(value: object) -> float:
    """Duration from an answer."""
    return float(plain_number(value) or 0.0)
