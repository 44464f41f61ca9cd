"""Verdicts in worker processes.

Beyond the predictability limit a verdict takes as long as the engine's own runs: the reference is restarted from the
engine's states again and again (`barchain.judge.checks.restart`). A verdict whose process dies costs its own row, like
a run. One that takes too long is no verdict, and no failure of the engine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from barchain.boundary.message import MessageError, plain_text
from barchain.execution.call import Call, CallFailedError
from barchain.execution.executors import ALL_CORES

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator

    from barchain.execution.call import Answer
    from barchain.execution.executors import Executor
    from barchain.execution.session import Session

JUDGING_S = 300.0  # of processor time; a verdict on the longest shipped scene takes some twenty seconds in NumPy
Key = TypeVar("Key", bound="Hashable")
VerdictT = TypeVar("VerdictT")


@dataclass(frozen=True)
class VerdictCodec(Generic[VerdictT]):
    """Form of a verdict from another process: bytes that are read without running code."""

    encode: Callable[[VerdictT], bytes]
    """A function of a module"""
    decode: Callable[[bytes], VerdictT]
    """Raises MessageError, ValueError, TypeError or KeyError for other bytes"""


class Judges(Generic[Key, VerdictT]):
    """Worker processes for verdicts; the first submitted verdict starts them."""

    def __init__(
        self, codec: VerdictCodec[VerdictT], executor: Executor = ALL_CORES, time_limit_s: float = JUDGING_S
    ) -> None:
        """Prepare.

        Parameters
        ----------
        codec : VerdictCodec
        executor : Executor
            Place of the processes; all cores of this machine by default.
        time_limit_s : float
            Processor time after which a verdict's process is ended, s.
        """
        self.codec, self.executor, self.time_limit_s = codec, executor, time_limit_s
        self.session: Session | None = None
        self.waiting: set[Key] = set()
        """Keys of verdicts that are still to come"""

    def submit(self, key: Key, function: Callable[..., VerdictT], *given: Any) -> None:
        """Call `function` with the given arguments in a worker; :meth:`collected` yields its result with `key`."""
        if self.session is None:
            self.session = self.executor.session()
        self.waiting.add(key)
        given = (self.codec.encode, function, given)
        self.session.submit(key, Call(encoded, given, self.time_limit_s, "verdicts", own_work=True))

    def collected(self, *, wait: bool) -> Iterator[tuple[Key, VerdictT | CallFailedError]]:
        """Results by their keys, an exception for a failure: the finished results, or with `wait` all."""
        if self.session is None:
            return
        for key, answer in self.session.answers(wait=wait):
            own = cast("Key", key)
            self.waiting.discard(own)
            yield own, self.decoded(answer)

    def decoded(self, answer: Answer) -> VerdictT | CallFailedError:
        """Verdict of an answer, or the reason why there is none."""
        try:
            return self.codec.decode(answer.needed())
        except CallFailedError as error:
            return error
        except (MessageError, ValueError, TypeError, KeyError) as error:
            return CallFailedError(f"its verdict is damaged: {plain_text(error)}")

    def close(self) -> None:
        """End the processes."""
        if self.session is not None:
            self.session.close()
            self.session = None


def encoded(encode: Callable[[Any], bytes], function: Callable[..., Any], given: tuple[Any, ...]) -> bytes:
    """Result of a function as bytes, in the process that calls it."""
    return encode(function(*given))
