"""The record as the pages read it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from barchain.studies.stability.plan import recorded
from pictures.record.files import read_runs, read_table

if TYPE_CHECKING:
    import pandas as pd

Row = dict[str, Any]


@dataclass(frozen=True)
class MeasuredRecord:
    """All tables of the record."""

    @cached_property
    def certified(self) -> dict[str, Row]:
        """Certified solution of each scene."""
        return by_scene(read_table("certified"))

    @cached_property
    def hard(self) -> dict[str, Row]:
        """Predictability of each hard scene."""
        return by_scene(read_table("hard"))

    @cached_property
    def comparison(self) -> dict[tuple[str, str], Row]:
        """Outcome of each scene and engine."""
        return by_pair(read_table("comparison"))

    @cached_property
    def versions(self) -> dict[str, str]:
        """Version of each engine that was compared."""
        return {row["engine"]: row["version"] for row in rows(read_table("versions"))}

    @cached_property
    def reasons(self) -> dict[tuple[str, str], str]:
        """Reasons of the stability study, where one was run for the record."""
        return {pair: str(row["reason"]) for pair, row in by_pair(read_table("stability")).items()}

    @cached_property
    def stability(self) -> dict[tuple[str, str], str]:
        """Recorded outcome of each hard scene and engine."""
        return recorded()

    @cached_property
    def points(self) -> pd.DataFrame:
        """Runs of the cost study."""
        return read_table("cost")

    @cached_property
    def orders(self) -> pd.DataFrame:
        """Measured orders."""
        return read_table("orders")

    @cached_property
    def reach(self) -> pd.DataFrame:
        """Cost at equal error."""
        return read_table("reach")

    @cached_property
    def releases(self) -> pd.DataFrame:
        """Releases of six engines."""
        return read_table("releases")

    @cached_property
    def runs(self) -> dict[str, Row]:
        """Facts of the runs behind the tables."""
        return read_runs()


def by_scene(frame: pd.DataFrame) -> dict[str, Row]:
    """Rows by scene."""
    return {row["scene"]: row for row in rows(frame)}


def by_pair(frame: pd.DataFrame) -> dict[tuple[str, str], Row]:
    """Rows by scene and engine."""
    return {(row["scene"], row["engine"]): row for row in rows(frame)}


def rows(frame: pd.DataFrame) -> list[Row]:
    """Rows of a table; an empty number is None."""
    records = frame.to_dict("records")
    return [{str(k): None if isinstance(v, float) and math.isnan(v) else v for k, v in r.items()} for r in records]
