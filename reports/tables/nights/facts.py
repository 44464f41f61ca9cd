"""Contents of ``nightly.json``: everything that is told of a night, checked by pydantic, with a JSON Schema."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, ValidationError

from reports.tables.reading import damaged

if TYPE_CHECKING:
    from pathlib import Path

FILE = "nightly.json"
Direction = Literal["better", "worse", "same", "changed"]


class Entry(BaseModel):
    """Entry of the file: unknown keys are errors, and numbers are finite."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class SuspectEntry(Entry):
    """Part that differs between two nights."""

    name: str = Field(description="part, e.g. engine:mujoco")
    before: str = Field(description="version or digest on the earlier night; empty if the part was not there")
    after: str = Field(description="version or digest on the later night; empty if the part is gone")


class AcceptanceEntry(Entry):
    """Acceptance of a change."""

    who: str
    when: AwareDatetime
    reason: str
    until: AwareDatetime | None = None


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
    unknown: tuple[str, ...] = Field((), description="parts of which it is not known whether they differ")
    confirmed: str = Field("", description="result of an attribution by real runs; empty without one")
    accepted: AcceptanceEntry | None = None

    @property
    def words(self) -> str:
        """Change in one line."""
        factor = f" (×{self.factor:.4g})" if self.factor is not None else ""
        more = f", and {self.also} more of this run" if self.also else ""
        return f"{self.direction}: {self.figure}: {self.was} → {self.became}{factor}{more}"

    also: int = Field(0, description="further figures of the same run that are missing since then: one event")


class PartEntry(Entry):
    """Part of the plan."""

    name: str
    state: Literal["done", "left", "failed"]
    share_s: float
    duration_s: float
    left: tuple[str, ...] = Field((), description="what did not fit and goes first on the next night")
    reason: str = ""
    done: int = Field(0, description="number of scenes or faults that were done")
    command: str = Field("", description="command that repeats the part")
    missing: str = Field("", description="why engines or scenes that the part names did not run; the others did")
    bad_input: bool = Field(False, description="whether a scene of the part can't be read")

    @property
    def whole(self) -> bool:
        """Whether the part was done with all engines that it names."""
        return self.state == "done" and not self.missing

    @property
    def reasons(self) -> str:
        """Why the part is not whole; empty without a reason."""
        return "; ".join(filter(None, [self.reason, self.missing]))


class AlarmEntry(Entry):
    """Test of the alarm by planted faults."""

    planted: int
    missed: tuple[str, ...] = ()
    seed: int = 0
    false_alarms: tuple[str, ...] = ()


class NightRunEntry(Entry):
    """Parts of the plan that the night ran or left."""

    plan: str
    minutes: float
    turn: int
    parts: tuple[PartEntry, ...]
    alarm: AlarmEntry | None = None


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
    versions: dict[str, str] = Field(description="version of each engine's distribution and each library")
    exchanged: tuple[SuspectEntry, ...] = Field(
        (), description="parts that differ from the last night before, also where no figure changed"
    )


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
    standing: tuple[ChangeEntry, ...] = Field(description="earlier changes for the worse that still hold")
    held: tuple[ChangeEntry, ...] = Field(
        (), description="earlier changes for the worse that still hold and that somebody accepted"
    )
    renamed: tuple[str, ...] = Field((), description="settings and scenes that have other names since this night")
    run: NightRunEntry | None = Field(None, description="None of a night that a result folder was added as")

    @property
    def worse(self) -> bool:
        """Whether a figure is worse, since tonight or an earlier night, and nobody accepted the change."""
        return self.counts.worse > 0 or bool(self.standing)

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


def read_nightly(path: Path) -> NightlyFile:
    """Read a ``nightly.json``.

    Raises
    ------
    FileNotFoundError
        If there is none.
    DamagedResultsError
        If the file is something else.
    """
    try:
        return NightlyFile.model_validate_json(path.read_bytes())
    except ValidationError as error:
        first = error.errors()[0]
        raise damaged(path, f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from None
