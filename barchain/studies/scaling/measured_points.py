"""Points of a scaling study, kept in its folder as they are measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.studies.scaling.fit import add_fits, fits_table, targets
from reports.tables.outcome import Outcome
from reports.tables.rows import NOT_RUN

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore


class ScalingPoints:
    """Points of one study: an engine at a number of bars."""

    def __init__(self, store: StudyStore) -> None:
        """Start with no point, or with those of an interrupted study where `store` resumes one."""
        self.store = store
        self.rows: list[dict[str, Any]] = []
        if store.resume and store.has("points"):
            self.rows = recalled(store.read("points"))

    def keep(self, engine: str, bars: int, columns: dict[str, Any]) -> None:
        """Add a point, and write all points."""
        self.rows.append({"engine": engine, "bars": bars} | columns)
        self.store.write("points", self.points())

    def points(self) -> pd.DataFrame:
        """All points so far, engine by engine as they first came."""
        order = list(dict.fromkeys(row["engine"] for row in self.rows))
        rows = sorted(self.rows, key=lambda row: order.index(row["engine"]))
        frame = self.store.frame("points", rows)
        return frame.astype({"reason": object, "per": object}).fillna({"reason": "", "per": ""})

    def of(self, engine: str, column: str) -> tuple[list[int], list[float]]:
        """Numbers of bars of an engine's points, and one of their columns where it was measured."""
        rows = [row for row in self.rows if row["engine"] == engine and column in row]
        return [row["bars"] for row in rows], [float(row[column]) for row in rows]

    def finish(self) -> None:
        """Write the points, add the exponents to the rows, and to the record whether the targets are met."""
        points = self.points()
        fits = fits_table(points)
        self.store.record["targets"] = targets(points, fits)
        add_fits(self.store.summary, fits, str(self.store.record["scene"]["name"]))
        self.store.write("points", points)


def recalled(points: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of an interrupted study, without empty cells; points that were not run or that failed are left out."""
    points = points[points.outcome != Outcome.FAILED.value]
    full = [{str(k): v for k, v in row.items() if v != "" and pd.notna(v)} for row in points.to_dict("records")]
    return [row for row in full if not str(row.get("reason", "")).startswith(NOT_RUN)]
