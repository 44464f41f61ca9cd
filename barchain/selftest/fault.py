"""What a seeded fault is: where it is put in, how large it is, and where it has nothing to spoil."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

    from adapters.engine import Setting, Trajectory
    from barchain.truth import Truth
    from scenarios import Scene

    SceneChange = Callable[[Scene, float], Scene]
    SettingChange = Callable[[Setting, float], Setting]
    CodeChange = Callable[[float], AbstractContextManager[object]]
    OutputChange = Callable[[Trajectory, Scene, float], Trajectory]
    Nothing = Callable[[Truth], str]


class Group(StrEnum):
    """Where a fault comes from."""

    CONTROL = "control"
    """No fault: nothing may kill it"""
    PAPER = "misprints of the paper"
    EQUATIONS = "equations of motion"
    FORCES = "what acts"
    EVENTS = "events"
    START = "scene and start"
    ACCURACY = "accuracy and precision"
    OUTPUT = "what is read out"


@dataclass(frozen=True)
class Size:
    """How large a continuous fault is; no fault at all at `none`."""

    natural: float
    """As it would be met"""
    unit: str = "1"
    none: float = 0.0
    most: float | None = None
    """Up to where a size that is caught is looked for if the natural one is not; None: not beyond it"""


def everywhere(truth: Truth) -> str:
    """No scene without something to spoil."""
    del truth
    return ""


@dataclass(frozen=True)
class Fault:
    """One fault. It is put into the scene that the engine is given, its setting, its code or what is read out of it."""

    name: str
    words: str
    """What is wrong"""
    stands_for: str
    """Mistake that it stands for"""
    group: Group
    scene: SceneChange | None = None
    setting: SettingChange | None = None
    code: CodeChange | None = None
    """Code of the reference, for as long as the context holds"""
    output: OutputChange | None = None
    size: Size | None = None
    nothing: Nothing = everywhere
    """Why it has nothing to spoil in the scene of a truth; empty if it has"""
    like: str = "sound"
    """Control that it is without its fault"""
    refuses: bool = False
    """Whether the spoilt engine is expected to fail; of any other a failure is a mistake in the fault"""
    invisible: str = ""
    """Proof that no observable changes; empty: it has to be caught"""

    @property
    def natural(self) -> float:
        """Size at which it is put in; 1 where it has none."""
        return self.size.natural if self.size else 1.0

    @property
    def replays(self) -> bool:
        """Whether it spoils only what is read out: then a sound run serves."""
        return not (self.scene or self.setting or self.code)

    def staged(self, scene: Scene, size: float) -> Scene:
        """Scene that the engine is given."""
        return self.scene(scene, size) if self.scene else scene

    def asked(self, setting: Setting, size: float) -> Setting:
        """Setting that the engine is given."""
        return self.setting(setting, size) if self.setting else setting

    def within(self, size: float) -> AbstractContextManager[object]:
        """Context in which the reference's code is wrong."""
        return self.code(size) if self.code else contextlib.nullcontext()

    def seen(self, seen: Trajectory, scene: Scene, size: float) -> Trajectory:
        """What is read out."""
        return self.output(seen, scene, size) if self.output else seen
