"""Chapter of the random campaign: rates of false alarms and of missed faults."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import Counter
from itertools import pairwise
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from reports.results.faults.campaign import ENGINE_CLASSES, FAULT_CLASSES, FILES, CellClass
from reports.results.rows import records
from reports.text.numerals import as_given

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import pandas as pd

EDGES = (1e-2, 1e-1, 1.0, 10.0, 1e2, 1e4)
"""Limits between the classes of a fault's size, in units of the detection limit"""
SIZES = (
    f"up to {as_given(EDGES[0])}", *(f"{as_given(a)} to {as_given(b)}" for a, b in pairwise(EDGES)),
    f"above {as_given(EDGES[-1])}", "not stated",
)  # fmt: skip
"""These classes, and that of a quantity without a detection limit"""
SIZE_CLASSES = (CellClass.CAUGHT, CellClass.MISSED, CellClass.BELOW, CellClass.BEYOND)
NONE_TRIED: dict[str, Any] = {"n": 0, "count": 0}
FINDINGS = (CellClass.FALSE_ALARM, CellClass.MISSED)


def view_campaign(folder: Path) -> SimpleNamespace:
    """Contents of the page, from the campaign in a result folder."""
    tables = FILES.contents(folder)
    cells, parts = tables.campaign, tables.rates_of_parts
    unmodified, faulty = cells[cells["fault"] == ""], cells[cells["fault"] != ""]
    return SimpleNamespace(
        record=tables.record,
        finished=bool(tables.record.get("finished")),
        false_alarms=next(iter(rates_of(tables.rates, CellClass.FALSE_ALARM)), NONE_TRIED),
        missed=next(iter(rates_of(tables.rates, CellClass.MISSED)), NONE_TRIED),
        alarms_by_engine=rates_of(parts[parts["by"] == "engine"], CellClass.FALSE_ALARM),
        engine_classes=ENGINE_CLASSES,
        engines=counted(unmodified["engine"], unmodified["class"], ENGINE_CLASSES),
        size_classes=SIZE_CLASSES,
        sizes=size_rows(faulty),
        fault_classes=FAULT_CLASSES,
        faults=counted(faulty["fault"], faulty["class"], FAULT_CLASSES),
        findings=records(cells[cells["class"].isin(FINDINGS)]),
    )


def rates_of(rates: pd.DataFrame, kind: CellClass) -> list[dict[str, Any]]:
    """Rates of one class, largest first."""
    chosen = rates[rates["what"] == kind].sort_values("rate", ascending=False, kind="stable")
    return [row | {"n": int(row["n"]), "count": int(row["count"])} for row in records(chosen)]


def counted(names: pd.Series, classes: pd.Series, shown: Sequence[CellClass]) -> list[tuple[str, list[int]]]:
    """Numbers of cells by name, in the order of the names; one number for each class shown."""
    counts = Counter(zip(names, classes, strict=True))
    return [(name, [counts[name, str(k)] for k in shown]) for name in dict.fromkeys(names)]


def size_rows(cells: pd.DataFrame) -> list[tuple[str, list[int]]]:
    """Numbers of faults by their size in units of the detection limit; faults without one come last."""
    ratios = cells["size"] / cells["detection_limit"].where(cells["detection_limit"] > 0.0)
    names = ratios.map(lambda r: SIZES[-1 if math.isnan(r) else bisect_left(EDGES, r)])
    found = [row for row in counted(names, cells["class"], SIZE_CLASSES) if any(row[1])]
    return sorted(found, key=lambda row: SIZES.index(row[0]))
