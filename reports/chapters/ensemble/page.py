"""From an ensemble's tables to its page."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import pandas as pd

from reports.chapters.ensemble.charts import fans
from reports.page import write_page
from reports.text.record import SceneRecord, mapping, rows

if TYPE_CHECKING:
    from pathlib import Path

    from reports.plotting.panels import Panel

FOLDER = "ensemble"
UNITS = {"attitude": ("bar", "angle from the z1 axis, rad"), "reaction": ("joint", "size of the reaction, N")}


@dataclass(frozen=True)
class FanGroup:
    """The panels of one quantity."""

    title: str
    panels: tuple[Panel, ...]
    left_out: int
    """Bars or joints that have no panel"""


def render_ensemble(folder: Path) -> Path:
    """Write ``ensemble.html`` into a folder, from its stored tables alone.

    Raises
    ------
    FileNotFoundError
        If the folder holds no ensemble.
    """
    stored = folder / FOLDER
    if not (stored / "quantiles.csv").is_file():
        raise FileNotFoundError(f"{folder}: no {FOLDER}/quantiles.csv there; give a folder that ensemble wrote")
    record: dict[str, Any] = json.loads((stored / "record.json").read_text(encoding="utf-8"))
    table = pd.read_csv(stored / "quantiles.csv")
    scene = SceneRecord(str(mapping(record.get("scene")).get("name") or ""), mapping(record.get("scene")))
    shown = {
        "record": record,
        "scene": scene,
        "groups": groups(table, scene),
        "final": final(table),
    }
    return write_page(folder, "ensemble", shown, record)


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
