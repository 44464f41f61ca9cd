"""The round-off study's folder, written as results come; :mod:`reports.tables.roundoff` says what is in it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.record.files import write_atomically
from barchain.studies.roundoff.laws.engine_fits import engine_laws
from barchain.studies.roundoff.laws.fits import best_laws, best_table, evaluation_laws, growth_laws
from reports.tables.roundoff import COLUMNS

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

OF_PARTS = {
    "evaluation": ("evaluation", "laws", "longitudes"),
    "trajectories": ("trajectories", "best", "best_laws", "growth", "growth_laws"),
    "engines": ("engines", "engine_laws"),
    "times": ("times",),
}
DERIVED = {
    "laws": ("evaluation", evaluation_laws),
    "growth_laws": ("growth", growth_laws),
    "engine_laws": ("engines", engine_laws),
}


class RoundoffStore:
    """Rows of one study's tables."""

    def __init__(self, folder: Path, record: dict[str, Any], parts: Iterable[str]) -> None:
        """Open `folder`; what an earlier study left there of the same parts is replaced."""
        self.folder, self.record = folder, record
        folder.mkdir(parents=True, exist_ok=True)
        for name in (table for part in parts for table in OF_PARTS[part]):
            (folder / f"{name}.csv").unlink(missing_ok=True)
        self.rows: dict[str, dict[int, list[dict[str, Any]]]] = {}

    def keep(self, table: str, rows: list[dict[str, Any]], place: int = 0) -> None:
        """Add a task's rows to a table, at the task's own place whenever they come, and write it."""
        self.rows.setdefault(table, {})[place] = rows
        self.write(table, self.table(table))

    def table(self, name: str) -> pd.DataFrame:
        """Table as it stands."""
        rows = [row for _, own in sorted(self.rows.get(name, {}).items()) for row in own]
        return pd.DataFrame(rows).reindex(columns=list(COLUMNS[name]))

    def finish(self) -> None:
        """Write what follows from the tables, and the record."""
        for name, (source, laws) in DERIVED.items():
            if source in self.rows:
                self.write(name, laws(self.table(source)))
        if "trajectories" in self.rows:
            best = best_table(self.table("trajectories"))
            self.write("best", best.reindex(columns=list(COLUMNS["best"])))
            self.write("best_laws", best_laws(best))
        self.write_record()

    def write(self, name: str, table: pd.DataFrame) -> None:
        """Write a table."""
        write_atomically(self.folder / f"{name}.csv", table.to_csv(index=False))

    def write_record(self) -> None:
        """Write record.json as it stands."""
        write_atomically(self.folder / "record.json", json.dumps(self.record, indent=1))
