"""Plan of a night: a TOML file that names studies, their scenes and engines, and their shares of the time."""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field, ValidationError, field_validator, model_validator

from adapters.registry import engines, find_engine
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.figure import content_digest
from barchain.runs.choices import choose_setting
from reports.results.cost import BASELINE
from scenarios.named_file import UnreadableError
from scenarios.size_limits import LimitError
from scenarios.text import visible
from scenarios.toml.effect_tables import Positive, Table
from scenarios.toml.faults import fault_lines
from scenarios.toml.reading import read_text, tables_of
from scenarios.toml.scene_tables import words

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

MOST_NAME, MOST_PARTS, MOST_NAMES = 40, 20, 500
LEAST_MINUTES, MOST_MINUTES = 0.5, 1440.0
"""Half a minute holds the start, one job, and the end"""
MOST_BARS = 1000
LOGS = "logs"
"""Folder of the logs of a night's parts"""
NAMED = r"^[a-z0-9][a-z0-9-]*$"
DEFAULT_MINUTES = 15.0


PartName = Annotated[str, Field(pattern=NAMED, max_length=MOST_NAME)]
Words = Annotated[str, words(200)]
Names = Annotated[tuple[Words, ...], Field(max_length=MOST_NAMES, strict=False)]
Settings = dict[Words, dict[Words, float]]


class PlanError(HistoryError):
    """Raised for a plan that can't be read or met; the message has one line for each fault."""


def default_engines() -> tuple[str, ...]:
    """Engines that a command without names takes; engines that only studies need would take most of a night."""
    return tuple(name for name, registration in engines().items() if registration.by_default)


def checked_engines(names: Sequence[str]) -> Sequence[str]:
    """Names of engines that are installed; all names if none is, so that the command tells how to install them.

    Raises
    ------
    UnknownEngineError
        If one is none.
    """
    missing = missing_engines(names)
    return [name for name in names if name not in missing] or names


def missing_engines(names: Sequence[str]) -> dict[str, str]:
    """Engines that are not installed, each with the reason.

    Raises
    ------
    UnknownEngineError
        If a name is none.
    """
    reasons = {name: find_engine(name).missing for name in names}
    return {name: reason for name, reason in reasons.items() if reason}


def each(option: str, values: Iterable[str]) -> tuple[str, ...]:
    """An option that is given once for each value."""
    return tuple(word for value in values for word in (option, value))


class PartTable(Table):
    """Part of a plan: one study on some scenes."""

    study: ClassVar[str]
    """Name of the study"""
    scenes_of_study: ClassVar[tuple[str, ...]] = ()
    """Patterns of scenes where a plan names none"""

    name: PartName = Field(description="name of the part and of its folder; small letters, digits and hyphens")
    share: Positive = Field(1.0, description="share of the night's time, relative to the shares of the other parts")

    @field_validator("name")
    @classmethod
    def folder_of_its_own(cls, name: str) -> str:
        """Reject the name of the folder beside the parts' folders."""
        if name == LOGS:
            raise ValueError(f"{name!r} given, which is the folder of the night's logs; allowed: another name")
        return name

    def command(self, turn: int, /) -> tuple[tuple[str, ...], int]:
        """Command and options of the part on a night, and the number of its items other than scenes: faults."""
        raise NotImplementedError

    @property
    def named_engines(self) -> tuple[str, ...]:
        """Engines that the part names."""
        return tuple(getattr(self, "engines", ()))

    @field_validator("scenes", "engines", check_fields=False)
    @classmethod
    def some(cls, names: object) -> object:
        """Reject an empty list, which would mean the default, and not nothing."""
        if names == ():
            raise ValueError("an empty list given; allowed: names, or no such key for the default")
        return names


class ScenesTable(PartTable):
    """Part that runs engines on scenes."""

    scenes: Names = Field((), description="names, patterns such as paper/*, or files beside the plan; default: the "
                                          "study's own")  # fmt: skip
    engines: Names = Field((), description="names of engines; default: those that the study's command takes, for "
                                           "times the default engines")  # fmt: skip
    nights: int = Field(1, ge=1, le=365, description="divide the scenes among this many nights")

    time_limit_s: Positive | None = Field(None, description="longest run, s; default: the command's own")

    @property
    def limit(self) -> tuple[str, ...]:
        """Option of the longest run."""
        return () if self.time_limit_s is None else ("--time-limit", repr(self.time_limit_s))


