"""Engines of other packages: questions to them, with an answer or one line on why there is none, and what they declare.

None of such an engine's code runs in the process that compares: import, declarations, `unsupported`,
`unsupported_motion`, `noise` and runs happen in a process of their own, which a worker forks, confines and ends
(:mod:`barchain.runs.worker`). The answer comes back as text and float64 arrays, which cannot run code, and is checked
anew. An installed plug-in still runs as the user who starts barchain: this guards a comparison against accidents, and
is no sandbox against malice.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.engine import Answers, Declarations, EngineError
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
from barchain.runs.phases import BUILD, QUESTION, failed
from barchain.runs.pool import SLOTS, module_paths
from barchain.runs.questions import DECLARED
from barchain.runs.same_code import need_same_version, version_of
from scenarios import nearest
from scenarios.channels import NOISE

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

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
    phase: str = ""
    """Phase of a run without a result, if it is known"""


def ask(question: Question, *given: Any, limit_s: float = QUESTION_S) -> Reply:
    """Ask an engine in a process of its own.

    Parameters
    ----------
    question : callable
        Function of a module, e.g. of :mod:`barchain.runs.questions`.
    *given : Any
        Its arguments, the engine's registration first.
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
    call = Call(answered_here, (*here, question, given), limit_s, pool="", confined=True, python=given[0].python)
    with SLOTS.slot() as slot:
        return reply_of(slot.run(pickled(call)))


def question_call(question: Question, *given: Any, limit_s: float, version: str) -> Call:
    """Call that asks; `version` is what the engine's package must have where it is answered."""
    work = version, question, given
    return Call(answered_there, work, limit_s, pool="", confined=True, python=given[0].python)


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
        kind = "timed_out" if answer.end is CallEnd.TIMED_OUT else "failed"
        return Reply(problem=answer.reason, kind=kind, phase=answer.phase)
    try:
        header, arrays = read_message(answer.content)
    except MessageError as error:
        return Reply(problem=str(error), kind="failed")
    return failed_reply(header) if "failed" in header else Reply(header, arrays)


def failed_reply(header: dict[str, Any]) -> Reply:
    """Reply of an engine whose code raised an exception."""
    kind = header["failed"] if header["failed"] in ("missing", "unsupported", "timed_out") else "failed"
    phase = plain_text(header.get("phase", ""))
    rejected = bool(header.get("rejected")) and phase == BUILD
    return Reply(problem=plain_text(header.get("words", "")), kind=kind, rejected=rejected, phase=phase)


class AdapterLoadError(EngineError):
    """Raised for an engine whose declarations can't be had; the message is one line."""

    def __init__(self, registration: Registration, reason: str) -> None:
        """Name the adapter."""
        self.reason = " ".join(reason.split())
        super().__init__(f"the adapter {registration.target} does not load: {self.reason}")


@dataclass(frozen=True)
class AskedAnswers(Answers):
    """Answers of an engine of another package, each asked for once."""

    registration: Registration
    known: dict[str, Any] = field(default_factory=dict, compare=False)
    """Reasons against scenes by their digests, and noise by scene, setting and instants, or why it can't be had"""

    def unsupported(self, scene: Scene, /) -> str | None:
        """Reason against a scene."""
        if scene.digest not in self.known:
            self.describe("unsupported", [scene])
        reason: str | None = self.known[scene.digest]
        return reason

    def unsupported_motion(self, scene: Scene, motion: Trajectory, /) -> str | None:
        """Reason against a motion."""
        reason = self.reply("unsupported_motion", questions.unsupported_motion, scene, motion).header["reason"]
        return None if reason is None else str(reason)[:TEXT_LENGTH]

    def noise(self, scene: Scene, setting: Setting, t_s: Array, /) -> dict[str, float | Array]:
        """Errors that the engine declares."""
        key = noise_key(scene, setting, t_s)
        if key not in self.known:
            try:
                self.describe("noise", [scene], [setting], t_s)
            except EngineError as error:  # one that hangs costs its limit once
                self.known[key] = error
        if isinstance(self.known[key], EngineError):
            raise self.known[key]
        return dict(self.known[key])

    def describe(
        self, wanted: str, scenes: Sequence[Scene], settings: Sequence[Setting] = (), t_s: Array | None = None
    ) -> None:
        """Ask about scenes, and with settings for the noise in each of them at instants of shape (n,).

        Raises
        ------
        EngineError
            If there is no answer; `wanted` is the question that the message names.
        DeclarationError
            If a name or a value of the noise is wrong.
        """
        reply = self.reply(wanted, questions.describe, scenes, settings, t_s)
        for scene, reason in zip(scenes, reply.header["reasons"], strict=True):
            self.known[scene.digest] = None if reason is None else str(reason)[:TEXT_LENGTH]
        if t_s is not None:
            for (i, scene), (j, setting) in itertools.product(enumerate(scenes), enumerate(settings)):
                self.remember_noise(scene, setting, t_s, with_prefix(reply.arrays, f"{i}.{j}."))

    def remember_noise(self, scene: Scene, setting: Setting, t_s: Array, found: dict[str, Array]) -> None:
        """Check and keep an answer; it may have come with a run. Raises DeclarationError as :meth:`describe`."""
        for name, values in found.items():
            check_noise(name, values, t_s)
        self.known[noise_key(scene, setting, t_s)] = found

    def reply(self, wanted: str, question: Question, *given: Any) -> Reply:
        """Answer to a question; an error with the reason if there is none."""
        reply = ask(question, self.registration, *given, limit_s=QUESTION_S)
        if reply.problem:
            raise EngineError(f"{wanted}: {reply.problem}")
        return reply


