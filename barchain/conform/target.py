"""The engine that is examined: a registered one by name, or a class by ``module:Class``."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.registry import ENGINES, RESERVED, TARGET, Registration, UnknownEngineError, find_engine

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Engine, Setting
    from barchain.runs.job import Job, Role
    from scenarios import Scene

RUN_S = 10.0
"""Longest time of one run by default: most scenes are a fifth of an orbit of a few bars"""


@dataclass(frozen=True)
class Examined:
    """An engine that is examined."""

    name: str
    registration: Registration
    registered: bool = True
    """Whether the engine has an entry point; False of a class that is named directly"""
    run_s: float = RUN_S
    """Longest time of one run, after the start of its process"""
    note: Callable[[str], None] = lambda _: None
    """Called with a sentence before checks that take long"""

    @property
    def own(self) -> bool:
        """Whether the engine is barchain's own adapter."""
        return self.registration in ENGINES.values()

    def job(self, scene: Scene, setting: Setting, role: Role) -> Job:
        """A run of the engine."""
        from barchain.runs.job import Job  # noqa: PLC0415

        return Job(scene, self.name, self.registration, setting, role)

    def load(self) -> type[Engine]:
        """Class with the engine's declarations. Errors as :func:`barchain.runs.declared.engine_class`."""
        from barchain.runs.declared import engine_class  # noqa: PLC0415

        return engine_class(self.registration)


def examined(given: str) -> Examined:
    """Engine of a name, or of ``module:Class`` on Python's path or in the current folder.

    Raises
    ------
    UnknownEngineError
        If no engine has the name; the message tells how a class or a package is given.
    """
    if re.fullmatch(TARGET, given):
        here = str(Path.cwd())
        if here not in sys.path:
            sys.path.append(here)
        return Examined(short_name(given), Registration(given), registered=False)
    try:
        return Examined(given, find_engine(given))
    except UnknownEngineError as error:
        raise UnknownEngineError(f"{error}; {how_to_give(given)}") from None


def how_to_give(given: str) -> str:
    """How an engine is given that no package registers."""
    module, _, name = given.rpartition(".")
    if module and re.fullmatch(TARGET, f"{module}:{name}"):
        return f"a class is given as MODULE:CLASS (did you mean {module}:{name}?)"
    return "the engine of a package is there after `pip install -e FOLDER`; a class is given as MODULE:CLASS"


def short_name(target: str) -> str:
    """Name of a class that has no entry point yet: ``MyEngine`` becomes ``my-engine``."""
    words = re.findall(r"[A-Z]*[^A-Z]+|[A-Z]+", target.partition(":")[2])
    name = "-".join(w.lower().strip("_") for w in words if w.strip("_")) or "engine"
    return f"{name}-engine" if name in {*ENGINES, *RESERVED} else name
