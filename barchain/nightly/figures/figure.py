"""Figures and nights: what a night measured, over what, and which names and digests they have. No input and output."""

from __future__ import annotations

import dataclasses
import datetime
import hashlib
import json
import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any

from reports.results.nights.document import NightRun  # noqa: TC001  # pydantic reads the annotations of records
from reports.results.rows import NOT_RUN

if TYPE_CHECKING:
    from collections.abc import Mapping


MOST_TEXT = 500
"""Characters of a text; names and reasons are far shorter"""


class FigureError(ValueError):
    """Raised for a figure that is no result; the message is one line."""


def content_digest(content: object) -> str:
    """Hash of dataclasses, lists and plain values; numbers count with all their digits."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), default=plain, allow_nan=False)
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def plain(value: object) -> object:
    """Fields of a dataclass, or a date as text."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [getattr(value, field.name) for field in dataclasses.fields(value)]
    if isinstance(value, datetime.datetime):
        return value.isoformat()
    raise TypeError(f"{type(value).__name__} has no content digest")


MACHINE = "machine"
"""Name of the part that stands for the machine class"""
REQUIREMENTS = "requirements:"
"""Beginning of the name of the part of all that an engine's distribution requires"""
NIGHT_FORMAT = "%Y-%m-%dT%H-%M-%S"


class FigureKind(StrEnum):
    """Kind of a figure; each kind has its own rule of change."""

    BITS = "bits"
    """Digest of a trajectory"""
    ERROR = "error"
    """Difference from the solution that judges"""
    VERDICT = "verdict"
    """Outcome, a word of a closed set"""
    COUNT = "count"
    """Whole number: steps, evaluations, iterations, instructions"""
    RATIO = "ratio"
    """Time relative to the time of an anchor in the same job"""
    MEMORY = "memory"
    """Peak memory"""
    VALUE = "value"
    """Any other number: an exponent, a rate, a size"""


class FigureUnit(StrEnum):
    """Unit of a figure."""

    NONE = ""
    ONE = "1"
    METRE = "m"
    METRE_PER_SECOND = "m/s"
    RADIAN = "rad"
    RADIAN_PER_SECOND = "rad/s"
    NEWTON = "N"
    NEWTON_METRE = "N m"
    NEWTON_SECOND = "N s"
    SECOND = "s"
    BYTE = "B"


WORDED = frozenset({FigureKind.BITS, FigureKind.VERDICT})
"""Kinds whose result is a word, not a number"""
STEPPED = frozenset({FigureKind.RATIO, FigureKind.MEMORY})
"""Noisy kinds: they change by steps of their levels"""


@dataclass(frozen=True, slots=True, order=True)
class FigureIdentity:
    """Identity of a figure over the nights."""

    scene: str
    engine: str
    setting: str
    quantity: str
    kind: FigureKind
    unit: FigureUnit = FigureUnit.NONE
    anchor: str = ""
    """Of a ratio: the engine, or the form of the scene, whose time is 1"""

    @property
    def name(self) -> str:
        """Name in tables and on the command line: ``scene:engine:setting:quantity``, with ``/anchor`` for a ratio."""
        relative = f"/{self.anchor}" if self.anchor else ""
        return f"{self.scene}:{self.engine}:{self.setting}:{self.quantity}{relative}"


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of one night: a number, a word, or the reason why it is missing."""

    identity: FigureIdentity
    value: float | None = None
    """Number, in the unit of the identity"""
    word: str = ""
    """Digest or outcome"""
    low: float | None = None
    """Lower end of the interval of the value"""
    high: float | None = None
    tolerance: float | None = None
    """Of an error or a value: largest difference that rounding may cause through the scene's error amplification"""
    trajectory: str = ""
    """Digest of the trajectory behind the figure"""
    depends: tuple[str, ...] = ()
    """Names of the parts that the figure depends on, in order"""
    reason: str = ""
    """Why the figure is missing; of a verdict the judge's words"""

    def __post_init__(self) -> None:
        """Put the parts in order, and check that the figure is a result: a comparison with NaN would never differ."""
        object.__setattr__(self, "depends", tuple(sorted(set(self.depends))))
        for number in (self.value, self.low, self.high, self.tolerance):
            if number is not None and not math.isfinite(number):
                raise FigureError(f"{self.identity.name}: {number} given, allowed: a finite number, or a reason")
        if self.missing and not self.reason:
            raise FigureError(f"{self.identity.name}: is missing without a reason")

    @property
    def missing(self) -> bool:
        """Whether there is no result."""
        return self.value is None and not self.word

    @property
    def not_run(self) -> bool:
        """Whether there is no result because its run did not fit into the time: no change of the figure."""
        return self.missing and self.reason.startswith(NOT_RUN)


