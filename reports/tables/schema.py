"""Version of the tables and records in a result folder, and the one reader of records."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

SCHEMA_VERSION = 2
"""Raised with every change of a stored column, key, file name or meaning that an older reader would misread"""
KEY = "schema_version"


class SchemaVersionError(ValueError):
    """Results whose record has no schema version, or another one than this barchain reads."""


def read_record(path: Path) -> dict[str, Any]:
    """Read the record of a study or a comparison.

    Parameters
    ----------
    path : Path
        JSON file, e.g. ``run.json``.

    Raises
    ------
    FileNotFoundError
        If the file is missing.
    json.JSONDecodeError
        If the file is not JSON.
    SchemaVersionError
        If the record has another schema version than :data:`SCHEMA_VERSION`, or none; the message is one line.
    """
    record: Any = json.loads(path.read_text(encoding="utf-8"))
    version = record.get(KEY) if isinstance(record, dict) else None
    if type(version) is not int or version != SCHEMA_VERSION:  # True == 1, and is no version
        raise SchemaVersionError(f"{path}: {found(version)}; {advice(record)}")
    return dict(record)


def found(version: object) -> str:
    """Schema version of a record in words."""
    return "no schema version" if version is None else f"schema version {version!r}"


def advice(record: object) -> str:
    """What this barchain reads, and what to do with results of another schema version."""
    writer = record.get("barchain") if isinstance(record, dict) else None
    writing = f"barchain {writer}, which wrote them" if writer else "the barchain that wrote them"
    return f"this barchain reads version {SCHEMA_VERSION}. Run the study again, or render its results with {writing}"
