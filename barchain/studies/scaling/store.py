"""The scaling study's folder, written as points come; :mod:`reports.tables.scaling` says what is in it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.record.files import write_atomically
from barchain.studies.scaling.fit import fits_table, targets
from barchain.timing.left_out import NOT_RUN
from reports.tables.files import read_csv
from reports.tables.scaling import POINT_COLUMNS, WORDS

if TYPE_CHECKING:
    from pathlib import Path


class ScalingStore:
    """Points of one study."""

    def __init__(self, folder: Path, record: dict[str, Any], *, resume: bool = False) -> None:
        """Open `folder`; an earlier study there is replaced, or gone on from if `resume`."""
        self.folder, self.record = folder, record
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "points.csv"
        self.rows: list[dict[str, Any]] = recalled(path) if resume and path.is_file() else []

    def keep(self, engine: str, bars: int, columns: dict[str, Any]) -> None:
        """Note a point, and write all that there are."""
        self.rows.append({"engine": engine, "bars": bars} | columns)
        points = self.points()
        self.write("points", points)
        self.write("fits", fits_table(points))

    def points(self) -> pd.DataFrame:
        """All points so far, engine by engine as they first came."""
        order = list(dict.fromkeys(row["engine"] for row in self.rows))
        rows = sorted(self.rows, key=lambda row: order.index(row["engine"]))
        frame = pd.DataFrame(rows).reindex(columns=list(POINT_COLUMNS))
        return frame.astype({"reason": object, "per": object}).fillna({"reason": "", "per": ""})

    def of(self, engine: str, column: str) -> tuple[list[int], list[float]]:
        """Numbers of bars of an engine's points, and one of their columns where it was measured."""
        rows = [row for row in self.rows if row["engine"] == engine and column in row]
        return [row["bars"] for row in rows], [float(row[column]) for row in rows]

    def finish(self) -> None:
        """Write all tables and the record."""
        points = self.points()
        fits = fits_table(points)
        self.record["targets"] = targets(points, fits)
        self.write("points", points)
        self.write("fits", fits)
        self.write_record()

    def write(self, name: str, table: pd.DataFrame) -> None:
        """Write a table."""
        write_atomically(self.folder / f"{name}.csv", table.to_csv(index=False))

    def write_record(self) -> None:
        """Write record.json as it stands."""
        write_atomically(self.folder / "record.json", json.dumps(self.record, indent=1))


def recalled(path: Path) -> list[dict[str, Any]]:
    """Rows of an earlier study, without the cells that are empty and the points that were not run."""
    rows = read_csv(path, WORDS).to_dict("records")
    full = [{str(k): v for k, v in row.items() if v != "" and pd.notna(v)} for row in rows]
    return [row for row in full if not str(row.get("reason", "")).startswith(NOT_RUN)]
