"""Result folders in tests: their files, synthetic results, and tables read back."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.results.files import ANSWERS, RECORDS, SERIES
from reports.results.rows import FOLDER
from reports.results.schema import KEY, SCHEMA_VERSION
from reports.results.studies import STUDIES
from reports.results.writing import parquet

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from reports.results.files import StudyFiles

COMPARISON = "comparison"
FILES = {files.study: files for files in STUDIES}
MADE: dict[str, Any] = {
    "finished": True, "command": "barchain", "created": "2026-01-05T10:20:30+00:00", "seconds": 12.0,
    "environment": {"cpu": "Example CPU", "cores": 2}, "packages": {"numpy": "2"},
}  # fmt: skip
"""How a synthetic study was made, for its record"""


def record_file(folder: Path, study: str = COMPARISON) -> Path:
    """File of a study's record."""
    return folder / RECORDS / f"{study}.json"


def rows_file(folder: Path, study: str = COMPARISON) -> Path:
    """File of a study's rows."""
    return folder / FOLDER / f"{study}.parquet"


def series_folder(folder: Path, study: str = COMPARISON) -> Path:
    """Folder of a study's series."""
    return folder / SERIES / study


def answers_folder(folder: Path, study: str) -> Path:
    """Folder of what a study has run."""
    return folder / ANSWERS / study


def read_record(folder: Path, study: str = COMPARISON) -> dict[str, Any]:
    """A study's record."""
    found: dict[str, Any] = json.loads(record_file(folder, study).read_text(encoding="utf-8"))
    return found


def change_record(folder: Path, study: str = COMPARISON, **entries: Any) -> None:
    """Change entries of a record."""
    write_record(folder, read_record(folder, study) | entries, study)


def write_record(folder: Path, record: Mapping[str, Any], study: str = COMPARISON) -> None:
    """Write a record, of this version unless it says another."""
    path = record_file(folder, study)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({KEY: SCHEMA_VERSION} | dict(record)), encoding="utf-8")


def change_rows(folder: Path, change: Callable[[pd.DataFrame], pd.DataFrame], study: str = COMPARISON) -> None:
    """Change the rows of a study."""
    path = rows_file(folder, study)
    path.write_bytes(parquet(change(pd.read_parquet(path))))


def read_table(folder: Path, study: str = COMPARISON, table: str = "metrics") -> pd.DataFrame:
    """A table of a study's rows."""
    found: pd.DataFrame = FILES[study].contents(folder, table).tables[table]
    return found


def write_results(
    folder: Path,
    files: StudyFiles,
    tables: Mapping[str, Any],
    record: Mapping[str, Any],
    series: Mapping[str, pd.DataFrame] | None = None,
) -> Path:
    """Write a study's rows from some of its tables, and its record, which knows no digests.

    The study is complete unless the record says that it is not finished.
    """
    whole = {"complete": record.get("finished", True)} | dict(record)
    path = rows_file(folder, files.study)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(parquet(files.to_rows(tables, whole).frame()))
    for name, frame in (series or {}).items():
        place = folder / files.series_name(name)
        place.parent.mkdir(parents=True, exist_ok=True)
        frame.to_parquet(place, index=False)
    write_record(folder, whole, files.study)
    return folder
