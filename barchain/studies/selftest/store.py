"""The self-test's folder; :mod:`reports.tables.selftest` says what is in it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.record.files import write_atomically
from reports.tables.selftest import COLUMNS, SMALLEST

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.studies.selftest.detection_limit import Bracket
    from barchain.studies.selftest.matrix import Matrix


class SelftestStore:
    """Tables and record of one self-test."""

    def __init__(self, folder: Path, record: dict[str, Any]) -> None:
        """Open `folder`; what an earlier self-test left there is replaced."""
        self.folder, self.record = folder, record
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "smallest.csv").unlink(missing_ok=True)

    def keep_matrix(self, matrix: Matrix) -> None:
        """Write the matrix."""
        rows = [row for cell in matrix.cells for row in cell.rows()]
        self.write("selftest.csv", rows, COLUMNS)
        self.record.update(passed=matrix.passed, unkilled=[f.name for f in matrix.unkilled])
        self.write_record()

    def keep_smallest(self, found: list[Bracket]) -> None:
        """Write the smallest sizes."""
        self.write("smallest.csv", [pair.row() for pair in found], SMALLEST)

    def write(self, name: str, rows: list[dict[str, Any]], columns: tuple[str, ...]) -> None:
        """Write one table."""
        write_atomically(self.folder / name, pd.DataFrame(rows, columns=list(columns)).to_csv(index=False))

    def write_record(self) -> None:
        """Write the record as it stands."""
        write_atomically(self.folder / "selftest.json", json.dumps(self.record, indent=1))
