"""One night of measurements: environment, parts of the code that ran, and figures."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from barchain.history.errors import FigureError

ID_DIGITS = 16


class FigureKind(StrEnum):
    """Kind of a figure: it decides by which rule two nights are compared."""

    BITS = "bits"
    """Digest of a trajectory: equal for equal code on equal machines"""
    ERROR = "error"
    """Difference from the judging solution, or a drift: deterministic up to round-off"""
    VERDICT = "verdict"
    """Outcome of an engine in a scene"""
    COUNT = "count"
    """Number of steps, evaluations or iterations: exact"""
    RATIO = "ratio"
    """Time relative to that of an anchor engine in the same job"""
    MEMORY = "memory"
    """Peak memory"""


class FigureUnit(StrEnum):
    """Unit of a figure."""

    NONE = "1"
    METRE = "m"
    METRE_PER_SECOND = "m/s"
    RADIAN = "rad"
    RADIAN_PER_SECOND = "rad/s"
    NEWTON = "N"
    NEWTON_METRE = "N m"
    NEWTON_SECOND = "N s"
    BYTE = "B"


WORDED = frozenset({FigureKind.BITS, FigureKind.VERDICT})
"""Kinds whose value is a word"""


@dataclass(frozen=True, order=True)
class Series:
    """Name of a figure: figures of one name are compared from night to night."""

    scene: str
    engine: str
    setting: str
    quantity: str
    metric: str
    kind: FigureKind
    unit: FigureUnit = FigureUnit.NONE

    def __str__(self) -> str:
        return " ".join((self.scene, self.engine, self.setting, self.quantity, self.metric))


@dataclass(frozen=True)
class CodePart:
    """Part of the code that figures depend on: an engine's package, or a part of barchain."""

    name: str
    version: str
    digest: str


@dataclass(frozen=True)
class Figure:
    """Value of one series on one night.

    Raises
    ------
    FigureError
        If the value is neither a finite number nor a word, as its kind needs, and no reason tells why it is missing.
    """

    series: Series
    value: float | None = None
    word: str = ""
    """Digest or outcome"""
    low: float | None = None
    high: float | None = None
    """Interval of a measured value"""
    roundoff: float | None = None
    """Change of an error that round-off alone may cause, in the unit of the value"""
    reason: str = ""
    """Reason of a missing value, or of an outcome"""
    parts: tuple[str, ...] = ()
    """Names of the parts that the figure depends on, sorted"""

    def __post_init__(self) -> None:
        """Check the value."""
        worded = self.series.kind in WORDED
        if worded and self.value is not None:
            raise FigureError(f"{self.series}: has a number, {self.value!r}; {self.series.kind} needs a word")
        if not worded and self.word:
            raise FigureError(f"{self.series}: has a word, {self.word[:40]!r}; {self.series.kind} needs a number")
        if self.value is not None and not math.isfinite(self.value):
            raise FigureError(f"{self.series}: {self.value!r} is no finite number")
        if self.is_missing and not self.reason:
            raise FigureError(f"{self.series}: has no value, and no reason for that")

    @property
    def is_missing(self) -> bool:
        """Whether the night has no value of the series."""
        return self.value is None and not self.word


@dataclass(frozen=True)
class Night:
    """Figures of one run of barchain, and everything that they depend on."""

    started: str
    """Instant, ISO 8601 with the offset from UTC"""
    command: str
    barchain: str
    """Version"""
    machine: str
    """Class of machines whose bits and times can be compared, see :func:`barchain.history.folders.machine_class`"""
    environment: dict[str, Any]
    parts: tuple[CodePart, ...]
    figures: tuple[Figure, ...]
    seconds: float = 0.0
    """Wall time, s"""
    commit: str = ""
    complete: bool = True
    void: str = ""
    """Reason why nothing of the night counts: an alarm that did not ring"""
    id: str = field(init=False, default="")
    """Digest of all other entries: the same night has the same id wherever it is added"""

    def __post_init__(self) -> None:
        """Sort parts and figures, and name the night by its contents."""
        object.__setattr__(self, "parts", tuple(sorted(self.parts, key=lambda part: part.name)))
        object.__setattr__(self, "figures", tuple(sorted(self.figures, key=lambda figure: figure.series)))
        object.__setattr__(self, "id", digest_of_night(self))

    def part(self, name: str) -> CodePart | None:
        """CodePart by its name."""
        return next((part for part in self.parts if part.name == name), None)


def digest_of_night(night: Night) -> str:
    """Digest of all entries of a night."""
    entries = dataclasses.asdict(night) | {"id": ""}
    return hashlib.sha256(json.dumps(entries, sort_keys=True).encode()).hexdigest()[:ID_DIGITS]
