"""The files of a study inside a result folder: names, columns, and reading them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.tables import schema
from reports.tables.cells import from_cells

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class StudyFiles:
    """Tables and record of one study, in the folder ``<study>`` of a result folder."""

    study: str
    tables: Mapping[str, tuple[str, ...]]
    """Columns of each ``<table>.csv``; empty where the columns follow from the data"""
    words: tuple[str, ...] = ()
    """Columns of text: an empty cell is an empty string; in other columns an empty cell is NaN"""
    optional: frozenset[str] = field(default_factory=frozenset)
    """Tables that a study may lack; reading such a table gives no rows"""
    record: str = "record.json"

    def folder(self, out: Path) -> Path:
        """Folder of the study in the result folder `out`."""
        return out / self.study

    def path(self, out: Path, table: str) -> Path:
        """File of a table."""
        return self.folder(out) / f"{table}.csv"

    def has(self, out: Path, table: str) -> bool:
        """Whether a table was written."""
        return self.path(out, table).is_file()

    def has_record(self, out: Path) -> bool:
        """Whether the record was written."""
        return (self.folder(out) / self.record).is_file()

    def read(self, out: Path, table: str) -> pd.DataFrame:
        """Read a table.

        Raises
        ------
        FileNotFoundError
            If the table is missing and not optional.
        """
        if table in self.optional and not self.has(out, table):
            return pd.DataFrame(columns=list(self.tables[table]))
        found = from_cells(pd.read_csv(self.path(out, table), keep_default_na=False, na_values=[""]))
        for name in found.columns.intersection(list(self.words)):
            found[name] = found[name].astype(object).fillna("").astype(str)
        return found

    def read_all(self, out: Path, *tables: str) -> dict[str, pd.DataFrame]:
        """Read several tables by name, all of them by default.

        Raises
        ------
        FileNotFoundError
            If a table is missing and not optional.
        """
        return {name: self.read(out, name) for name in tables or self.tables}

    def read_record(self, out: Path) -> dict[str, Any]:
        """Read the record.

        Raises
        ------
        FileNotFoundError
            If there is none.
        SchemaVersionError
            If the record has another schema version.
        """
        return schema.read_record(self.folder(out) / self.record)


def flags(column: pd.Series) -> NDArray[np.bool_]:
    """Flags (n,) of a column that is stored as the words True and False."""
    found: NDArray[np.bool_] = (column.astype(str) == "True").to_numpy(bool)
    return found
