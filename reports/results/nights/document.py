"""Contents of ``nightly.json``: everything that is told of a night, checked by pydantic, with a JSON Schema."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field

from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Sequence

FILE = "nightly.json"
Direction = Literal["better", "worse", "same", "changed"]
STRICT = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)
"""Unknown keys are errors, and numbers are finite; texts below fields are their descriptions"""
STUDY_OF_COMMAND = {"compare": "comparison"}
"""Studies whose command has another name"""
NAMED = 3
"""Names in a sentence about many"""
MOST_NAME = 80
"""Characters of a name in a sentence"""
DIGITS = 8
LEAST_FACTOR = 1e-3
"""Smaller factors are divisions for readers"""
NOT_TRIED = "not tried"
CUT = "the night was interrupted"
"""Reason of a part that was not done then"""
PROGRAM = "program:"
"""Beginning of the names of programs: their earlier states are not kept, and can't be tried"""


class Entry(BaseModel):
    """Entry of the file."""

    model_config = STRICT


class SuspectEntry(Entry):
    """Part that differs between two nights."""

    name: str = Field(description="part, e.g. engine:mujoco")
    before: str = Field(description="version or digest on the earlier night; empty if the part was not there")
    after: str = Field(description="version or digest on the later night; empty if the part is gone")

    @property
    def short(self) -> str:
        """Name in a sentence: of a program without the files that count."""
        return self.name.partition(" (")[0]

    @property
    def words(self) -> str:
        """Part with what it was and is."""
        return f"{self.name} {self.before or '(none)'} → {self.after or '(none)'}"


class AcceptanceEntry(Entry):
    """Acceptance of a change."""

    who: str
    when: AwareDatetime
    reason: str
    until: AwareDatetime | None = None

    @property
    def words(self) -> str:
        """Acceptance in a few words."""
        return f"{self.who}: {self.reason}"

    @property
    def sentence(self) -> str:
        """Acceptance in one line."""
        until = f", until {self.until.date()}" if self.until else ""
        return f"accepted by {self.who} on {self.when.date()}{until}: {self.reason}"


def ratio_words(factor: float) -> str:
    """``×1.21``, ``×12 400``, ``÷33 000``; of a factor that rounds to 1 its departure: ``×(1 + 2e-9)``."""
    if 0.0 < factor < LEAST_FACTOR:
        return f"÷{multiple(1.0 / factor)}"
    shown, off = multiple(factor), factor - 1.0
    return f"×(1 {'-' if off < 0.0 else '+'} {abs(off):.2g})" if shown == "1" and off else f"×{shown}"


def multiple(factor: float) -> str:
    """``1.21``, ``12 400``: four digits, and three of a number that needs groups; a huge one has a power of ten."""
    if 1e4 <= float(f"{factor:.4g}") < 1e9:
        return f"{float(f'{factor:.3g}'):,.0f}".replace(",", " ")
    return f"{factor:.4g}".replace("e+", "e")


