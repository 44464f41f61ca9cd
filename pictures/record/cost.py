"""Record of a cost study: errors and times over each engine's sweep, orders, and cost at equal error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pictures.record.files import COLUMNS
from reports.results.cost import read_cost

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class CostRun:
    """Engines that one run of the cost study times beside the anchor."""

    engines: tuple[str, ...]
    minutes: int


APART = {
    "cost-ida": CostRun(("ida-index1", "ida-index2", "ida-ggl", "ida-index3"), 8),
    "cost-jaxsim": CostRun(("jaxsim",), 10),
}
"""Runs of engines that would use up the others' time: IDA's runs take some thousand times the anchor's, and JaxSim
imports and compiles for some 8 s before each"""


def cost_rows(folder: Path) -> tuple[dict[str, Rows], dict[str, Any]]:
    """Rows of the tables ``cost``, ``orders`` and ``reach``, and the study's record."""
    tables = read_cost(folder)
    reach = tables.reach
    reach = reach[(reach.quantity == "attitude") & (reach.measure == "seconds")]
    orders = tables.orders[tables.orders.quantity == "attitude"]
    found = {"cost": tables.points, "orders": orders, "reach": reach}
    return {name: rows_of(frame, COLUMNS[name]) for name, frame in found.items()}, tables.record


def rows_of(frame: pd.DataFrame, columns: tuple[str, ...]) -> Rows:
    """Rows with the record's columns; a column that the study lacks stays empty."""
    return [{str(k): v for k, v in row.items()} for row in frame.reindex(columns=list(columns)).to_dict("records")]
