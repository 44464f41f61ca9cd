"""The folder of a study, written as results come, so that an interrupted study leaves its results so far."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.tables.cells import to_cells
from reports.tables.reading import TABLES, DamagedResultsError, recorded_content
from reports.tables.schema import KEY, SCHEMA_VERSION, SchemaVersionError
from reports.tables.writing import RecordedFolder, make_folder, sweep

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from reports.tables.files import StudyFiles

Row = dict[str, Any]
RUNS, CARRIED = "runs", "carried"


class StudyStore:
    """Tables and record of one study."""

    def __init__(
        self, files: StudyFiles, out: Path, record: dict[str, Any] | None = None, *, resume: bool = False
    ) -> None:
        """Make the study's folder in the result folder `out`.

        Parameters
        ----------
        files : StudyFiles
        out : Path
        record : dict, optional
            The study fills it in; :meth:`write_record` writes it as it stands.
        resume : bool
            Whether the study continues from the tables in the folder; ``earlier`` is then the record beside them, and
            its tables and runs belong to the new record until they are replaced.

        Raises
        ------
        DamagedResultsError, SchemaVersionError
            If the study continues from a record or tables that are damaged or of another version.
        """
        self.files, self.out, self.resume = files, out, resume
        self.record: dict[str, Any] = {KEY: SCHEMA_VERSION} if record is None else record
        self.folder = make_folder(out, files.study)
        sweep(self.folder)
        self.earlier: dict[str, Any] = files.read_record(out) if resume and files.has_record(out) else {}
        if self.earlier:
            self.carry_over()
        elif files.joins:
            self.join_earlier()
        self.writer = RecordedFolder(self.folder, files.record, self.record)

    def carry_over(self) -> None:
        """Take tables, runs and unfinished lists of the earlier record into the new one."""
        if isinstance(self.record.get(RUNS), list):  # tables follow from a list of runs, and are made anew
            self.record[CARRIED] = [*self.earlier.get(CARRIED, []), *self.earlier.get(RUNS, [])]
            return
        for table in self.files.tables:
            if self.has(table):
                self.files.recorded(self.out, table, self.earlier)
        self.record |= {k: self.earlier[k] for k, v in self.record.items() if v in ([], {}) and k in self.earlier}
        known = self.earlier.get(TABLES)
        if known is not None:
            self.record[TABLES] = dict(known)

    def join_earlier(self) -> None:
        """Let sound tables of an earlier run of the study belong to the new record."""
        try:
            earlier = self.files.read_record(self.out)
        except (OSError, DamagedResultsError, SchemaVersionError):
            return
        known = earlier.get(TABLES) or {}
        self.record[TABLES] = {name: found for name, found in known.items() if self.sound(name, earlier)}

    def sound(self, name: str, record: dict[str, Any]) -> bool:
        """Whether a table is there as a record describes it."""
        try:
            return recorded_content(self.folder, name, record) is not None
        except (OSError, DamagedResultsError):
            return False

    def has(self, table: str) -> bool:
        """Whether a table was written."""
        return self.files.has(self.out, table)

    def read(self, table: str) -> pd.DataFrame:
        """Table as it stands in the folder."""
        return self.files.read(self.out, table)

    def frame(self, table: str, rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
        """Rows as a table with the declared columns in their order."""
        return pd.DataFrame(list(rows)).reindex(columns=list(self.files.tables[table]))

    def write(self, table: str, content: pd.DataFrame | Iterable[Mapping[str, Any]]) -> None:
        """Write a table whole, and the record."""
        frame = content if isinstance(content, pd.DataFrame) else self.frame(table, content)
        self.writer.write(self.files.path(self.out, table).name, to_cells(frame).to_csv(index=False).encode("utf-8"))

    def append(self, table: str, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows to the end of a table; the first rows bring the header."""
        frame = self.frame(table, rows)
        if not self.has(table):
            self.write(table, frame)
            return
        name = self.files.path(self.out, table).name
        self.writer.append(name, to_cells(frame).to_csv(index=False, header=False).encode("utf-8"))

    def remove(self, *tables: str) -> None:
        """Delete the tables that an earlier study left in the folder."""
        for table in tables:
            self.writer.remove(self.files.path(self.out, table).name)

    def write_record(self) -> None:
        """Write the record as it stands."""
        self.writer.write_record()

    def finish(self, seconds: float) -> None:
        """Write the record with the study's wall time, s."""
        self.record["seconds"] = seconds
        self.write_record()