class ChangeEntry(Entry):
    """Change of one figure."""

    id: str = Field(description="name of the change for `barchain history accept` and `barchain attribute`")
    figure: str
    scene: str
    engine: str
    setting: str
    quantity: str
    kind: str
    unit: str
    was: str = Field(description="result on the last night with the old value, in words")
    became: str = Field(description="result on the first night with the new value, in words")
    factor: float | None = Field(None, description="new value over the old one")
    factor_low: float | None = Field(None, description="lower end of the factor's 95 % interval, of times and memory")
    factor_high: float | None = None
    direction: Direction
    last: str = Field(description="last night with the old value")
    since: str = Field(description="first night with the new value")
    reason: str
    irreproducible: bool = Field(description="whether equal parts on an equal machine gave other bits")
    suspects: tuple[SuspectEntry, ...] = Field(description="parts that differ and that the figure depends on")
    newest: tuple[SuspectEntry, ...] = Field((), description="suspects of the latest step, of several steps")
    unknown: tuple[str, ...] = Field((), description="parts of which it is not known whether they differ")
    confirmed: str = Field("", description="result of an attribution by real runs; empty without one")
    accepted: AcceptanceEntry | None = None

    steps: int = Field(1, description="number of steps that lead from the old value to the new one")
    also: int = Field(0, description="further figures of the same run that are missing since then: one event")
    fresh: float | None = Field(None, description="factor of tonight's step, of what is worse since an earlier night")
    measured: str = Field("", description="latest night with a result, of what is worse and was not measured tonight")

    @property
    def worse_verdict(self) -> bool:
        """Whether a verdict became worse."""
        return self.kind == "verdict" and self.direction == "worse"

    @property
    def never_words(self) -> str:
        """``failed from the first night on (no earlier pass)``; empty of a change of what was there before."""
        return f"{self.became} from the first night on (no earlier {self.was})" if self.last == self.since else ""

    @property
    def words(self) -> str:
        """Change in one line, without its direction."""
        return self.moved_words(" → ".join(self.results))

    def moved_words(self, moved: str) -> str:
        """Change in one line, with what it was and is in words."""
        factor = f" ({ratio_words(self.factor)}{self.steps_words})" if self.factor else ""
        more = f", and {self.also} more of this run" if self.also else ""
        unmeasured = f", not measured since {self.measured[:10]}" if self.measured else ""
        return f"{self.figure}: {self.never_words or moved}{factor}{more}{unmeasured}"

    def dated(self, night: str) -> str:
        """Change in one line that says since when it holds, on the page of a night.

        Beside an accepted step nobody measured what an error may be.
        """
        accepted = ", accepted" if self.accepted else ""
        if self.since == night:
            return f"{self.direction} tonight{accepted}: {self.words}"
        words = self.moved_words("may be {}, is {}".format(*self.results)) if self.kind == "error" else self.words
        return f"{self.direction} since {self.since[:10]}{accepted}: {words}"

    @property
    def steps_words(self) -> str:
        """Number of steps, where there are several, and the factor of tonight's one."""
        tonight = f", {ratio_words(self.fresh)} tonight" if self.fresh else ""
        return f" in {self.steps} steps{tonight}" if self.steps > 1 else ""

    @property
    def results(self) -> tuple[str, str]:
        """Old and new result as a table shows them: of a digest the first digits, as of suspects."""
        if self.never_words:
            return f"no earlier {self.was}", self.became
        digits = DIGITS if self.kind == "bits" else None
        return self.was[:digits], self.became[:digits]

    @property
    def factor_words(self) -> str:
        """``×1.21 (1.18 to 1.25)``; empty without a factor."""
        if not self.factor:  # nor is zero told relative to another number
            return ""
        known = self.factor_low is not None and self.factor_high is not None
        interval = f" ({self.factor_low:.3g} to {self.factor_high:.3g})" if known else ""
        return f"{ratio_words(self.factor)}{interval}{self.steps_words}"

    @property
    def suspect_words(self) -> str:
        """Suspects with what they were and are; of several steps those of the first one and of the latest one.

        Empty of what holds since the first night of the figure.
        """
        if self.suspects or self.newest:
            first, newest = (", ".join(suspect.words for suspect in own) for own in (self.suspects, self.newest))
            return "; ".join(filter(None, [first, f"latest step: {newest}" if newest else ""]))
        if self.never_words:
            return ""
        if self.unknown:
            return f"no known one; of unknown state: {', '.join(self.unknown)}"
        return "none: all parts that the figure depends on are the same"

    @property
    def confirmed_words(self) -> str:
        """Whether real runs confirm the suspects."""
        can_be_tried = any(not s.name.startswith(PROGRAM) and s.before and s.after for s in self.suspects)
        return self.confirmed or (NOT_TRIED if can_be_tried else "")


class PartState(StrEnum):
    """State of a part of a plan at the end of its night."""

    DONE = "done"
    LEFT = "left"
    """Some or all of it did not fit into the night, and goes first on the next one"""
    FAILED = "failed"
    """It ended with an error"""


@dataclass(frozen=True)
class PartResult:
    """Part of the plan at the end of its night."""

    __pydantic_config__ = STRICT

    name: str
    state: PartState
    share_s: float
    """time that it was given"""
    duration_s: float = 0.0
    left: tuple[str, ...] = ()
    """what did not fit and goes first on the next night: scenes, or the part by its name"""
    reason: str = ""
    """why the part was left or failed"""
    done: int = 0
    """number of scenes or faults that were done"""
    command: str = ""
    """command that repeats the part"""
    missing: str = ""
    """why engines or scenes that the part names did not run; the others did"""
    bad_input: bool = False
    """whether a scene of the part can't be read"""
    begun: bool = True
    """whether its turn came; of a part whose night ended before, nothing is known of the time that it needs"""

    @property
    def whole(self) -> bool:
        """Whether the part was done with all engines that it names."""
        return self.state is PartState.DONE and not self.missing

    @property
    def shown_state(self) -> str:
        """State for readers: a part of which something could not run is not done."""
        if self.state is not PartState.DONE or self.whole:
            return str(self.state)
        return "in part" if self.done else "not run"

    @property
    def reasons(self) -> str:
        """Why the part is not whole; empty without a reason."""
        return "; ".join(filter(None, [self.reason, self.missing]))


