"""A call for another process, and its answer: bytes, or the reason why there is none."""

from __future__ import annotations

import json
import pickle
import struct
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import IO, TYPE_CHECKING, Any

from adapters.engine import EngineError
from barchain.runs.message import MessageError, plain_number, plain_text

if TYPE_CHECKING:
    from collections.abc import Callable

BUSY = 20.0
"""Wall time of own work, relative to its limit, after which its process is ended in any case: it must stand still"""
WAITED = 3.0
"""The same of an engine's call: what waits longer for a processor takes the time of the other engines"""
CALLS_PER_PROCESS = 1000  # a leak of barchain's own code ends with its process
QUESTION_S = 30.0  # for an import, a declaration or a claim: the slowest package known here imports in eight seconds
MEMORY_B = 4 * 2**30
"""Memory of an engine of another package and its children: a hundred times what the largest core scene needs"""
OUTPUT_B = 32 * 2**20
"""Text that an engine of another package may print in one run"""
FILE_B = 2 * 2**30
"""Largest file that an engine may write, its answer included"""
LENGTH = struct.Struct("<Q")


@dataclass(frozen=True)
class Call:
    """A function and its arguments, to be called in a process that this one does not share."""

    function: Callable[..., bytes]
    """Of a module, so that another process can import it"""
    given: tuple[Any, ...]
    limit_s: float
    """Time after which its process is ended, s: wall time, as an engine may sleep, without the wait for a processor"""
    pool: str = "calls"
    """Calls of one pool share processes, one after the other; empty: a process of its own"""
    calls_per_process: int = CALLS_PER_PROCESS
    own_work: bool = False
    """Whether the work is barchain's own: the limit is then processor time, which a busy machine does not use up"""
    confined: bool = False
    """Whether memory and output are limited too, for an engine of another package"""
    python: str = ""
    """Python whose worker answers; empty: the one that asks"""
    aside: tuple[Any, ...] = ()
    """Further arguments, after those given, that decide no answer: limits of time, the core that it runs on"""
    repetition: int = 0
    """Number of a measurement that is made several times: each has an answer of its own"""
    worth_keeping: Callable[[bytes], bool] = bool
    """Whether a command that goes on may take this answer; a failed run is tried again"""

    @property
    def wall_s(self) -> float:
        """Wall time after which the process is ended if it did not wait for a processor, s."""
        return self.limit_s * (BUSY if self.own_work else 1.0)

    @property
    def most_s(self) -> float:
        """Wall time after which the process is ended in any case, s."""
        return self.limit_s * (BUSY if self.own_work else WAITED)


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
    phase: str = ""
    """Phase of the run in which its process was ended at its limit, if it is known"""

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


def pickled(call: Call, versions: dict[str, str] | None = None) -> bytes:
    """Call for a worker, which trusts its sender: what it must know, and what only the answering process unpacks.

    The answering process must have the `versions` of the sender's code, if they are given.
    """
    known = replace(call, function=bytes, given=(), aside=(), worth_keeping=bool)
    work = versions, call.function, (*call.given, *call.aside), call.limit_s if call.own_work else None
    return pickle.dumps((known, pickle.dumps(work, protocol=5)), protocol=5)


def known_of(call: bytes) -> tuple[Call, bytes]:
    """What a worker knows of a pickled call, its limits and its pool; and the work, for the answering process."""
    known, work = pickle.loads(call)
    return known, work


def packed(answer: Answer) -> bytes:
    """Answer as bytes: a line of JSON, and the content."""
    head = [str(answer.end), answer.reason, answer.seconds, len(answer.content), answer.phase]
    return json.dumps(head).encode("ascii") + b"\n" + answer.content


def unpacked(content: object) -> Answer:
    """Answer from a process that is not trusted to send it well.

    Raises
    ------
    MessageError
        If it is none.
    """
    if not isinstance(content, bytes):
        raise MessageError(f"its answer is a {type(content).__name__}, expected bytes")
    head, _, found = content.partition(b"\n")
    try:
        end, why, seconds, length, phase = json.loads(head.decode("ascii"))
        answer = Answer(found, CallEnd(end), plain_text(why), float(plain_number(seconds) or 0.0), plain_text(phase))
    except (ValueError, TypeError) as error:
        raise MessageError(f"its answer is damaged: {plain_text(error)}") from None
    if length != len(found):
        raise MessageError(f"its answer is damaged: {len(found)} of {plain_text(length, 20)} bytes")
    return answer


def write_frame(file: IO[bytes], content: bytes) -> None:
    """Write bytes after their length."""
    file.write(LENGTH.pack(len(content)))
    file.write(content)
    file.flush()


def read_frame(file: IO[bytes]) -> bytes | None:
    """Bytes that :func:`write_frame` wrote; None at the end of the file."""
    head = file.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    (length,) = LENGTH.unpack(head)
    content = file.read(length)
    return content if len(content) == length else None
