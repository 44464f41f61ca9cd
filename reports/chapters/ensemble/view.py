"""View of an ensemble."""

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

UNITS = {"attitude": ("bar", "angle from the z1 axis, rad"), "reaction": ("joint", "magnitude of the reaction, N")}


@dataclass(frozen=True)
class FanGroup:
    """Fan charts of one quantity."""

    title: str
    panels: tuple[Panel, ...]
    left_out: int
    """Number of bars or joints without a panel"""


@dataclass(frozen=True)
class EnsembleView:
    """Contents of the page."""

    record: dict[str, Any]
    scene: SceneRecord
    groups: list[FanGroup]
    final: list[dict[str, Any]]
    """Quantiles at the last instant, with the largest of their error bounds"""


def view_ensemble(folder: Path) -> EnsembleView:
    """View of the ensemble in a result folder."""
    tables = read_ensemble(folder)
    about = mapping(tables.record.get("scene"))
    scene = SceneRecord(str(about.get("name") or ""), about)
    return EnsembleView(tables.record, scene, groups(tables.quantiles, scene), final(tables.quantiles))


def groups(table: pd.DataFrame, scene: SceneRecord) -> list[FanGroup]:
    """Fan charts of all quantities."""
    found = []
    for quantity, (item, label) in UNITS.items():
        part = table[table["quantity"] == quantity]
        if len(part):
            panels = fans(part, item, label, scene.period_s if scene.in_orbits else 0.0)
            found.append(FanGroup(quantity.capitalize(), panels, int(part["item"].nunique()) - len(panels)))
    return found


def final(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Quantiles at the last instant, a row for each bar or joint."""
    last = table[table["t_s"] == table["t_s"].max()]
    index = ["quantity", "item", "unit", "runs"]
    wide = last.pivot_table(index=index, columns="quantile", values="value")
    bounds = last.groupby(index)["error_bound"].max()
    found = [
        {
            "quantity": str(key[0]), "item": int(key[1]), "unit": str(key[2]), "runs": int(key[3]),
            "values": dict(row), "error_bound": float(bounds[key]),
        }
        for key, row in zip(wide.index, wide.to_dict("records"), strict=True)
    ]  # fmt: skip
    return rows(found)