@dataclass(frozen=True)
class AlarmTest:
    """Planted faults of a night, and those that no check told."""

    __pydantic_config__ = STRICT

    planted: int
    missed: tuple[str, ...] = ()
    """faults that no check detected: one is enough to make a night void"""
    seed: int = 0
    false_alarms: tuple[str, ...] = ()
    """scenes in which a check rejected the unmodified engine: one is enough to make a night void"""

    @property
    def void(self) -> str | None:
        """Why the night can't be believed; None if the alarm rang when and only when it had to."""
        if self.missed:
            return f"{len(self.missed)} of {self.planted} planted faults missed: {some_of(self.missed)}"
        if self.false_alarms:
            return f"a check rejects the unmodified engine in {some_of(self.false_alarms)}"
        return None


def some_of(names: Sequence[str]) -> str:
    """Names in a sentence: the first ones, and how many more there are."""
    shown = [name if len(name) <= MOST_NAME else f"{name[: MOST_NAME - 3]}..." for name in names]
    if len(shown) <= NAMED + 1:
        return ", ".join(shown)
    return f"{', '.join(shown[:NAMED])} and {len(shown) - NAMED} more"


@dataclass(frozen=True)
class NightRun:
    """Parts of the plan that a night ran or left."""

    __pydantic_config__ = STRICT

    plan: str
    """name of the plan, with the digest of its content"""
    minutes: float
    """budget"""
    parts: tuple[PartResult, ...] = ()
    alarm: AlarmTest | None = None
    """None if the plan plants no faults, or the night ended before"""
    turn: int = 0
    """number of the night among those of its plan: decides scenes, faults and seeds that change from night to night"""

    @property
    def complete(self) -> bool:
        """Whether all parts were done, with all engines that they name."""
        return bool(self.parts) and all(part.whole for part in self.parts)

    @property
    def interrupted(self) -> bool:
        """Whether the night was ended from outside before its parts were done."""
        return any(part.reason == CUT for part in self.parts)

    @property
    def left(self) -> frozenset[tuple[str, str]]:
        """Studies and scenes that the night did not do; an empty scene where it is not known which."""
        found: set[tuple[str, str]] = set()
        for part in self.parts:
            for word in part.command.split()[1:2] if part.state is not PartState.DONE else ():
                known = part.state is PartState.LEFT and part.left and part.left != (part.name,)
                scenes = map(scene_name, part.left) if known else ("",)
                found |= {(STUDY_OF_COMMAND.get(word, word), scene) for scene in scenes}
        return frozenset(found)


def scene_name(given: str) -> str:
    """Name of a scene in tables: of a file the file's name without its ending."""
    return given.rpartition("/")[2].removesuffix(".toml") if given.endswith(".toml") else given


class NightEntry(Entry):
    """Night without its figures."""

    name: str
    started: AwareDatetime
    duration_s: float
    plan: str
    barchain: str
    commit: str | None = None
    state: Literal["complete", "incomplete", "void"]
    void: str | None = Field(None, description="why the night can't be believed")
    figures: int
    machine_class: str
    environment: dict[str, str | int]
    versions: dict[str, str] = Field(
        description="version of each engine's distribution, of each program that states one, and of each library"
    )
    exchanged: tuple[SuspectEntry, ...] = Field(
        (), description="parts that differ from the last night before, also where no figure changed"
    )

    @property
    def packages(self) -> dict[str, str]:
        """Versions by the names of distributions, programs and libraries; that of Python is in the environment."""
        names = ((part.partition(":")[2].partition(" (")[0], version) for part, version in self.versions.items())
        return {name: version for name, version in names if name}


class CountsEntry(Entry):
    """Numbers of figures by what became of them."""

    judged: int = Field(description="figures that have an earlier one, also those that are gone since tonight")
    same: int = Field(description="figures that differ within rounding or their intervals")
    worse: int
    better: int
    changed: int = Field(description="neither better nor worse")
    accepted: int = Field(description="changes of tonight that somebody accepted; not counted elsewhere")
    irreproducible: int
    new: int = Field(0, description="figures without an earlier one, other than of scenes that change each night")