class ComparisonTable(ScenesTable):
    """Comparison of engines with the judging solutions: errors, verdicts, counts, bits of the trajectories."""

    study = "comparison"
    scenes_of_study = ("paper/*", "basics/*")

    settings: Settings = Field({}, description="accuracy by engine, e.g. exudyn = { steps_per_orbit = 2000 }")

    def command(self, _turn: int, /) -> tuple[tuple[str, ...], int]:
        """`barchain compare` with the part's engines and settings."""
        chosen = each("--engine", checked_engines(self.engines or default_engines()))
        settings = []
        for engine, given in self.settings.items():
            if engine not in missing_engines(self.engines):
                choose_setting(engine, given)
                pairs = ((key, int(value) if value.is_integer() else value) for key, value in given.items())
                settings += [f"{engine}:{key}={value!r}" for key, value in pairs]
        return ("compare", *chosen, *each("--set", settings), *self.limit), 0

    @model_validator(mode="after")
    def settings_of_its_engines(self) -> ComparisonTable:
        """Reject settings of engines that the part does not run."""
        others = [name for name in self.settings if self.engines and name not in self.engines]
        if others:
            raise ValueError(
                f"settings of {', '.join(others)} given, allowed: engines of the part, {', '.join(self.engines)}"
            )
        return self


class CostTable(ScenesTable):
    """Times at equal error, as ratios to an anchor."""

    study = "cost"
    scenes_of_study = ("paper/*",)

    orbits: Positive | None = Field(None, description="orbits of each scene; default: the command's own")
    repeats: int | None = Field(None, ge=1, le=1000, description="times that each point is measured")

    def command(self, _turn: int, /) -> tuple[tuple[str, ...], int]:
        """`barchain cost`, with the engine that times are relative to; its budget is added when the job begins."""
        names = tuple(dict.fromkeys((*(self.engines or default_engines()), BASELINE)))
        orbits = () if self.orbits is None else ("--orbits", repr(self.orbits))
        repeats = () if self.repeats is None else ("--repeats", str(self.repeats))
        return ("cost", *each("--engine", checked_engines(names)), *orbits, *repeats, *self.limit), 0


class ScalingTable(PartTable):
    """Peak memory, and the time of an evaluation, of a chain cut into bars."""

    study = "scaling"

    engines: Names = Field((), description="names of engines; default: the default engines")
    bars: tuple[Annotated[int, Field(ge=2, le=MOST_BARS)], ...] = Field(
        (20,), strict=False, min_length=1, description="numbers of bars"
    )

    def command(self, _turn: int, /) -> tuple[tuple[str, ...], int]:
        """`barchain scaling`; its budget is added when the job begins."""
        names = checked_engines(self.engines or default_engines())
        return ("scaling", *each("--engine", names), *each("--bars", map(str, self.bars))), 0


class StabilityTable(ScenesTable):
    """Stability of engines on hard scenes."""

    study = "stability"
    scenes_of_study = ("hard/*",)

    def command(self, _turn: int, /) -> tuple[tuple[str, ...], int]:
        """`barchain stability`."""
        return ("stability", *each("--engine", checked_engines(self.engines)), *self.limit), 0


class RoundoffTable(PartTable):
    """Round-off in relative and absolute coordinates."""

    study = "roundoff"

    parts: Names = Field(("evaluation",), description="parts of the study: evaluation, trajectories, engines, times")
    sizes: tuple[Positive, ...] = Field(
        (), strict=False, description="sizes of one evaluation: a bar's length over the Earth's radius, powers of ten"
    )

    def command(self, _turn: int, /) -> tuple[tuple[str, ...], int]:
        """`barchain roundoff` of some sizes."""
        from barchain.studies.roundoff.study import PARTS, check_sizes  # noqa: PLC0415

        for name in self.parts:
            if name not in PARTS:
                raise PlanError(f"parts: {name!r} given, allowed: {', '.join(PARTS)}")
        try:
            check_sizes(self.sizes)
        except ValueError as error:
            raise PlanError(f"sizes: {error}") from None
        return ("roundoff", *each("--part", self.parts), *each("--size", map(repr, self.sizes))), 0


