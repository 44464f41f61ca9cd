"""The files of a study inside a result folder: names, columns, and reading them."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from reports.tables.reading import TABLES, check_recorded, damaged, read_csv, recorded_content, recorded_parquet
from reports.tables.schema import RECORD, Record, read_record

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy as np
    import pandas as pd
    from numpy.typing import NDArray


ANSWERS = "answers"
"""Folder of the kept answers inside a study's folder"""


class StudyTables:
    """Record of a study in a folder, and its tables, each an attribute of its name."""

    def __init__(self, folder: Path, tables: Mapping[str, pd.DataFrame], record: dict[str, Any]) -> None:
        self.folder, self.tables, self.record = folder, tables, record

    def __getattr__(self, name: str) -> Any:
        """Table of a name."""
        if name.startswith("_") or name not in self.tables:
            raise AttributeError(name)
        return self.tables[name]

    def trajectory(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Samples of one run, or None if it left none."""
        return recorded_parquet(self.folder, f"trajectories/{scene}/{engine}.parquet", self.record)

    def differences(self, scene: str, engine: str) -> pd.DataFrame | None:
        """Differences from the judging solution over time, or None without any."""
        return recorded_parquet(self.folder, f"differences/{scene}/{engine}.parquet", self.record)


@dataclass(frozen=True)
class StudyFiles:
    """Tables and record of a study, in the folder ``<study>`` of a result folder; of a comparison in that itself."""

    study: str
    """Empty for a comparison"""
    tables: Mapping[str, tuple[str, ...]]
    """Columns of each ``<table>.csv``; empty where the columns follow from the data"""
    words: tuple[str, ...] = ()
    """Columns of text: an empty cell is an empty string; in other columns an empty cell is NaN"""
    optional: frozenset[str] = field(default_factory=frozenset)
    """Tables that a study may lack; reading such a table gives no rows"""
    flags: tuple[str, ...] = ()
    """Columns of True and False"""
    model: type[Record] = Record
    """Entries of the record with their types"""
    parts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Tables of each part that can be run by itself, beside the tables of earlier runs of the others"""
    folders: tuple[str, ...] = ()
    """Folders beside the tables"""
    pages: tuple[str, ...] = ()
    """Files in the result folder that are rendered from the tables"""

    @property
    def name(self) -> str:
        """Name of the study in its record."""
        return self.study or "comparison"

    def folder(self, out: Path) -> Path:
        """Folder of the study in the result folder `out`."""
        return out / self.study

    def path(self, out: Path, table: str) -> Path:
        """File of a table."""
        return self.folder(out) / f"{table}.csv"

    def has(self, out: Path, table: str) -> bool:
        """Whether a table was written."""
        return self.path(out, table).is_file()

    def record_path(self, out: Path) -> Path:
        """File of the record."""
        return self.folder(out) / RECORD

    def has_record(self, out: Path) -> bool:
        """Whether there is a record, damaged or not."""
        return os.path.lexists(self.record_path(out))

    def read(self, out: Path, table: str) -> pd.DataFrame:
        """Read a table.

        Raises
        ------
        FileNotFoundError
            If the table is missing and not optional.
        DamagedResultsError
            If the table or the record is damaged, or the table is another than the record describes.
        """
        return self.recorded(out, table, self.read_record(out) if self.has_record(out) else {})

    def recorded(self, out: Path, table: str, record: Mapping[str, Any]) -> pd.DataFrame:
        """Read a table that belongs to a record, as :meth:`read`; a table left from another run counts as missing."""
        import pandas as pd

        path, needed = self.path(out, table), table not in self.optional
        content = recorded_content(self.folder(out), path.name, record, needed=needed)
        if content is None:
            return pd.DataFrame(columns=list(self.tables[table]))
        return read_csv(path, content, self.tables[table], words=self.words, flags=self.flags)

    def contents(self, out: Path, *tables: str) -> StudyTables:
        """Read the record and several tables, all of them by default.

        Raises
        ------
        FileNotFoundError
            If the record is missing, or a table that is not optional.
        DamagedResultsError
            If the record or a table is damaged, or a table is another than the record describes.
        SchemaVersionError
            If the record has another schema version.
        """
        record = self.sound_record(out)
        found = {name: self.recorded(out, name, record) for name in tables or self.tables}
        return StudyTables(self.folder(out), found, record)

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
        if record.get("study") not in (None, self.name):
            raise damaged(path, f"is the record of another study, {record['study'][:40]}, not {self.name}")
        return record

    def sound_record(self, out: Path) -> dict[str, Any]:
        """Read the record, and check that each of its tables is the one that it describes, shown or not.

        Errors are those of :meth:`read_record`.
        """
        record = self.read_record(out)
        for name in record.get(TABLES) or ():
            check_recorded(self.folder(out), name, record)
        return record


def flags(column: pd.Series) -> NDArray[np.bool_]:
    """Flags (n,) of a column that is stored as the words True and False."""
    found: NDArray[np.bool_] = (column.astype(str) == "True").to_numpy(bool)
    return found
