"""Verdicts in other processes, as tasks of a case.

Beyond the predictability limit a verdict takes as long as the engine's own runs: the reference is restarted from the
engine's states again and again (`barchain.judge.checks.restart`). A verdict whose process dies costs its own row, like
a run. One that takes too long is no verdict, and no failure of the engine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from barchain.runs.call import Call, CallFailedError
from barchain.runs.cases import Task
from barchain.runs.message import MessageError, plain_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.runs.call import Answer

JUDGING_S = 300.0  # of processor time; a verdict on the longest shipped scene takes some twenty seconds in NumPy
FIRST = (-1.0,)
"""Priority before all runs: what is judged is reported, and its trajectories are forgotten"""
VerdictT = TypeVar("VerdictT")


@dataclass(frozen=True)
class VerdictCodec(Generic[VerdictT]):
    """Form of a verdict from another process: bytes that are read without running code."""

    encode: Callable[[VerdictT], bytes]
    """A function of a module"""
    decode: Callable[[bytes], VerdictT]
    """Raises MessageError, ValueError, TypeError or KeyError for other bytes"""

    def task(self, function: Callable[..., VerdictT], *given: Any) -> Task:
        """Task whose result is that of a function of a module, or the :class:`CallFailedError` that tells why not."""
        call = Call(encoded, (self.encode, function, given), JUDGING_S, "verdicts", own_work=True)
        return Task(call, self.decoded, FIRST)

    def decoded(self, answer: Answer) -> VerdictT | CallFailedError:
        """Verdict of an answer, or the reason why there is none."""
        try:
            return self.decode(answer.needed())
        except CallFailedError as error:
            return error
        except (MessageError, ValueError, TypeError, KeyError) as error:
            return CallFailedError(f"its verdict is damaged: {plain_text(error)}")


def encoded(encode: Callable[[Any], bytes], function: Callable[..., Any], given: tuple[Any, ...]) -> bytes:
    """Result of a function as bytes, in the process that calls it."""
    return encode(function(*given))
