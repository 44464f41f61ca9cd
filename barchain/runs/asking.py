"""Ask an engine of another package, and get an answer or one line on why there is none.

None of such an engine's code runs in the process that compares: import, declarations, `unsupported`,
`unsupported_motion`, `noise` and runs happen in a process of their own, which a worker forks, confines and ends
(:mod:`barchain.runs.worker`). The answer comes back as text and float64 arrays, which cannot run code, and is checked
anew. An installed plug-in still runs as the user who starts barchain: this guards a comparison against accidents, and
is no sandbox against malice.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from barchain.runs import examination, questions
from barchain.runs.call import Answer, Call, CallEnd, pickled
from barchain.runs.child import FORKS
from barchain.runs.environment import FOLDER, THREADS
from barchain.runs.limits import OutsideLimits
from barchain.runs.message import MessageError, message_bytes, need_finite, plain_text, read_message
from barchain.runs.phase import QUESTION
from barchain.runs.versions import need_same_version, version_of
from barchain.runs.workers import IdleSlots, module_paths

if TYPE_CHECKING:
    from adapters.trajectory import Array

IDLE = IdleSlots()
OWN_VARIABLES = {*THREADS, FOLDER, QUESTION}
"""Variables that the processes of a worker have from it"""


@dataclass(frozen=True)
class Reply:
    """Answer of an engine's process, or the reason why there is none."""

    header: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, Array] = field(default_factory=dict)
    problem: str = ""
    """Reason without an answer, in one line; empty with one"""
    kind: str = ""
    """``missing``, ``failed``, ``timed_out``; empty with an answer"""
    rejected: bool = False
    """Whether the engine rejected the scene before its first step"""


def ask(question: str, *given: Any, limits: OutsideLimits | None = None) -> Reply:
    """Ask an engine in a process of its own.

    Parameters
    ----------
    question : str
        Name of a function in :mod:`barchain.runs.questions` or :mod:`barchain.runs.examination`.
    *given : Any
        Its arguments.
    limits : OutsideLimits, optional

    Returns
    -------
    Reply
        Never raises for what the engine does.
    """
    if not FORKS:
        return Reply(problem="engines of other packages need a system that forks: Linux or macOS", kind="failed")
    limits = limits or OutsideLimits()
    here = module_paths(), {name: value for name, value in os.environ.items() if name not in OWN_VARIABLES}
    with IDLE.slot() as slot:
        call = Call(answered_here, (*here, question, given), limits.time_s, pool="", confined=limits)
        return reply_of(slot.run(pickled(call)))


def question_call(question: str, *given: Any, limits: OutsideLimits, version: str) -> Call:
    """Call that asks; `version` is what the engine's package must have where it is answered."""
    return Call(answered_there, (version, question, given), limits.time_s, pool="", confined=limits)


def answered_here(paths: list[str], variables: dict[str, str], question: str, given: tuple[Any, ...]) -> bytes:
    """Answer with the module paths and the environment that the asking process has now; its worker may be older."""
    sys.path[:] = paths
    os.environ.update(variables)
    return answered(question, given)


def answered_there(version: str, question: str, given: tuple[Any, ...]) -> bytes:
    """Answer, perhaps on another machine.

    Raises
    ------
    WrongWorkerError
        If the engine's package has another version here.
    """
    need_same_version(version_of(given[0]), version)
    return answered(question, given)


def answered(question: str, given: tuple[Any, ...]) -> bytes:
    """Answer to a question as a message, in the process of the engine."""
    module = questions if hasattr(questions, question) else examination
    try:
        header, arrays = getattr(module, question)(*given)
        need_finite(header)
        return message_bytes(header, arrays)
    except BaseException as error:  # also SystemExit, KeyboardInterrupt and GeneratorExit: all are the engine's
        return message_bytes(questions.failed(error), {})


def reply_of(answer: Answer) -> Reply:
    """Reply from the answer to a question."""
    if answer.end is not CallEnd.ANSWERED:
        return Reply(problem=answer.reason, kind="timed_out" if answer.end is CallEnd.TIMED_OUT else "failed")
    try:
        header, arrays = read_message(answer.content)
    except MessageError as error:
        return Reply(problem=str(error), kind="failed")
    return failed_reply(header) if "failed" in header else Reply(header, arrays)


def failed_reply(header: dict[str, Any]) -> Reply:
    """Reply of an engine whose code raised an exception."""
    kind = "missing" if header["failed"] == "missing" else "failed"
    rejected = bool(header.get("rejected")) and header.get("phase") == "build"
    return Reply(problem=plain_text(header.get("words", "")), kind=kind, rejected=rejected)
