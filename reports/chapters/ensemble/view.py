"""From an ensemble's tables to the view of its chapter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.ensemble.charts import fans
from reports.tables.ensemble import read_ensemble
from reports.text.record import SceneRecord, mapping, rows

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from reports.plotting.panels import Panel

UNITS = {"attitude": ("bar", "angle from the z1 axis, rad"), "reaction": ("joint", "size of the reaction, N")}


@dataclass(frozen=True)
class FanGroup:
    """The panels of one quantity."""

    title: str
    panels: tuple[Panel, ...]
    left_out: int
    """Bars or joints that have no panel"""


@dataclass(frozen=True)
class EnsembleView:
    """The whole chapter."""

    record: dict[str, Any]
    scene: SceneRecord
    groups: list[FanGroup]
    final: list[dict[str, Any]]
    """Quantiles at the last instant"""


def view_ensemble(folder: Path) -> EnsembleView:
    """View of the ensemble in a result folder."""
    tables = read_ensemble(folder)
    record, table = tables.record, tables.quantiles
    scene = SceneRecord(str(mapping(record.get("scene")).get("name") or ""), mapping(record.get("scene")))
    return EnsembleView(record, scene, groups(table, scene), final(table))


def groups(table: pd.DataFrame, scene: SceneRecord) -> list[FanGroup]:
    """Charts of every quantity there is."""
    found = []
    for quantity, (item, label) in UNITS.items():
        part = table[table["quantity"] == quantity]
        if len(part):
            panels = fans(part, quantity, item, label, scene.period_s if scene.closed else 0.0)
            found.append(FanGroup(quantity.capitalize(), panels, int(part["item"].nunique()) - len(panels)))
    return found


def final(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Quantiles at the last instant, a row for each bar or joint."""
    last = table[table["t_s"] == table["t_s"].max()]
    wide = last.pivot_table(index=["quantity", "item", "unit", "runs"], columns="quantile", values="value")
    found = [
        {"quantity": str(key[0]), "item": int(key[1]), "unit": str(key[2]), "runs": int(key[3]), "values": dict(row)}
        for key, row in zip(wide.index, wide.to_dict("records"), strict=True)
    ]
    return rows(found)