def with_prefix(arrays: Mapping[str, Array], prefix: str) -> dict[str, Array]:
    """Arrays whose names have a prefix, by the rest of the names."""
    return {name.removeprefix(prefix): values for name, values in arrays.items() if name.startswith(prefix)}


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


def ask_about(engine: Declarations, scenes: Iterable[Scene]) -> None:
    """Ask an engine of another package about several scenes at once: a process a question would take seconds.

    Raises
    ------
    EngineError
        If there is no answer.
    """
    if isinstance(engine.answers, AskedAnswers) and "unsupported" in engine.questions:
        known = engine.answers.known
        if left := [scene for scene in scenes if scene.digest not in known]:
            engine.answers.describe("unsupported", left)


def taken_along(engine: Declarations, scene: Scene, settings: Sequence[Setting], t_s: Array) -> Declarations:
    """Declarations for a judgement in another process: there an engine of another package is not asked again.

    It has the noise at some settings, and nothing else: an answer that is kept is known by what it was given.
    """
    if not isinstance(engine.answers, AskedAnswers):
        return engine
    asked = engine.answers
    keys = [noise_key(scene, setting, t_s) for setting in settings] if engine.declares_noise else []
    if any(key not in asked.known for key in keys):
        with contextlib.suppress(EngineError, DeclarationError):  # the judgement tells
            asked.describe("noise", [scene], settings, t_s)
    known = {key: asked.known[key] for key in keys if key in asked.known}
    return replace(engine, answers=AskedAnswers(asked.registration, known))


def declarations_of(registration: Registration) -> Declarations:
    """Declarations of an engine: of barchain's own from its class, of one of another package by its own answer.

    Raises
    ------
    AdapterLoadError
        If the adapter does not import, or an engine of another package does not declare what it must.
    """
    if registration not in ENGINES.values():
        found = asked_declarations(registration)
        if isinstance(found, str):
            raise AdapterLoadError(registration, found)
        return found
    try:
        return registration.declarations()
    except Exception as error:  # a broken installation of the engine's library may raise anything
        raise AdapterLoadError(registration, f"{type(error).__name__}: {plain_text(error)}") from error


def engine_fault(error: Exception) -> str:
    """Reason, in one line, why an engine's declarations can't be had, or it can't be asked."""
    said = str(error) if isinstance(error, EngineError) else f"its declarations raise {type(error).__name__}: {error}"
    return " ".join(said.split())


@cache
def asked_declarations(registration: Registration) -> Declarations | str:
    """Declarations of an engine, or why there are none; asked once, as an import that hangs costs its whole limit.

    What a program declares is the data of its entry: no code of it runs, and a process for each would take seconds.
    """
    if registration.entry:
        return registration.declarations()
    reply = ask(questions.describe, registration, limit_s=QUESTION_S)
    if reply.problem:
        return reply.problem
    try:
        said: dict[str, Any] = reply.header["declared"]
        values: dict[str, Any] = {name: form.meant(said[name]) for name, form in DECLARED.items()}
        answered = tuple(map(str, reply.header["questions"]))
    except (KeyError, TypeError, ValueError) as error:
        return f"its declarations are damaged: {plain_text(error)}"
    return Declarations(**values, questions=answered, answers=AskedAnswers(registration))
