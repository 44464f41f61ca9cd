"""Version and form of the records in a result folder, and the one reader of records."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError

from reports.results.outcome import Outcome
from reports.results.reading import brief, damaged, read_json

if TYPE_CHECKING:
    from pathlib import Path

SCHEMA_VERSION = 3
"""Raised with every change of a stored column, key, file name or meaning that an older reader would misread"""
KEY = "schema_version"
Facts = dict[str, dict[str, Any]]
"""What a record tells of each scene, engine or fault"""


class SchemaVersionError(ValueError):
    """Results whose record has no schema version, or another one than this barchain reads."""


def known_outcome(word: str) -> str:
    """Check that a word is an outcome."""
    if word not in set(Outcome):
        raise ValueError(f"{word[:40]!r} is no outcome")
    return word


class Part(BaseModel):
    """Part of a record: the declared entries have their types, and further ones are kept."""

    model_config = ConfigDict(strict=True, extra="allow")


class RunEntry(Part):
    """Entry of a run."""

    scene: str
    engine: str
    setting: str
    role: str
    outcome: Annotated[str, AfterValidator(known_outcome)]
    reason: str = ""
    seconds: dict[str, float] = {}
    info: dict[str, Any] = {}
    file: str | None = None
    digest: str | None = None
    rejected: bool = False


class StudyPart(Part):
    """Provenance of a part of a study that is run by itself."""

    command: str | None = None
    created: str | None = None
    complete: bool = False
    seconds: float | None = None
    failed: list[dict[str, Any]] | None = None


class Record(Part):
    """Entries that every record may have, also that of a study of one's own."""

    schema_version: int
    barchain: str | None = None
    created: str | None = None
    study: str | None = None
    complete: bool = False
    """Whether every result is there"""
    finished: bool = False
    """Whether every result is there, and the report is written"""
    command: str | None = None
    seconds: float | None = None
    environment: dict[str, str | float | None] = {}
    packages: dict[str, str | None] = {}
    tables: dict[str, list[str]] | None = None


class StudyRecord(Record):
    """Entries that the records of barchain's studies may have."""

    scene: dict[str, Any] | str | None = None
    scenes: Facts | int | None = None
    engines: Facts | dict[str, str] | list[str] | None = None
    faults: Facts | None = None
    parts: dict[str, StudyPart] | None = None
    """Parts that are run together or one by one"""
    failed: list[dict[str, Any]] | None = None
    left_out: list[dict[str, Any]] | list[list[str]] | None = None
    misprints: list[dict[str, Any]] | None = None
    tolerances: list[dict[str, Any]] | None = None
    limitations: list[str] | None = None
    certified_solutions: Facts | None = None
    shortened_limits_s: dict[str, float] | None = None
    """Limit of a run in the scenes where half of the time was used before all was run"""
    other_processors: float | None = None
    """Mean number of processors that other processes used while times were measured"""
    targets: list[dict[str, Any]] | None = None
    unit_roundoff: dict[str, float] | None = None
    objects: list[dict[str, Any]] | None = None
    references: list[str] | None = None
    hosts: list[str] | None = None
    vary: list[str] | None = None
    outcomes: dict[str, int] | None = None
    phases_s: dict[str, float] | None = None


class RunsRecord(StudyRecord):
    """Record of a study that keeps its runs."""

    runs: list[RunEntry] = []


def read_record(path: Path, model: type[Record] = Record) -> dict[str, Any]:
    """Read the record of a study or a comparison.

    Parameters
    ----------
    path : Path
        JSON file, e.g. ``record/cost.json``.
    model : type of Record
        Entries with their types.

    Raises
    ------
    FileNotFoundError
        If the file is missing.
    DamagedResultsError
        If the file is no JSON, or an entry has a wrong type; the message is one line.
    SchemaVersionError
        If the record has another schema version than :data:`SCHEMA_VERSION`, or none; the message is one line.
    """
    record = read_json(path)
    version = record.get(KEY) if isinstance(record, dict) else None
    if type(version) is not int or version != SCHEMA_VERSION:  # True == 1, and is no version
        found = "no schema version" if version is None else f"schema version {brief(repr(version))[:40]}"
        writer = record.get("barchain") if isinstance(record, dict) else None
        writing = f"barchain {brief(writer)[:40]}, which wrote them" if writer else "the barchain that wrote them"
        raise SchemaVersionError(
            f"{path}: {found}; this barchain reads version {SCHEMA_VERSION}. Run the study again, or render its "
            f"results with {writing}"
        )
    try:
        model.model_validate(record)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False, include_context=False)[0]
        place = " → ".join(str(part) for part in first["loc"] if "[" not in str(part))  # without types of a union
        raise damaged(path, f"entry {brief(place)[:120]} is wrong: {brief(first['msg'])[:120]}") from None
    return dict(record)
