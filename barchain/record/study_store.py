"""The folder of a comparison or a study, written as results come: an interruption leaves the results so far."""

from __future__ import annotations

import contextlib
import json
import shutil
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.tables.measured import rows_content, rows_name
from reports.tables.reading import TABLES, check_recorded, file_digest
from reports.tables.rows import Rows
from reports.tables.schema import KEY, RECORD, SCHEMA_VERSION
from reports.tables.writing import make_folder, named, parquet, replaced, sweep, write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from pathlib import Path

    from reports.tables.files import StudyFiles
    from reports.tables.writing import DigestedFile

Row = dict[str, Any]
PARTS = "parts"
OF_A_PART = ("barchain", "command", "created", "environment", "packages", "seconds", "complete", "failed", "full")
"""Entries of a record that each part has of its own"""


class StudyStore:
    """Tables and record of one study, or of a comparison; its ``summary`` has rows that follow from all results.

    The record holds the digest of each of its files. The digest of a file's next state joins that of its present state
    in the record before the file is written: at every instant each file in place is known to the record, and a file of
    another run is not.
    """

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
        goes_on = (resume or bool(files.parts)) and files.has_record(out)
        self.earlier = files.read_record(out) if goes_on else {}
        self.summary = Rows(files.name)
        self.own = tuple(self.record.get(PARTS, ()))
        self.folder = make_folder(out, files.study)
        self.appended: dict[str, list[Mapping[str, Any]]] = {}
        if files.parts and self.earlier:
            self.keep_other_parts()
        elif resume:
            self.remove(*files.tables)
            for name in files.folders:
                shutil.rmtree(self.folder / name, ignore_errors=True)
        for name in files.folders:
            make_folder(self.folder, name)
        sweep(self.folder)
        if record is not None:
            self.record.setdefault(TABLES, {})
            self.remove_file(rows_name(files))  # an earlier study's: this one writes its own at its end

    def keep_other_parts(self) -> None:
        """Take tables and provenance of the parts that this run leaves as they are."""
        others = {part: facts for part, facts in (self.earlier.get(PARTS) or {}).items() if part not in self.own}
        tables = [self.files.path(self.out, table).name for part in others for table in self.files.parts.get(part, ())]
        known = self.earlier.get(TABLES) or {}
        for name in tables:
            check_recorded(self.files.folder(self.out), name, self.earlier)
        self.record[PARTS] = others | self.record[PARTS]
        self.record[TABLES] = {name: known[name] for name in tables if name in known}

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
        self.write_file(self.files.path(self.out, table).name, frame.to_csv(index=False).encode("utf-8"))

    def append(self, table: str, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows to those that were appended to a table before, and write it whole."""
        own = self.appended.setdefault(table, [])
        own += rows
        self.write(table, own)

    def write_series(self, name: str, frame: pd.DataFrame) -> None:
        """Write a table over time as a Parquet file, and the record."""
        self.write_file(name, parquet(frame))

    def write_file(self, name: str, content: bytes) -> None:
        """Write a file whole, and the record; `name` is relative to the study's folder."""
        with self.replacing(name) as file:
            file.write(content)

    def write_text(self, table: str, parts: Iterable[bytes]) -> None:
        """Write a table whole from parts of its text, which are not held at once, and the record."""
        with self.replacing(self.files.path(self.out, table).name) as file:
            for part in parts:
                file.write(part)

    @contextlib.contextmanager
    def replacing(self, name: str) -> Iterator[DigestedFile]:
        """File that takes its place when the context ends; the record then describes it."""
        make_folder(self.folder, PurePath(name).parent)
        with replaced(self.folder / name) as file:
            yield file
            self.announce(name, file.digest)

    @property
    def digests(self) -> dict[str, list[str]]:
        """Digests of each file: of its next state, then of its present one."""
        found: dict[str, list[str]] = self.record.setdefault(TABLES, {})
        return found

    def announce(self, name: str, following: str) -> None:
        """Write the record with the digest of a file's next state."""
        known, path = self.digests.get(name, []), self.folder / name
        present = file_digest(path) if known and path.is_file() else None
        self.digests[name] = list(dict.fromkeys([following, *(found for found in known if found == present)]))
        self.write_record()

    def remove(self, *tables: str) -> None:
        """Delete the tables that an earlier study left in the folder."""
        for table in tables:
            self.remove_file(self.files.path(self.out, table).name)

    def remove_file(self, name: str) -> None:
        """Delete a file if it is there."""
        path = self.folder / name
        with named(path):
            path.unlink(missing_ok=True)
        self.digests.pop(name, None)

    def write_record(self) -> None:
        """Write the record as it stands; each part of this run has its own provenance there."""
        if self.own:
            own = {key: self.record[key] for key in OF_A_PART if key in self.record}
            self.record[PARTS] |= dict.fromkeys(self.own, own)
        write_atomically(self.folder / RECORD, json.dumps(self.record, indent=1))

    def end(self, seconds: float, *, complete: bool) -> None:
        """Write the record with the wall time, s, and whether every result is there; if it is, the rows too."""
        self.record |= {"seconds": seconds, "complete": complete}
        self.write_record()
        if complete:  # a complete record lists no file that is missing: it is none while the rows are written
            self.record["complete"] = False
            self.write_file(rows_name(self.files), rows_content(self.files, self.out, self.summary.found))
            self.record["complete"] = True
            self.write_record()

    def finish(self) -> None:
        """Write that all is done: every result is there, and its report is written."""
        self.record["finished"] = True
        self.write_record()
