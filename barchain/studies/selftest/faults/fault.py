"""The form of a planted mistake: where it is inserted, its size, and where it changes nothing."""

from __future__ import annotations

import contextlib
import hashlib
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from adapters.reference.numpy_engines import Reference

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

    from numpy.random import Generator

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Trajectory
    from barchain.runs.job import Role
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

    SceneChange = Callable[[Scene, float], Scene]
    SettingChange = Callable[[Setting, float], Setting]
    CodeChange = Callable[[float], AbstractContextManager[object]]
    OutputChange = Callable[[Trajectory, Scene, float], Trajectory]
    FreshChange = Callable[[Trajectory, Scene, float, Generator], Trajectory]
    DeclarationChange = Callable[[Declarations, Trajectory], Declarations]
    NotApplicable = Callable[[ReferenceSolution], str]
    Foreign = Callable[[Declarations], str]


class FaultGroup(StrEnum):
    """Origin of a fault."""

    CONTROL = "control"
    """No fault: no check may reject it"""
    PAPER = "misprints of the paper"
    EQUATIONS = "equations of motion"
    FORCES = "forces"
    EVENTS = "events"
    START = "scene and start"
    ACCURACY = "accuracy and precision"
    OUTPUT = "readout"
    GARBAGE = "garbage in the course of a run"
    DECLARED = "declarations"


def numbers_of(scene: Scene, setting: Setting) -> Generator:
    """Random numbers of one run."""
    words = hashlib.sha256(f"{scene.digest}|{setting.parameter}={setting.value!r}".encode()).digest()
    return np.random.default_rng(np.frombuffer(words, "<u4"))


@dataclass(frozen=True)
class Size:
    """Size of a continuous fault; no fault at all at `none`."""

    natural: float
    """As it would be met"""
    unit: str = "1"
    none: float = 0.0
    most: float | None = None
    """Up to where a size that is caught is looked for if the natural one is not; None: not beyond it"""


@dataclass(frozen=True)
class Fault:
    """One fault.

    It is inserted into the scene that the engine is given, its setting, its code, what is read out of it, or what it
    declares.
    """

    name: str
    words: str
    """Fault in words"""
    stands_for: str
    """Mistake that it stands for"""
    group: FaultGroup
    scene: SceneChange | None = None
    setting: SettingChange | None = None
    code: CodeChange | None = None
    """Code of the reference, for as long as the context holds"""
    output: OutputChange | None = None
    fresh: FreshChange | None = None
    """Change of the output by random numbers that differ in every run, and are the same when a run is repeated"""
    declares: DeclarationChange | None = None
    """Change of the host's declarations, given its own main run"""
    stuck: bool = False
    """Whether every run is at the host's default setting, whatever setting is asked for"""
    roles: frozenset[Role] | None = None
    """Runs that get the fault; None: all"""
    size: Size | None = None
    nothing: NotApplicable = lambda _: ""
    """Reason why it changes nothing in the scene of a reference solution; empty if it changes something"""
    foreign: Foreign = lambda _: ""
    """Why it can't be inserted into an engine, besides changes of the reference's code; empty if it can"""
    like: str = "unmodified"
    """Control that it is without its fault"""
    expected_failure: bool = False
    """Whether the faulty engine is expected to fail; of any other fault a failure is a mistake in the fault"""
    invisible: str = ""
    """Proof that no observable changes; empty: it has to be caught"""

    @property
    def natural(self) -> float:
        """Size at which it is inserted; 1 where it has none."""
        return self.size.natural if self.size else 1.0

    @property
    def replays(self) -> bool:
        """Whether only samples change: then a run of the unmodified engine serves."""
        return not (self.scene or self.setting or self.code or self.stuck)

    def foreign_to(self, engine: Declarations) -> str:
        """Why it can't be inserted into an engine; empty if it can."""
        if self.code and engine.answers is not Reference:
            return "inserted into the reference's code"
        return self.foreign(engine)

    def acts_in(self, role: Role) -> bool:
        """Whether runs of a role get the fault."""
        return self.roles is None or role in self.roles

    def staged(self, scene: Scene, size: float) -> Scene:
        """Scene that the engine is given."""
        return self.scene(scene, size) if self.scene else scene

    def asked(self, setting: Setting, size: float) -> Setting:
        """Setting that the engine is given."""
        return self.setting(setting, size) if self.setting else setting

    def within(self, size: float) -> AbstractContextManager[object]:
        """Context in which the reference's code is wrong."""
        return self.code(size) if self.code else contextlib.nullcontext()

    def output_of(self, trajectory: Trajectory, scene: Scene, setting: Setting, size: float) -> Trajectory:
        """Samples of a run of a scene at a setting."""
        if self.output:
            trajectory = self.output(trajectory, scene, size)
        return self.fresh(trajectory, scene, size, numbers_of(scene, setting)) if self.fresh else trajectory
