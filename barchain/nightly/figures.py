"""Figures and nights: what a night measured, over what, and which names and digests they have. No input and output."""

from __future__ import annotations

import dataclasses
import datetime
import hashlib
import json
import math
from dataclasses import dataclass, fields
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

from reports.tables.rows import NOT_RUN

if TYPE_CHECKING:
    from collections.abc import Mapping

    from barchain.nightly.run_facts import NightRun


MOST_TEXT = 500
"""Characters of a text; names and reasons are far shorter"""


class FigureError(ValueError):
    """Raised for a figure, a part or a night that contradicts itself; the message is one line."""


def need_text(field: str, text: str, most: int = MOST_TEXT) -> None:
    """Check that a text is printable, on one line, and not too long.

    Raises
    ------
    FigureError
        If it is not.
    """
    if not text.isprintable() or len(text) > most:
        raise FigureError(f"{field}: {text[:60]!r} given, allowed: at most {most} printable characters")


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
REQUIREMENTS = "requirements:"
"""Beginning of the name of the part of all that an engine's distribution requires"""
"""Name of the part that stands for the machine class"""
MOST_COUNT = 2.0**53
"""Largest count that a double holds exactly"""
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
STEPPED = frozenset({FigureKind.RATIO, FigureKind.MEMORY})
"""Noisy kinds: they change by steps of their levels"""
"""Kinds whose result is a word, not a number"""
UNITS_OF = {
    FigureKind.BITS: {FigureUnit.NONE},
    FigureKind.VERDICT: {FigureUnit.NONE},
    FigureKind.COUNT: {FigureUnit.ONE},
    FigureKind.RATIO: {FigureUnit.ONE},
    FigureKind.MEMORY: {FigureUnit.BYTE},
    FigureKind.ERROR: set(FigureUnit) - {FigureUnit.NONE, FigureUnit.BYTE},
    FigureKind.VALUE: set(FigureUnit) - {FigureUnit.NONE},
}
"""Allowed units of each kind"""


@dataclass(frozen=True, slots=True)
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

    def __post_init__(self) -> None:
        """Check texts, and that kind, unit and anchor agree."""
        for field in ("scene", "engine", "setting", "quantity", "anchor"):
            need_text(field, getattr(self, field))
        if not self.quantity:
            raise FigureError("quantity: no text given, allowed: a name")
        if self.unit not in UNITS_OF[self.kind]:
            allowed = ", ".join(repr(str(u)) for u in sorted(UNITS_OF[self.kind]))
            raise FigureError(f"{self.name}: unit {str(self.unit)!r} given, allowed for {self.kind}: {allowed}")
        if (self.kind is FigureKind.RATIO) is not bool(self.anchor):
            raise FigureError(f"{self.name}: a ratio has an anchor, and no other figure has one")

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
        """Check the result against the kind."""
        object.__setattr__(self, "depends", tuple(sorted(set(self.depends))))
        for field in ("word", "trajectory", "reason"):
            text = getattr(self, field)
            if text:  # most are empty, and a history has millions
                need_text(field, text)
        self.check_numbers()
        kind = self.identity.kind
        if kind in WORDED and self.value is not None:
            raise self.wrong(f"{kind} has a word, not a number")
        if kind not in WORDED and self.word:
            raise self.wrong(f"{kind} has a number, not a word")
        if self.missing and not self.reason:
            raise self.wrong("is missing without a reason")
        if self.missing and (self.low is not None or self.high is not None):
            raise self.wrong("is missing and has an interval")

    def check_numbers(self) -> None:
        """Check that numbers are finite and in the range of the kind."""
        for field in ("value", "low", "high", "tolerance"):
            number = getattr(self, field)
            if number is not None and not math.isfinite(number):
                raise self.wrong(f"{field} {number} given, allowed: a finite number; a missing figure has a reason")
            if number is not None:
                object.__setattr__(self, field, float(number) + 0.0)  # databases have no negative zero
        kind, value = self.identity.kind, self.value
        if self.tolerance is not None and (self.tolerance < 0.0 or kind not in {FigureKind.ERROR, FigureKind.VALUE}):
            raise self.wrong("a tolerance is at least 0, of an error or a value")
        if value is None:
            return
        if kind is FigureKind.COUNT and (value != int(value) or not 0.0 <= value <= MOST_COUNT):
            raise self.wrong(f"{value} given, allowed: a whole number from 0 to 2^53")
        if kind is FigureKind.ERROR and value < 0.0:
            raise self.wrong(f"{value} given, allowed: an error of at least 0")
        if kind in STEPPED and not value > 0.0:
            raise self.wrong(f"{value} given, allowed: a positive number")
        if (self.low is not None and self.low > value) or (self.high is not None and self.high < value):
            raise self.wrong("the value lies outside its interval")

    @property
    def missing(self) -> bool:
        """Whether there is no result."""
        return self.value is None and not self.word

    @property
    def not_run(self) -> bool:
        """Whether there is no result because its run did not fit into the time: no change of the figure."""
        return self.missing and self.reason.startswith(NOT_RUN)

    def wrong(self, said: str) -> FigureError:
        """Error of this figure."""
        return FigureError(f"{self.identity.name}: {said}")


