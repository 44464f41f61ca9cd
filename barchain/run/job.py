"""One run of one engine: what is asked, and what came back."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

from barchain.record.sources import source_digest

if TYPE_CHECKING:
    from adapters.engine import Setting
    from adapters.registry import Registration
    from adapters.trajectory import Trajectory
    from reports.tables.outcome import Outcome
    from scenarios import Scene


class Role(StrEnum):
    """What a run is for."""

    MAIN = "main"
    """An engine at the setting it is judged at."""
    FINER = "finer"
    """The same, one setting finer: their difference estimates the engine's own error."""
    FINEST = "finest"
    """Finer again, where the two others do not show how the error falls."""
    ROUNDOFF_1 = "roundoff-1"
    """The main setting again, the frame turned and the start moved in its last digits: the round-off of this run."""
    ROUNDOFF_2 = "roundoff-2"
    """As the first, by another angle."""
    ROUNDOFF_3 = "roundoff-3"
    """As the first, by a third angle."""
    SOLUTION = "solution"
    """The reference at its tightest."""
    SOLUTION_CHECK = "solution-check"
    """The reference ten times looser: the truth's error bar."""
    FINE = "solution-dense"
    """The reference at close samples: what its derivatives are."""
    PERTURBED_START = "perturbed-start"
    """The truth from a slightly perturbed start: how the scene amplifies errors."""
    COARSE = "coarse"
    """An engine far below the setting it is judged at: how its error falls with the setting."""
    PLAIN = "plain"
    """A library's solver as it comes, at its own default tolerances."""
    EXACT = "exact"
    """The compiled reference at the accuracy at which its sums keep what rounding would lose."""


ROUNDOFF_ROLES = (Role.ROUNDOFF_1, Role.ROUNDOFF_2, Role.ROUNDOFF_3)
"""Runs that show a run's round-off: what one of them differs by may be small by chance, what three do hardly"""
SOLUTION_ROLES = (Role.SOLUTION, Role.SOLUTION_CHECK, Role.PERTURBED_START, Role.FINE)
"""Runs that a scene's truth is made of, as `barchain.solutions.reference.establish` takes them"""


@dataclass(frozen=True)
class Job:
    """One run to be made."""

    scene: Scene
    engine: str
    registration: Registration
    setting: Setting
    role: Role
    options: frozenset[str] = frozenset()
    """Extras asked of the engine, see `Engine.options`"""

    @property
    def file_stem(self) -> str:
        """Name of its trajectory's file inside the scene's folder."""
        if self.role is Role.MAIN:
            return self.engine
        return str(self.role) if self.role in SOLUTION_ROLES else f"{self.engine}.{self.role}"

    @cached_property
    def key(self) -> str:
        """Equal for runs that must give the same trajectory on the same machine: of the same code, too."""
        return "|".join(
            [
                self.scene.digest,
                self.registration.target,
                self.registration.version,
                source_digest(self.registration.target),
                str(self.setting),
                self.role,
            ]
        )


@dataclass(frozen=True)
class RunResult:
    """What a run gave. Its outcome is PASS for a complete, finite trajectory, whatever its accuracy."""

    outcome: Outcome
    reason: str = ""
    trajectory: Trajectory | None = None
    seconds: dict[str, float] = field(default_factory=dict)
    """Wall time of `build`, `simulate`, `read`"""
    rejected: bool = False
    """Whether the engine said, before its first step, that it will not"""


def failure(outcome: Outcome, reason: str, *, rejected: bool = False) -> RunResult:
    """Result of a run that gave nothing; the reason is kept to one line."""
    return RunResult(outcome, " ".join(reason.split())[:500], rejected=rejected)
