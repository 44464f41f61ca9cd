"""Engine classes of other packages as the comparing process sees them: declarations as data, questions by message."""

from __future__ import annotations

import copyreg
import hashlib
from abc import ABCMeta
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, EngineError
from adapters.registry import ENGINES, Registration
from adapters.trajectory import Observable
from barchain.runs.asking import Reply, ask
from barchain.runs.declarations import DeclarationError
from barchain.runs.limits import TEXT_LENGTH, OutsideLimits
from barchain.runs.message import plain_text
from reports.tables.crossval import QUANTITY_UNITS
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.engine import Setting
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

QUESTION_LIMITS = OutsideLimits()
NOISE = tuple(QUANTITY_UNITS)
"""Quantities whose noise an engine may declare"""


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
            header = cls.answer("unsupported", left).header
            for scene, reason in zip(left, header["reasons"], strict=True):
                cls.answers[scene.digest] = None if reason is None else str(reason)[:TEXT_LENGTH]

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """Reason why this engine does not support a motion, by its own answer."""
        if "unsupported_motion" not in cls.asks:
            return None
        reason = cls.answer("unsupported_motion", scene, motion).header["reasons"][0]
        return None if reason is None else str(reason)[:TEXT_LENGTH]

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Errors that the engine declares, by its own answer; names and values are checked."""
        if "noise" not in cls.asks:
            return {}
        key = noise_key(scene, setting, t_s)
        if key not in cls.noises:
            cls.remember_noise(scene, setting, t_s, cls.answer("noise", scene, setting, t_s).arrays)
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
    def answer(cls, question: str, *given: Any) -> Reply:
        """Answer to a question; an error with the reason if there is none."""
        reply = ask(question, cls.registration, *given, limits=QUESTION_LIMITS)
        if reply.problem:
            raise EngineError(f"{question}: {reply.problem}")
        return reply

    def build(self, scene: Scene, setting: Setting) -> None:
        """Not here: runs are made in a process of their own."""
        del scene, setting
        self.refuse()

    def simulate(self) -> None:
        """Not here."""
        self.refuse()

    def read(self) -> Trajectory:
        """Not here."""
        self.refuse()

    def refuse(self) -> NoReturn:
        """Raise: code of another package is not run in this process."""
        raise RuntimeError(f"{self.registration.target} runs in a process of its own; use barchain.simulate")


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
    """Class of an engine, or why there is none; asked once, as an import that hangs costs its whole limit."""
    reply = ask("declarations", registration, limits=QUESTION_LIMITS)
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
    sweep = said["sweep"]
    name = registration.target.partition(":")[2] or "Engine"
    return OutsideEngineClass(  # type: ignore[return-value]
        name,
        (OutsideEngine,),
        {
            "registration": registration,
            "said": said,
            "answers": {},
            "noises": dict(noises or {}),
            "title": str(said["title"]),
            "coordinates": Coordinates(said["coordinates"]),
            "order": None if said["order"] is None else float(said["order"]),
            "sweep": AccuracySweep(
                AccuracyParameter(sweep["parameter"]),
                tuple(map(float, sweep["values"])),
                float(sweep["default"]),
                float(sweep["finer_rtol"]),
            ),
            "effects": frozenset(map(str, said["effects"])),
            "observables": frozenset(map(Observable, said["observables"])),
            "options": frozenset(map(str, said["options"])),
            "joints_in_place": bool(said["joints_in_place"]),
            "track_by_length": bool(said["track_by_length"]),
            "step_constant": float(said["step_constant"]),
            "unsupported_reasons": {str(k): str(v) for k, v in said["unsupported_reasons"].items()},
            "asks": frozenset(map(str, said["asks"])),
        },
    )


def reduced(made: type[OutsideEngine]) -> Any:
    """Form of a pickled class: its name, or of an engine's class what it has declared."""
    return "OutsideEngine" if made is OutsideEngine else (made_class, (made.registration, made.said, made.noises))


copyreg.pickle(OutsideEngineClass, reduced)  # type: ignore[arg-type]