@dataclass(frozen=True, slots=True)
class NightPart:
    """Part that figures depend on: an engine's distribution, an adapter, the reference, a scene, the judge, ..."""

    name: str
    version: str = ""
    digest: str = ""
    """Of the installed files; empty where it is unknown"""

    def __post_init__(self) -> None:
        """Check the texts."""
        for field in ("name", "version", "digest"):
            need_text(field, getattr(self, field))
        if not self.name:
            raise FigureError("part: no name given")

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

    def __post_init__(self) -> None:
        """Check the texts; flags are long."""
        for field in fields(self):
            need_text(field.name, str(getattr(self, field.name)), most=20 * MOST_TEXT)

    @cached_property
    def machine_class(self) -> str:
        """Digest of all that decides bits and times below the installed packages.

        Processor and flags decide which code libraries dispatch to, the C library its mathematical functions, cores how
        much runs beside. The kernel decides no bits and is left out, as it changes under a machine's user. Python and
        BLAS are parts: what they change has them as suspects.
        """
        return content_digest([self.cpu, self.cpu_flags, self.cores, self.architecture, self.libc])[:16]


@dataclass(frozen=True)
class Night:
    """One night: environment, parts and figures. Nights of equal content are the same night."""

    started: datetime.datetime
    """UTC"""
    duration_s: float
    plan: str
    """Digest of the plan, or the kind of the result folder"""
    barchain: str
    """Version"""
    environment: Environment
    parts: tuple[NightPart, ...] = ()
    figures: tuple[Figure, ...] = ()
    commit: str | None = None
    complete: bool = True
    void: str | None = None
    """Why the night can't be believed; None if it can"""
    label: str = ""
    """Ending of the name, of a night that has a folder already; the first digits of the identity by default"""

    def __post_init__(self) -> None:
        """Put parts and figures in order, and check that they belong together."""
        offset = self.started.utcoffset()
        if offset is None or offset:
            raise FigureError(f"start {self.started.isoformat()} given, allowed: UTC")
        if not (math.isfinite(self.duration_s) and self.duration_s >= 0.0):
            raise FigureError(f"duration {self.duration_s} s given, allowed: at least 0 s")
        for field in ("plan", "barchain", "commit", "void", "label"):
            need_text(field, getattr(self, field) or "")
        if MACHINE in {p.name for p in self.parts}:
            raise FigureError(f"part {MACHINE}: follows from the environment")
        object.__setattr__(self, "parts", tuple(sorted(self.parts, key=lambda p: p.name)))
        object.__setattr__(self, "figures", tuple(sorted(self.figures, key=order_of)))
        self.check_names()

    def check_names(self) -> None:
        """Check that names are unique, and that figures depend on known parts."""
        if len(self.part_named) <= len(self.parts):
            raise FigureError("two parts of a night have the same name")
        seen: set[FigureIdentity] = set()
        for figure in self.figures:
            if figure.identity in seen:
                raise figure.wrong("stands twice in a night")
            seen.add(figure.identity)
        for name in {name for figure in self.figures for name in figure.depends}:
            if name not in self.part_named:
                raise FigureError(f"a figure depends on {name}, which the night does not list")

    @cached_property
    def part_named(self) -> Mapping[str, NightPart]:
        """Parts by name, the machine class among them."""
        machine = NightPart(MACHINE, self.environment.cpu[:MOST_TEXT], self.environment.machine_class)
        return {part.name: part for part in (*self.parts, machine)}

    @cached_property
    def identity(self) -> str:
        """Digest of the whole content."""
        return content_digest(self)

    @cached_property
    def name(self) -> str:
        """Name of the night and of its folder: its start, and some digits that tell nights of one second apart."""
        return f"{self.started.strftime(NIGHT_FORMAT)}-{self.label or self.identity[:8]}"


def order_of(figure: Figure) -> tuple[str, ...]:
    """Sort key of a figure."""
    i = figure.identity
    return i.scene, i.engine, i.setting, i.quantity, i.kind, i.unit, i.anchor


@dataclass(frozen=True)
class NightSummary:
    """Night without its figures."""

    name: str
    started: datetime.datetime
    duration_s: float
    plan: str
    barchain: str
    environment: Environment
    parts: tuple[NightPart, ...]
    figures: int
    """Number of figures"""
    commit: str | None = None
    complete: bool = True
    void: str | None = None
    run: NightRun | None = None
    """What the night did of its plan; None of a night that was added as a result folder"""
    digest: str = ""
    size_B: int = 0
    """Of the file of its figures"""
    added: str = ""
    """Instant at which the history got the night, UTC, ISO 8601; empty where it is not known"""

    @cached_property
    def part_named(self) -> Mapping[str, NightPart]:
        """Parts by name, the machine class among them."""
        machine = NightPart(MACHINE, self.environment.cpu[:MOST_TEXT], self.environment.machine_class)
        return {part.name: part for part in (*self.parts, machine)}

    @property
    def state(self) -> str:
        """State in a word or a reason."""
        return f"void: {self.void}" if self.void else "complete" if self.complete else "incomplete"


@dataclass(frozen=True)
class ValueSeries:
    """Positive values of one figure, for drawing."""

    identity: FigureIdentity
    nights: tuple[str, ...]
    """Names of the nights"""
    values: tuple[float, ...]


@dataclass(frozen=True)
class FigureSeries:
    """One figure over the nights that have it, in their order."""

    identity: FigureIdentity
    nights: tuple[NightSummary, ...]
    figures: tuple[Figure, ...]

    def __post_init__(self) -> None:
        """Check that each figure has its night."""
        if len(self.nights) != len(self.figures):
            raise ValueError(f"{self.identity.name}: {len(self.figures)} figures of {len(self.nights)} nights")
