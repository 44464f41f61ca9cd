"""The folder of a study, written as results come, so that an interrupted study leaves its results so far."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.record.files import write_atomically
from reports.tables.cells import to_cells

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from reports.tables.files import StudyFiles

Row = dict[str, Any]


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
            Whether the study continues from the tables in the folder; ``earlier`` is then the record beside them.
        """
        self.files, self.out, self.resume = files, out, resume
        self.record: dict[str, Any] = {} if record is None else record
        self.folder = files.folder(out)
        self.earlier: dict[str, Any] = files.read_record(out) if resume and files.has_record(out) else {}
        self.folder.mkdir(parents=True, exist_ok=True)

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
        """Write a table whole."""
        frame = content if isinstance(content, pd.DataFrame) else self.frame(table, content)
        write_atomically(self.files.path(self.out, table), to_cells(frame).to_csv(index=False))

    def append(self, table: str, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows to the end of a table; the first rows bring the header."""
        head = not self.has(table)
        with self.files.path(self.out, table).open("a", encoding="utf-8") as file:
            to_cells(self.frame(table, rows)).to_csv(file, index=False, header=head)

    def remove(self, *tables: str) -> None:
        """Delete the tables that an earlier study left in the folder."""
        for table in tables:
            self.files.path(self.out, table).unlink(missing_ok=True)

    def write_record(self) -> None:
        """Write the record as it stands."""
        write_atomically(self.folder / self.files.record, json.dumps(self.record, indent=1))

    def finish(self, seconds: float) -> None:
        """Write the record with the study's wall time, s."""
        self.record["seconds"] = seconds
        self.write_record()
