"""Engines of other packages: questions to them, with an answer or one line on why there is none, and their classes.

None of such an engine's code runs in the process that compares: import, declarations, `unsupported`,
`unsupported_motion`, `noise` and runs happen in a process of their own, which a worker forks, confines and ends
(:mod:`barchain.runs.worker`). The answer comes back as text and float64 arrays, which cannot run code, and is checked
anew. An installed plug-in still runs as the user who starts barchain: this guards a comparison against accidents, and
is no sandbox against malice.
"""

from __future__ import annotations

import copyreg
import hashlib
import os
import sys
from abc import ABCMeta
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

from adapters.engine import Engine, EngineError
from adapters.registry import ENGINES, Registration
from barchain.runs import questions
from barchain.runs.call import QUESTION_S, Answer, Call, CallEnd, pickled
from barchain.runs.child import FORKS
from barchain.runs.environment import FOLDER, THREADS
from barchain.runs.message import (
    TEXT_LENGTH,
    DeclarationError,
    MessageError,
    message_bytes,
    need_finite,
    plain_text,
    read_message,
)
from barchain.runs.phases import QUESTION, failed
from barchain.runs.pool import SLOTS, module_paths
from barchain.runs.questions import DECLARED
from barchain.runs.versions import need_same_version, version_of
from scenarios import nearest
from scenarios.channels import NOISE

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.engine import Setting
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

Question = Callable[..., tuple[dict[str, Any], Mapping[str, "Array"]]]
"""Function that answers in the process of an engine, by a header and arrays"""
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
    """``missing``, ``unsupported``, ``failed``, ``timed_out``; empty with an answer"""
    rejected: bool = False
    """Whether the engine rejected the scene before its first step"""


def ask(question: Question, *given: Any, limit_s: float = QUESTION_S) -> Reply:
    """Ask an engine in a process of its own.

    Parameters
    ----------
    question : callable
        Function of a module, e.g. of :mod:`barchain.runs.questions`.
    *given : Any
        Its arguments.
    limit_s : float
        Wall time of the process, s.

    Returns
    -------
    Reply
        Never raises for what the engine does.
    """
    if not FORKS:
        return Reply(problem="engines of other packages need a system that forks: Linux or macOS", kind="failed")
    here = module_paths(), {name: value for name, value in os.environ.items() if name not in OWN_VARIABLES}
    call = Call(answered_here, (*here, question, given), limit_s, pool="", confined=True)
    with SLOTS.slot() as slot:
        return reply_of(slot.run(pickled(call)))


def question_call(question: Question, *given: Any, limit_s: float, version: str) -> Call:
    """Call that asks; `version` is what the engine's package must have where it is answered."""
    return Call(answered_there, (version, question, given), limit_s, pool="", confined=True)


def answered_here(paths: list[str], variables: dict[str, str], question: Question, given: tuple[Any, ...]) -> bytes:
    """Answer with the module paths and the environment that the asking process has now; its worker may be older."""
    sys.path[:] = paths
    os.environ.update(variables)
    return answered(question, given)


def answered_there(version: str, question: Question, given: tuple[Any, ...]) -> bytes:
    """Answer, perhaps on another machine.

    Raises
    ------
    WrongWorkerError
        If the engine's package has another version here.
    """
    need_same_version(version_of(given[0]), version)
    return answered(question, given)


def answered(question: Question, given: tuple[Any, ...]) -> bytes:
    """Answer to a question as a message, in the process of the engine."""
    try:
        header, arrays = question(*given)
        need_finite(header)
        return message_bytes(header, arrays)
    except BaseException as error:  # also SystemExit, KeyboardInterrupt and GeneratorExit: all are the engine's
        return message_bytes(failed(error), {})


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
    kind = header["failed"] if header["failed"] in ("missing", "unsupported", "timed_out") else "failed"
    rejected = bool(header.get("rejected")) and header.get("phase") == "build"
    return Reply(problem=plain_text(header.get("words", "")), kind=kind, rejected=rejected)


class AdapterLoadError(EngineError):
    """Raised for an engine whose class can't be had; the message is one line."""

    def __init__(self, registration: Registration, reason: str) -> None:
        """Name the adapter."""
        self.reason = " ".join(reason.split())
        super().__init__(f"the adapter {registration.target} does not load: {self.reason}")


class OutsideEngineClass(ABCMeta):
    """Type of such classes; pickled by content, as each is made while barchain runs."""