@dataclass(frozen=True, slots=True)
class NightPart:
    """Part that figures depend on: an engine's distribution, an adapter, the reference, a scene, the judge, ..."""

    name: str
    version: str = ""
    digest: str = ""
    """Of the installed files; empty where it is unknown"""

    def differs(self, other: NightPart) -> bool:
        """Whether two states of a part differ: by their digests, or by their versions where a digest is unknown.

        A new version of barchain with the same adapter changes nothing that depends on that adapter alone.
        """
        if self.digest and other.digest:
            return self.digest != other.digest
        return self.version != other.version


@dataclass(frozen=True)
class Environment:
    """Machine and libraries below the engines."""

    cpu: str
    cpu_flags: str
    """Instruction sets in order; empty where they are unknown"""
    cores: int
    architecture: str
    kernel: str
    libc: str
    blas: str
    """Libraries of linear algebra, each with version and the kernel chosen for the processor"""
    python: str

    @cached_property
    def machine_class(self) -> str:
        """Digest of all that decides bits and times below the installed packages.

        Processor and flags decide which code libraries dispatch to, the C library its mathematical functions, cores how
        much runs beside. The kernel decides no bits and is left out, as it changes under a machine's user. Python and
        BLAS are parts: what they change has them as suspects.
        """
        return content_digest([self.cpu, self.cpu_flags, self.cores, self.architecture, self.libc])[:16]


@dataclass(frozen=True, kw_only=True)
class NightFacts:
    """What a night was over, and how it ended."""

    started: datetime.datetime
    """UTC"""
    duration_s: float
    plan: str
    """Digest of the plan, or the kind of the result folder"""
    barchain: str
    """Version"""
    environment: Environment
    parts: tuple[NightPart, ...] = ()
    commit: str | None = None
    complete: bool = True
    void: str | None = None
    """Why the night can't be believed; None if it can"""

    @cached_property
    def part_named(self) -> Mapping[str, NightPart]:
        """Parts by name, the machine class among them."""
        machine = NightPart(MACHINE, self.environment.cpu[:MOST_TEXT], self.environment.machine_class)
        return {part.name: part for part in (*self.parts, machine)}

    @property
    def facts(self) -> dict[str, Any]:
        """These facts by name."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(NightFacts)}

    @property
    def state(self) -> str:
        """State in a word or a reason."""
        return f"void: {self.void}" if self.void else "complete" if self.complete else "incomplete"


@dataclass(frozen=True, kw_only=True)
class Night(NightFacts):
    """One night: environment, parts and figures. Nights of equal content are the same night."""

    figures: tuple[Figure, ...] = ()
    label: str = ""
    """Ending of the name, of a night that has a folder already; the first digits of its content's digest by default"""

    def __post_init__(self) -> None:
        """Put parts and figures in order."""
        object.__setattr__(self, "parts", tuple(sorted(self.parts, key=lambda p: p.name)))
        object.__setattr__(self, "figures", tuple(sorted(self.figures, key=lambda figure: figure.identity)))

    @cached_property
    def name(self) -> str:
        """Name of the night and of its folder: its start, and some digits that tell nights of one second apart."""
        content = [self.started, self.duration_s, self.plan, self.barchain, self.environment, self.parts, self.figures,
                   self.commit, self.complete, self.void, self.label]  # fmt: skip
        return f"{self.started.strftime(NIGHT_FORMAT)}-{self.label or content_digest(content)[:8]}"

    def summary(self, **stored: Any) -> NightSummary:
        """Night without its figures, with what a history knows of it."""
        return NightSummary(**self.facts, name=self.name, figures=len(self.figures), **stored)


SHARED: dict[Any, Any] = {}
"""Parts and environments of all nights: most nights share them, and equal ones are one object"""


@dataclass(frozen=True, kw_only=True)
class NightSummary(NightFacts):
    """Night without its figures, as its record in a history holds it."""

    name: str
    figures: int
    """Number of figures"""
    run: NightRun | None = None
    """What the night did of its plan; None of a night that was added as a result folder"""
    digest: str = ""
    """Of the file of its figures"""
    size_B: int = 0
    """Of the same file"""
    added: str = ""
    """Instant at which the history got the night, UTC, ISO 8601; empty where it is not known"""

    def __post_init__(self) -> None:
        """Share parts and environment with other nights."""
        object.__setattr__(self, "parts", tuple(SHARED.setdefault(part, part) for part in self.parts))
        object.__setattr__(self, "environment", SHARED.setdefault(self.environment, self.environment))


EarlierNames = tuple[tuple[FigureIdentity, str], ...]
"""Names that a figure had before, in their order, each with its last night"""


def names_since(night: str, identity: FigureIdentity, earlier: EarlierNames) -> tuple[FigureIdentity, ...]:
    """Names that a figure had on a night and has had since, in their order."""
    return (*(name for name, last in earlier if last >= night), identity)
