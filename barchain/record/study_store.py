"""The folder of a comparison or a study, written as results come: an interruption leaves the results so far."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.tables.measured import rows_content, rows_name
from reports.tables.reading import TABLES, check_recorded
from reports.tables.rows import Rows
from reports.tables.schema import KEY, RECORD, SCHEMA_VERSION
from reports.tables.writing import RecordedFolder, make_folder, sweep

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from reports.tables.files import StudyFiles

Row = dict[str, Any]
PARTS = "parts"
OF_A_PART = ("barchain", "command", "created", "environment", "packages", "seconds", "complete", "failed", "full")
"""Entries of a record that each part has of its own"""


class StudyStore:
    """Tables and record of one study, or of a comparison; its ``summary`` has rows that follow from all results."""

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
            Whether the study goes on from what an earlier one left in the folder: the answers there are taken, and all
            tables, which follow from answers, are made anew. ``earlier`` is then the record of the earlier study.

        Raises
        ------
        DamagedResultsError, SchemaVersionError
            If the study goes on beside a record, or tables of other parts, that are damaged or of another version.
        """
        self.files, self.out, self.resume = files, out, resume
        self.record: dict[str, Any] = {KEY: SCHEMA_VERSION} if record is None else record
        self.record["study"] = files.name
        self.earlier = self.earlier_record()
        self.summary = Rows(files.name)
        self.own = tuple(self.record.get(PARTS, ()))
        self.folder = make_folder(out, files.study)
        self.writer = RecordedFolder(self.folder, RECORD, self.record)
        if files.parts and self.earlier:
            self.keep_other_parts()
        elif not files.keeps_answers:
            self.record[TABLES] = dict(self.earlier.get(TABLES) or {})
        elif resume:
            self.remove(*files.tables)
            for name in files.folders:
                shutil.rmtree(self.folder / name, ignore_errors=True)
        for name in files.folders:
            make_folder(self.folder, name)
        sweep(self.folder)
        if record is not None:
            self.record.setdefault(TABLES, {})
            self.writer.remove(rows_name(files))  # an earlier study's: this one writes its own at its end

    def earlier_record(self) -> dict[str, Any]:
        """Record of the study that this one goes on from, or whose other parts stay; empty without one."""
        goes_on = self.resume or bool(self.files.parts)
        return self.files.read_record(self.out) if goes_on and self.files.has_record(self.out) else {}

    def keep_other_parts(self) -> None:
        """Take tables and provenance of the parts that this run leaves as they are."""
        others = {part: facts for part, facts in (self.earlier.get(PARTS) or {}).items() if part not in self.own}
        tables = [self.files.path(self.out, table).name for part in others for table in self.files.parts.get(part, ())]
        known = self.earlier.get(TABLES) or {}
        for name in tables:
            check_recorded(self.files.folder(self.out), name, self.earlier)
        self.record[PARTS] = others | self.record[PARTS]
        self.record[TABLES] = {name: known[name] for name in tables if name in known}

    def note_parts(self) -> None:
        """Give each part of this run its own provenance."""
        own = {key: self.record[key] for key in OF_A_PART if key in self.record}
        self.record[PARTS] |= dict.fromkeys(self.own, own)

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
        self.writer.write(self.files.path(self.out, table).name, frame.to_csv(index=False).encode("utf-8"))

    def write_text(self, table: str, parts: Iterable[bytes]) -> None:
        """Write a table whole from parts of its text, which are not held at once, and the record."""
        with self.writer.replacing(self.files.path(self.out, table).name) as file:
            for part in parts:
                file.write(part)

    def append(self, table: str, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows to the end of a table; the first rows bring the header."""
        frame = self.frame(table, rows)
        if not self.has(table):
            self.write(table, frame)
            return
        name = self.files.path(self.out, table).name
        self.writer.append(name, frame.to_csv(index=False, header=False).encode("utf-8"))

    def remove(self, *tables: str) -> None:
        """Delete the tables that an earlier study left in the folder."""
        for table in tables:
            self.writer.remove(self.files.path(self.out, table).name)

    def write_record(self) -> None:
        """Write the record as it stands."""
        if self.own:
            self.note_parts()
        self.writer.write_record()

    def end(self, seconds: float, *, complete: bool) -> None:
        """Write the record with the wall time, s, and whether every result is there; if it is, the rows too."""
        self.record |= {"seconds": seconds, "complete": complete}
        self.write_record()
        if complete:  # a complete record lists no file that is missing: it is none while the rows are written
            self.record["complete"] = False
            self.writer.write(rows_name(self.files), rows_content(self.files, self.out, self.summary.found))
            self.record["complete"] = True
            self.write_record()

    def finish(self) -> None:
        """Write that all is done: every result is there, and its report is written."""
        self.record["finished"] = True
        self.write_record()