class OutsideEngine(Engine, metaclass=OutsideEngineClass):
    """Engine of another package. Its class can be asked here; its runs are made elsewhere."""

    registration: ClassVar[Registration]
    asks: ClassVar[frozenset[str]]
    """Methods that the engine replaces, and which are therefore asked"""
    said: ClassVar[dict[str, Any]]
    """Declarations as they came"""
    answers: ClassVar[dict[str, str | None]]
    """Reasons against scenes by their digests"""
    noises: ClassVar[dict[str, dict[str, Array]]]
    """Declared noise by scene, setting and instants; another process takes it along, and asks nobody"""

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why this engine does not support `scene`, by its own answer."""
        if "unsupported" not in cls.asks:
            return super().unsupported(scene)
        if scene.digest not in cls.answers:
            cls.prepare([scene])
        return cls.answers[scene.digest]

    @classmethod
    def prepare(cls, scenes: Iterable[Scene]) -> None:
        """Ask about several scenes at once; a process a question would take seconds for a suite."""
        left = [s for s in scenes if s.digest not in cls.answers]
        if "unsupported" in cls.asks and left:
            header = cls.answer(questions.unsupported, left).header
            for scene, reason in zip(left, header["reasons"], strict=True):
                cls.answers[scene.digest] = None if reason is None else str(reason)[:TEXT_LENGTH]

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """Reason why this engine does not support a motion, by its own answer."""
        if "unsupported_motion" not in cls.asks:
            return None
        reason = cls.answer(questions.unsupported_motion, scene, motion).header["reasons"][0]
        return None if reason is None else str(reason)[:TEXT_LENGTH]

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Errors that the engine declares, by its own answer; names and values are checked."""
        if "noise" not in cls.asks:
            return {}
        key = noise_key(scene, setting, t_s)
        if key not in cls.noises:
            cls.remember_noise(scene, setting, t_s, cls.answer(questions.noise, scene, setting, t_s).arrays)
        return dict(cls.noises[key])

    @classmethod
    def remember_noise(cls, scene: Scene, setting: Setting, t_s: Array, found: dict[str, Array]) -> None:
        """Check and keep an answer; it may have come with a run.

        Raises
        ------
        DeclarationError
            If a name or a value is wrong.
        """
        for name, values in found.items():
            check_noise(name, values, t_s)
        cls.noises[noise_key(scene, setting, t_s)] = found

    @classmethod
    def answer(cls, question: Question, *given: Any) -> Reply:
        """Answer to a question; an error with the reason if there is none."""
        reply = ask(question, cls.registration, *given, limit_s=QUESTION_S)
        if reply.problem:
            raise EngineError(f"{question.__name__}: {reply.problem}")
        return reply

    def refuse(self, *_: object, **__: object) -> NoReturn:
        """Raise: code of another package is not run in this process."""
        raise RuntimeError(f"{self.registration.target} runs in a process of its own; use barchain.simulate")

    build = simulate = read = refuse


def noise_key(scene: Scene, setting: Setting, t_s: Array) -> str:
    """Key of an answer on noise."""
    return f"{scene.digest} {setting} {hashlib.sha256(t_s.tobytes()).hexdigest()}"


def check_noise(name: str, values: Array, t_s: Array) -> None:
    """Raise for noise of an unknown quantity, of a wrong shape, negative, or not finite."""
    if name not in NOISE:
        raise DeclarationError(
            f"declares noise of {name!r}: no quantity{nearest(name, NOISE)}; allowed: {', '.join(NOISE)}"
        )
    if values.shape != t_s.shape or not np.isfinite(values).all() or (values < 0.0).any():
        raise DeclarationError(f"declares noise of {name} that is negative or not finite")


def engine_class(registration: Registration) -> type[Engine]:
    """Class of an engine: barchain's own, or the declarations of one of another package.

    Raises
    ------
    AdapterLoadError
        If the adapter does not import, or an engine of another package does not declare what it must.
    """
    if registration not in ENGINES.values():
        return outside_class(registration)
    try:
        return registration.load()
    except Exception as error:  # a broken installation of the engine's library may raise anything
        raise AdapterLoadError(registration, f"{type(error).__name__}: {plain_text(error)}") from error


def outside_class(registration: Registration) -> type[OutsideEngine]:
    """Class with the declarations of an engine of another package."""
    found = asked_class(registration)
    if isinstance(found, str):
        raise AdapterLoadError(registration, found)
    return found


def engine_fault(error: Exception) -> str:
    """Reason, in one line, why an engine's class can't be loaded or asked."""
    said = str(error) if isinstance(error, EngineError) else f"its declarations raise {type(error).__name__}: {error}"
    return " ".join(said.split())


@cache
def asked_class(registration: Registration) -> type[OutsideEngine] | str:
    """Class of an engine, or why there is none; asked once, as an import that hangs costs its whole limit.

    What a program declares is the data of its entry: no code of it runs, and a process for each would take seconds.
    """
    if registration.entry:
        reply = Reply(*questions.declarations(registration))
    else:
        reply = ask(questions.declarations, registration, limit_s=QUESTION_S)
    if reply.problem:
        return reply.problem
    try:
        return made_class(registration, reply.header)
    except (KeyError, TypeError, ValueError) as error:
        return f"its declarations are damaged: {plain_text(error)}"


def made_class(
    registration: Registration, said: dict[str, Any], noises: dict[str, dict[str, Array]] | None = None
) -> type[OutsideEngine]:
    """Class from an engine's declarations; a wrong type raises, as the answer may come from a process gone astray."""
    own: dict[str, Any] = {name: form.meant(said[name]) for name, form in DECLARED.items()}
    own |= {"registration": registration, "said": said, "answers": {}, "noises": dict(noises or {})}
    own["asks"] = frozenset(map(str, said["asks"]))
    name = registration.target.partition(":")[2] or "Engine"
    return OutsideEngineClass(name, (OutsideEngine,), own)  # type: ignore[return-value]


def reduced(made: type[OutsideEngine]) -> Any:
    """Form of a pickled class: its name, or of an engine's class what it has declared."""
    return "OutsideEngine" if made is OutsideEngine else (made_class, (made.registration, made.said, made.noises))


copyreg.pickle(OutsideEngineClass, reduced)  # type: ignore[arg-type]
