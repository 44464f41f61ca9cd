"""View of a random campaign."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.faults.campaign import ALL, ENGINE_CLASSES, FAULT_CLASSES, CellClass, read_campaign
from reports.text.numerals import as_given

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    import pandas as pd

EDGES = (1e-2, 1e-1, 1.0, 10.0, 1e2, 1e4)
"""Limits between the classes of a fault's size, in units of the detection limit"""
FINDINGS = (CellClass.FALSE_ALARM, CellClass.MISSED)


@dataclass(frozen=True)
class RateRow:
    """Rate of one class with its 95 % interval."""

    name: str
    n: int
    count: int
    rate: float
    low: float
    high: float

    @property
    def text(self) -> str:
        """``0.26 % (0.15 to 0.46 %)``."""
        if not self.n:
            return "none tried"
        rate, low, high = (f"{100.0 * share:.2f}" for share in (self.rate, self.low, self.high))
        return f"{rate} % ({low} to {high} %)"


@dataclass(frozen=True)
class CountRow:
    """Numbers of cells of one engine, fault or size, one for each class."""

    name: str
    counts: tuple[int, ...]


@dataclass(frozen=True)
class CampaignView:
    """Contents of the page."""

    record: dict[str, Any]
    false_alarms: RateRow
    missed: RateRow
    alarms_by_engine: tuple[RateRow, ...]
    engines: tuple[CountRow, ...]
    """In the columns :attr:`engine_classes`"""
    sizes: tuple[CountRow, ...]
    """In the columns :attr:`size_classes`, from small faults to large ones"""
    faults: tuple[CountRow, ...]
    """In the columns :attr:`fault_classes`"""
    findings: tuple[dict[str, Any], ...]
    """Rows of false alarms and of missed faults"""

    engine_classes = ENGINE_CLASSES
    fault_classes = FAULT_CLASSES
    size_classes = (CellClass.CAUGHT, CellClass.MISSED, CellClass.BELOW, CellClass.BEYOND)

    @property
    def finished(self) -> bool:
        """Whether the campaign was finished."""
        return bool(self.record.get("finished"))

    @property
    def headline(self) -> str:
        """Result in one sentence."""
        alarms, missed = self.false_alarms, self.missed
        said = f"{alarms.count} of {alarms.n} verdicts on unmodified engines are false alarms"
        if not missed.n:
            return f"{said}."
        return f"{said}; {missed.n - missed.count} of {missed.n} faults above the detection limit are caught."


def view_campaign(folder: Path) -> CampaignView:
    """View of the campaign in a result folder."""
    tables = read_campaign(folder)
    cells, rates = tables.cells, tables.rates
    faulty = cells["fault"] != ""
    return CampaignView(
        tables.record,
        whole_rate(rates, CellClass.FALSE_ALARM),
        whole_rate(rates, CellClass.MISSED),
        rate_rows(rates, CellClass.FALSE_ALARM, "engine"),
        count_rows(cells[~faulty], "engine", CampaignView.engine_classes),
        size_rows(cells[faulty]),
        count_rows(cells[faulty], "fault", CampaignView.fault_classes),
        tuple({str(k): v for k, v in row.items()} for row in cells[cells["class"].isin(FINDINGS)].to_dict("records")),
    )


def rate_rows(rates: pd.DataFrame, kind: CellClass, by: str) -> tuple[RateRow, ...]:
    """Rates of one class by engine, by fault or over all, largest first."""
    chosen = rates[(rates["what"] == kind) & (rates["by"] == by)].sort_values("rate", ascending=False, kind="stable")
    return tuple(
        RateRow(r["name"], int(r["n"]), int(r["count"]), float(r["rate"]), float(r["low"]), float(r["high"]))
        for r in chosen.to_dict("records")
    )


def whole_rate(rates: pd.DataFrame, kind: CellClass) -> RateRow:
    """Rate of one class over the whole campaign; of no trial before the first scenes are judged."""
    return next(iter(rate_rows(rates, kind, ALL)), RateRow(ALL, 0, 0, math.nan, 0.0, 1.0))


def count_rows(cells: pd.DataFrame, column: str, classes: Iterable[CellClass]) -> tuple[CountRow, ...]:
    """Numbers of cells by the names in one column, in their order."""
    counts = Counter(zip(cells[column], cells["class"], strict=True))
    shown = tuple(classes)
    return tuple(CountRow(name, tuple(counts[name, str(k)] for k in shown)) for name in dict.fromkeys(cells[column]))


def size_rows(cells: pd.DataFrame) -> tuple[CountRow, ...]:
    """Numbers of faults by their size in units of the detection limit; faults without one come last."""
    ratio = (cells["size"] / cells["detection_limit"].where(cells["detection_limit"] > 0.0)).tolist()
    counts = Counter(zip(map(size_class, ratio), cells["class"], strict=True))
    names = (*map(size_words, range(len(EDGES) + 1)), "not stated")
    found = [
        CountRow(name, tuple(counts[k, str(kind)] for kind in CampaignView.size_classes))
        for k, name in enumerate(names)
    ]
    return tuple(row for row in found if any(row.counts))


def size_class(ratio: float) -> int:
    """Number of a size's class; the last one for a quantity without a detection limit."""
    return len(EDGES) + 1 if math.isnan(ratio) else sum(ratio > edge for edge in EDGES)


def size_words(k: int) -> str:
    """``0.1 to 1`` of a class of sizes."""
    if k == 0:
        return f"up to {as_given(EDGES[0])}"
    if k == len(EDGES):
        return f"above {as_given(EDGES[-1])}"
    return f"{as_given(EDGES[k - 1])} to {as_given(EDGES[k])}"
