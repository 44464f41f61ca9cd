"""What a study leaves in a result folder: its rows, its record, and its series over time.

``rows/<study>.parquet``
    every number, outcome and text (:mod:`reports.results.rows`);
``record/<study>.json``
    command, options, environment, versions, and the digest of each file of the study;
``series/<study>/``
    what is no row: samples, differences over time, quantiles;
``answers/<study>/``
    what has been run so far: a study that goes on makes what is missing.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from reports.results.reading import check_recorded, damaged, read_parquet, recorded
from reports.results.rows import COLUMNS, FOLDER, Rows, records, typed
from reports.results.schema import Record, read_record

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    import pandas as pd

    from reports.results.rows import Followed, Row
    from reports.results.table import Table

RECORDS, SERIES, ANSWERS = "record", "series", "answers"
"""Folders beside that of the rows"""
Lines = dict[str, list["Row"]]
"""Rows of tables, by the tables' names"""


class StudyTables:
    """Record of a study in a folder, and its tables, each an attribute of its name."""

    def __init__(self, folder: Path, tables: Mapping[str, pd.DataFrame], record: dict[str, Any], study: str) -> None:
        self.folder, self.tables, self.record, self.study = folder, tables, record, study

    def __getattr__(self, name: str) -> Any:
        """Table of a name."""
        if name.startswith("_") or name not in self.tables:
            raise AttributeError(name)
        return self.tables[name]

    def series(self, name: str) -> pd.DataFrame | None:
        """Series over time ``t_s`` of a name, or None without one."""
        file = f"{SERIES}/{self.study}/{name}.parquet"
        return read_parquet(self.folder / file, ("t_s",)) if recorded(self.folder, file, self.record) else None

    def trajectory(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Samples of one run, or None if it left none."""
        return self.series(f"trajectories/{scene}/{engine}")

    def differences(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Differences from the judging solution over time, or None without any."""
        return self.series(f"differences/{scene}/{engine}")


@dataclass(frozen=True, eq=False)
class StudyFiles:
    """Rows, record and series of a study in a result folder."""

    study: str
    tables: Mapping[str, Table] = field(default_factory=dict)
    """Tables that its rows are, by name"""
    series: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Tables that are no rows, with their columns: ``series/<study>/<table>.parquet``"""
    model: type[Record] = Record
    """Entries of the record with their types"""
    followed: Mapping[str, Followed] = field(default_factory=dict)
    """Metrics that nights follow; none of a study that is no part of a night"""
    add_derived: Callable[[Rows, Lines, Mapping[str, Any]], None] = lambda found, tables, record: None  # noqa: ARG005
    """Adds further rows, that follow from the tables and the record"""
    place: Callable[[Mapping[str, Any]], dict[str, str]] = lambda record: {}  # noqa: ARG005
    """Scene, engine and setting of all rows of the tables, by the record"""
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Tables of each part that can be run by itself, beside the tables of earlier runs of the others"""
    title: str = ""
    """Title of the study's page, heading of its chapter and entry in a report's navigation"""
    view: str = ""
    """Function ``module:name`` of :mod:`reports.chapters` that makes all that the chapter shows of a result folder;
    empty of a study without a page"""
    in_report: bool = False
    """Whether the report of a comparison in the same folder includes the chapter"""
    report: tuple[str, ...] = ()
    """Files that are rendered instead of a page of the study's name"""

    @property
    def pages(self) -> tuple[str, ...]:
        """Files in the result folder that are rendered from the rows."""
        return (f"{self.study}.html",) if self.view else self.report

    @property
    def rows_name(self) -> str:
        """File of the rows, relative to the result folder."""
        return f"{FOLDER}/{self.study}.parquet"

    def series_name(self, table: str) -> str:
        """File of a table over time, relative to the result folder."""
        return f"{SERIES}/{self.study}/{table}.parquet"

    def record_path(self, out: Path) -> Path:
        """File of the record."""
        return out / RECORDS / f"{self.study}.json"

    def has_record(self, out: Path) -> bool:
        """Whether there is a record, damaged or not."""
        return os.path.lexists(self.record_path(out))

    def to_rows(self, tables: Mapping[str, Iterable[Row] | pd.DataFrame], record: Mapping[str, Any]) -> Rows:
        """Rows of some tables, and those that follow from them."""
        found, place = Rows(self.study), self.place(record)
        order = sorted(tables, key=[*self.tables].index)
        lines = {name: self.tables[name].lines(tables[name]) for name in order}
        for name, own in lines.items():
            self.tables[name].add_rows(found, own, place)
        self.add_derived(found, lines, record)
        return found

    def rows(self, out: Path, record: Mapping[str, Any] | None = None) -> pd.DataFrame:
        """Rows in the result folder `out`, in the columns of :mod:`reports.results.rows`.

        Raises
        ------
        FileNotFoundError
            If they, or the record, are missing.
        DamagedResultsError
            If they or the record are damaged, or they are others than the record describes.
        SchemaVersionError
            If the record has another schema version.
        """
        known, path = self.sound_record(out) if record is None else record, out / self.rows_name
        if recorded(out, self.rows_name, known):
            return typed(read_parquet(path, COLUMNS))
        if os.path.lexists(path):
            raise damaged(path, "is left from another run than the record's")
        raise FileNotFoundError(f"{out}: no {self.rows_name} there; give a folder with results")

    def contents(self, out: Path, *tables: str) -> StudyTables:
        """Read the record and several tables, all of them by default; errors as of :meth:`rows`."""
        import pandas as pd

        record = self.sound_record(out)
        wanted = tables or (*self.tables, *self.series)
        rows = records(self.rows(out, record))
        found = {name: self.tables[name].from_rows(rows) for name in wanted if name in self.tables}
        for name in (name for name in wanted if name in self.series):
            file, needed = self.series_name(name), self.series[name]
            there = recorded(out, file, record)
            found[name] = read_parquet(out / file, needed) if there else pd.DataFrame(columns=list(needed))
        return StudyTables(out, found, record, self.study)

    def read_record(self, out: Path) -> dict[str, Any]:
        """Read the record.

        Raises
        ------
        FileNotFoundError
            If there is none.
        DamagedResultsError
            If it is damaged, or that of another study.
        SchemaVersionError
            If the record has another schema version.
        """
        path = self.record_path(out)
        record = read_record(path, self.model)
        if record.get("study") not in (None, self.study):
            raise damaged(path, f"is the record of another study, {record['study'][:40]}, not {self.study}")
        return record

    def sound_record(self, out: Path) -> dict[str, Any]:
        """Read the record, and check that each of its files is the one that it describes, shown or not.

        Errors are those of :meth:`read_record`.
        """
        record = self.read_record(out)
        check_recorded(out, record)
        return record
