"""Calls in the process of the test, where engines, faults and the judge can be replaced."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from barchain.runs.call import Answer
from barchain.runs.cases import run_cases
from barchain.runs.pool import Session

if TYPE_CHECKING:
    from collections.abc import Hashable

    from barchain.runs.call import Call
    from barchain.runs.cases import Case


class HereSession(Session):
    """Session that answers a call as soon as it is submitted, without limits."""

    def start(self, key: Hashable, call: Call) -> None:
        """Answer a call."""
        self.done.put((key, Answer(call.function(*call.given))))

    def close(self) -> None:
        """Nothing is under way."""


@dataclass(frozen=True)
class ThisProcess:
    """Executor that makes calls in this process, one after the other."""

    def check(self) -> None:
        """Nothing to check."""

    def session(self) -> Session:
        """Context that makes calls."""
        return HereSession()


HERE: Any = ThisProcess()


def result_of(case: Case[Any], executor: Any = HERE) -> Any:
    """Result of one case."""
    ((_, found),) = run_cases([("case", case)], executor)
    return found
