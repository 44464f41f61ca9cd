"""Rows, record and series of one study in a result folder, written as results come.

An interruption leaves the results so far.
"""

from __future__ import annotations

import contextlib
import json
import shutil
import time
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.results.files import ANSWERS, RECORDS, SERIES
from reports.results.reading import TABLES, file_digest
from reports.results.rows import FOLDER, Rows, records
from reports.results.schema import KEY, SCHEMA_VERSION
from reports.results.writing import make_folder, named, parquet, replaced, sweep, write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from reports.results.files import StudyFiles
    from reports.results.rows import Row
    from reports.results.writing import DigestedFile

PARTS = "parts"
OF_A_PART = ("barchain", "command", "created", "environment", "packages", "seconds", "complete", "failed", "full")
"""Entries of a record that each part has of its own"""
REST = 20.0
"""Writing all rows waits this many times as long as it took the last time, so that it takes a twentieth of a study"""


class StudyStore:
    """Tables and record of one study; its ``summary`` has rows that follow from all results.

    The record holds the digest of each of its files. The digest of a file's next state joins that of its present state
    in the record before the file is written: at every instant each file in place is known to the record, and a file of
    another run is not.
    """

    def __init__(
        self, files: StudyFiles, out: Path, record: dict[str, Any] | None = None, *, resume: bool = False
    ) -> None:
        """Make the study's folders in the result folder `out`.

        Parameters
        ----------
        files : StudyFiles
        out : Path
        record : dict, optional
            The study fills it in; :meth:`write_record` writes it as it stands.
        resume : bool
            Whether the study goes on from what an earlier one left in the folder: the answers there are taken, and all
            rows and series, which follow from answers, are made anew. ``earlier`` is then the record of the earlier
            study.

        Raises
        ------
        DamagedResultsError, SchemaVersionError
            If the study goes on beside a record, or rows of other parts, that are damaged or of another version.
        """
        self.files, self.out, self.resume = files, out, resume
        self.record: dict[str, Any] = {KEY: SCHEMA_VERSION} if record is None else record
        self.record["study"] = files.study
        self.own = tuple(self.record.get(PARTS, ()))
        self.summary = Rows(files.study)
        self.tables: dict[str, list[Row]] = {}
        """Rows of each table so far"""
        self.next_write = 0.0
        self.earlier: dict[str, Any] = {}
        if (resume or files.parts) and files.has_record(out):
            self.earlier = files.read_record(out)
            self.keep_other_parts()
        for folder in (FOLDER, RECORDS):
            make_folder(out, folder)
            sweep(out / folder)
        self.folder = out / SERIES / files.study
        self.answers = make_folder(out, PurePath(ANSWERS, files.study))
        shutil.rmtree(self.folder, ignore_errors=True)
        known = self.earlier.get(TABLES, {})
        self.record[TABLES] = {name: known[name] for name in (files.rows_name,) if self.tables and name in known}
        if not self.tables:
            with named(out / files.rows_name):
                (out / files.rows_name).unlink(missing_ok=True)

    def keep_other_parts(self) -> None:
        """Take tables and provenance of the parts that this run leaves as they are."""
        if not self.files.parts:
            return
        others = {part: facts for part, facts in (self.earlier.get(PARTS) or {}).items() if part not in self.own}
        self.record[PARTS] = others | self.record[PARTS]
        names = [table for part in others for table in self.files.parts.get(part, ())]
        if names:
            tables = self.files.contents(self.out, *names).tables
            self.tables = {name: records(table) for name, table in tables.items()}

    def read(self, table: str) -> pd.DataFrame:
        """Table so far."""
        return self.files.tables[table].framed(self.tables.get(table, ()))

    def write(self, table: str, content: pd.DataFrame | Iterable[Row]) -> None:
        """Replace a table, and write all rows, if that was not done just now."""
        if table in self.files.series:
            frame = content if isinstance(content, pd.DataFrame) else pd.DataFrame(list(content))
            self.write_series(table, frame.reindex(columns=list(self.files.series[table] or frame.columns)))
            return
        self.tables[table] = records(content)
        if time.monotonic() >= self.next_write:
            start = time.monotonic()
            self.write_rows()
            self.next_write = time.monotonic() + REST * (time.monotonic() - start)

    def append(self, table: str, rows: Iterable[Row]) -> None:
        """Add rows to a table."""
        self.write(table, [*self.tables.get(table, ()), *rows])

    def write_rows(self, *, complete: bool = False) -> None:
        """Write the rows of all tables so far, and of the summary; `complete` if they are those of all results."""
        found = self.files.to_rows(self.tables, self.record | {"complete": complete})
        found.found += self.summary.found
        self.write_file(self.files.rows_name, parquet(found.frame()))

    def write_series(self, name: str, frame: pd.DataFrame) -> None:
        """Write a table over time as a Parquet file, and the record."""
        self.write_file(self.files.series_name(name), parquet(frame))

    def write_file(self, name: str, content: bytes) -> None:
        """Write a file whole, and the record; `name` is relative to the result folder."""
        with self.replacing(name) as file:
            file.write(content)

    @contextlib.contextmanager
    def replacing(self, name: str) -> Iterator[DigestedFile]:
        """File that takes its place when the context ends; the record then describes it."""
        make_folder(self.out, PurePath(name).parent)
        with replaced(self.out / name) as file:
            yield file
            self.announce(name, file.digest)

    def announce(self, name: str, following: str) -> None:
        """Write the record with the digest of a file's next state."""
        digests: dict[str, list[str]] = self.record[TABLES]
        known, path = digests.get(name, []), self.out / name
        present = file_digest(path) if known and path.is_file() else None
        digests[name] = list(dict.fromkeys([following, *(found for found in known if found == present)]))
        self.write_record()

    def write_record(self) -> None:
        """Write the record as it stands; each part of this run has its own provenance there."""
        if self.own:
            own = {key: self.record[key] for key in OF_A_PART if key in self.record}
            self.record[PARTS] |= dict.fromkeys(self.own, own)
        write_atomically(self.files.record_path(self.out), json.dumps(self.record, indent=1))

    def end(self, seconds: float, *, complete: bool) -> None:
        """Write the record with the wall time, s, and whether every result is there, and the rows."""
        self.record["seconds"] = seconds
        self.write_rows(complete=complete)
        self.record["complete"] = complete  # only now: a complete record lists no file that is missing
        self.write_record()

    def finish(self) -> None:
        """Write that all is done: every result is there, and its report is written."""
        self.record["finished"] = True
        self.write_record()