class SelftestTable(PartTable):
    """Planted faults: a night that misses one is void."""

    study = "selftest"

    faults: int = Field(
        20, ge=1, le=1000, description="number of faults, other ones each night until all had their turn"
    )
    seed: int = Field(0, ge=0, le=2**62, description="of the order in which faults take their turns")
    scenes: Names = Field((), description="scenes that faults are inserted in; default: those of the command")

    def command(self, turn: int, /) -> tuple[tuple[str, ...], int]:
        """`barchain selftest` of this night's faults."""
        from barchain.studies.selftest.faults.catalogue import FIXED_SCENES  # noqa: PLC0415

        faults = self.tonights(FIXED_SCENES, turn)
        return ("selftest", *each("--fault", faults), *self.scenes), len(faults)

    def tonights(self, known: Iterable[str], turn: int) -> tuple[str, ...]:
        """Faults of one night: the next ones in an order that the seed draws, from the beginning again at its end."""
        order = sorted(known)
        random.Random(self.seed).shuffle(order)
        count = min(self.faults, len(order))
        return tuple(order[(turn * count + k) % len(order)] for k in range(count))


class PlanFile(Table):
    """Plan of a night."""

    name: PartName = Field(description="name of the plan")
    minutes: float = Field(
        DEFAULT_MINUTES,
        ge=LEAST_MINUTES,
        le=MOST_MINUTES,
        description="wall time of a night, minutes; --minutes overrides it",
    )
    selftest: list[SelftestTable] = Field([], max_length=MOST_PARTS, description="planted faults; done first")
    comparison: list[ComparisonTable] = Field([], max_length=MOST_PARTS, description="engines against solutions")
    cost: list[CostTable] = Field([], max_length=MOST_PARTS, description="times at equal error")
    scaling: list[ScalingTable] = Field([], max_length=MOST_PARTS, description="peak memory")
    stability: list[StabilityTable] = Field([], max_length=MOST_PARTS, description="hard scenes")
    roundoff: list[RoundoffTable] = Field([], max_length=MOST_PARTS, description="round-off")

    @property
    def parts(self) -> tuple[PartTable, ...]:
        """All parts, planted faults first: the alarm is tried before it is trusted."""
        timed = (*self.cost, *self.scaling)
        return (*self.selftest, *self.comparison, *timed, *self.stability, *self.roundoff)

    @model_validator(mode="after")
    def different_names(self) -> PlanFile:
        """Reject plans without parts, and parts of the same name."""
        names = [part.name for part in self.parts]
        if not names:
            raise ValueError("the plan has no parts; write e.g. [[comparison]] with a name")
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"parts named {', '.join(twice)} given more than once, allowed: a name of its own each")
        return self


CAMPAIGN = "campaign"
"""Part of plans of 0.7: random scenes"""
SHIPPED = Path(__file__).with_name("default.toml")
DIGITS = 8


@dataclass(frozen=True)
class NightPlan:
    """Plan with the place of its file: files of scenes are looked for beside it."""

    file: PlanFile
    folder: Path
    shown: str = "plan"
    """Name of the file in messages"""

    @property
    def identity(self) -> str:
        """Name and digest of the content: nights of the same plan are expected to have the same figures.

        A plan is the same as in 0.7, where it could have random scenes.
        """
        content = self.file.model_dump(mode="json", exclude={"minutes"}) | {CAMPAIGN: []}
        return f"{self.file.name} {content_digest(content)[:DIGITS]}"


def load_plan(path: Path | None = None) -> NightPlan:
    """Plan of a file; the one that comes with barchain by default.

    Raises
    ------
    PlanError
        If the file can't be read or is no plan.
    """
    path = path or SHIPPED
    shown = visible(path) if path != SHIPPED else path.name
    try:
        tables = tables_of(read_text(path))
        if CAMPAIGN in tables:
            raise PlanError(
                f"{shown}: [[{CAMPAIGN}]] given, which is no part of a night any more: leave it out, and run "
                "`python benchmarks/random_scenes.py N --seed K` of barchain's sources, a benchmark of random scenes"
            )
        file = PlanFile.model_validate(tables)
    except ValidationError as error:
        raise PlanError("\n".join(f"{shown}: {line}" for line in fault_lines(error, PlanFile))) from None
    except (LimitError, UnreadableError) as error:
        raise PlanError(f"{shown}: {error}") from None
    return NightPlan(file, path.parent, shown)