class AgainstEntry(Entry):
    """Nights, or the one baseline, that the night was judged against."""

    nights: int
    first: str = ""
    last: str = ""
    baseline: str = Field("", description="the one night, or file, of --baseline; empty without")


class RejectedEntry(Entry):
    """Pair of a scene and an engine whose verdict is no pass, whether that changed or not."""

    scene: str
    engine: str
    setting: str
    verdict: str
    reason: str

    @property
    def words(self) -> str:
        """Pair, verdict and reason in one line."""
        return f"{self.engine} on {self.scene}: {self.verdict}{f': {self.reason}' if self.reason else ''}"


class NightlyFile(Entry):
    """Contents of the file of a night."""

    schema_version: Literal[1] = 1
    sentence: str
    night: NightEntry
    against: AgainstEntry
    counts: CountsEntry
    verdicts: dict[str, int] = Field(description="number of cells with each verdict tonight, whether changed or not")
    rejected: tuple[RejectedEntry, ...] = Field(
        (), description="pairs whose verdict tonight is neither a pass nor an engine's stated limit, changed or not"
    )
    changes: tuple[ChangeEntry, ...] = Field(description="changes that this night tells first")
    standing: tuple[ChangeEntry, ...] = Field(
        description="what is worse than accepted since an earlier night, from what it may be to what it is"
    )
    held: tuple[ChangeEntry, ...] = Field(
        (), description="what is worse than it was since an earlier night, and accepted"
    )
    renamed: tuple[str, ...] = Field((), description="settings and scenes that have other names since this night")
    so_far: str = Field(
        "", description="what moved most among times and memory that have too few nights for a step; empty if nothing"
    )
    left_out: dict[str, str] = Field(
        {}, description="nights of the history that count as not there, e.g. damaged ones, each with the reason"
    )
    run: NightRun | None = Field(None, description="None of a night that a result folder was added as")

    @property
    def state(self) -> str:
        """State of the night in a word: what needs a look first."""
        if self.night.state == "void":
            return "void"
        if self.worse:
            return "worse"
        if self.night.state == "incomplete":
            return "incomplete"
        if self.differs or self.rejected:
            return "changed" if self.differs else "not passed"
        return "quiet" if self.against.nights else "first night"

    @property
    def standing_title(self) -> str:
        """Head above what is worse than accepted."""
        tonight = [change for change in self.standing if change.since == self.night.name]
        if not tonight:
            return "Worse than accepted since earlier nights"
        return "Worse than accepted" if len(tonight) < len(self.standing) else "Failed from the first night on"

    @property
    def plan_name(self) -> str:
        """Name of the plan, without its digest."""
        return self.night.plan.rpartition(" ")[0] or self.night.plan

    @property
    def worse(self) -> bool:
        """Whether a figure is worse than accepted, since tonight or an earlier night."""
        return self.counts.worse > 0 or bool(self.standing)

    @property
    def other_news(self) -> tuple[ChangeEntry, ...]:
        """Changes of tonight, other than steps of figures that are worse since an earlier night."""
        states = {change.figure for change in self.standing}
        return tuple(change for change in self.changes if change.figure not in states or change.irreproducible)

    @property
    def listed(self) -> tuple[ChangeEntry, ...]:
        """What is worse since earlier nights, and news: the gravest first, so that no drift hides a large new step."""

        def place(change: ChangeEntry) -> tuple[bool, bool, float]:
            worse = change.direction == "worse" and change.accepted is None
            return not change.worse_verdict, not worse, -(change.factor or math.inf) if worse else 0.0

        return tuple(sorted((*self.standing, *self.other_news), key=place))

    @property
    def left_out_words(self) -> str:
        """Nights that count as not there, in one line; empty without any."""
        count = len(self.left_out)
        are = "is" if count == 1 else "are"
        what = "night or file" if any("/" in name for name in self.left_out) else "night"
        said = f"{plural(count, what)} of the history {are} damaged, or there twice, and left out"
        return f"{said}: {some_of(tuple(self.left_out))}" if count else ""

    @property
    def compared(self) -> bool:
        """Whether a figure was compared with an earlier one."""
        return self.counts.judged > 0

    @property
    def bad_input(self) -> bool:
        """Whether a scene of the plan can't be read."""
        return self.run is not None and any(part.bad_input for part in self.run.parts)

    @property
    def differs(self) -> bool:
        """Whether a figure is worse, or changed tonight in any way, and nobody accepted the change."""
        return self.worse or self.counts.better + self.counts.changed > 0
