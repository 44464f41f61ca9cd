"""Long runs: drift of energy and attitude error in time, and the part of rounding."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from reports.chapters.stability.charts import DriftCurve, long_panel
from reports.chapters.stability.rows import known, raised, records
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.text.numerals import number, significant
from reports.text.record import mapping

if TYPE_CHECKING:
    import pandas as pd

    from reports.plotting.panels import Panel
    from reports.tables.stability import StabilityTables

COMPILED, PLAIN_SUMS, EXACT_SUMS = "reference-fast", "solution", "exact"
DRAWN = ("default", PLAIN_SUMS, EXACT_SUMS)
QUANTITIES = {
    "energy": ("Energy", "change relative to kinetic energy"),
    "attitude": ("Attitude", "difference from reference, rad"),
}
PENS = {PLAIN_SUMS: Pen(COLOURS["accent"], "", (6.0, 2.0)), EXACT_SUMS: Pen(COLOURS["accent"])}


@dataclass(frozen=True)
class LongScene:
    """One long scene."""

    name: str
    title: str
    panels: tuple[Panel, ...]
    laws: tuple[dict[str, Any], ...]
    """Rows of the table of laws"""


def long_scenes(tables: StabilityTables, engines: tuple[str, ...]) -> tuple[LongScene, ...]:
    """All long scenes."""
    names = dict.fromkeys(tables.laws.scene.astype(str)) if len(tables.laws) else {}
    return tuple(long_scene(tables, name, engines) for name in names)


def long_scene(tables: StabilityTables, name: str, engines: tuple[str, ...]) -> LongScene:
    """Charts and laws of one long scene."""
    about = mapping(mapping(tables.record.get("scenes")).get(name))
    period = number(about.get("period_s")) or 1.0
    series = tables.long[tables.long.scene == name]
    panels = [long_chart(series, name, quantity, engines, period) for quantity in QUANTITIES]
    own = [r for r in records(tables.laws) if r["scene"] == name]
    return LongScene(name, str(about.get("title") or name), tuple(p for p in panels if p), tuple(own))


def long_chart(
    series: pd.DataFrame, scene: str, quantity: str, engines: tuple[str, ...], period_s: float
) -> Panel | None:
    """Chart of one quantity of all runs."""
    tracks = []
    own = series[(series.quantity == quantity) & series.level.isin(DRAWN)]
    for (engine, level), rows in own.groupby(["engine", "level"], sort=False):
        pen = PENS.get(str(level)) or engine_pen(engines.index(engine) if engine in engines else 0)
        label = f"{engine}, {label_of(str(level))}" if level in PENS else str(engine)
        tracks.append(DriftCurve(label, rows.t_s.to_numpy(float) / period_s, rows.value.to_numpy(float), pen))
    title, y_label = QUANTITIES[quantity]
    found = long_panel(title, "orbits", y_label, tracks)
    return found and replace(found, title=f"{title}, {scene}")


def label_of(level: str) -> str:
    """Words of a level."""
    return {PLAIN_SUMS: "rtol = 1e-13", EXACT_SUMS: "rtol = 1e-14, compensated"}[level]


def rounding_sentence(laws: pd.DataFrame) -> str:
    """Sentence on the gain of compensated sums, in the first long scene with both runs."""
    for scene in dict.fromkeys(laws.scene.astype(str)) if len(laws) else ():
        own = {r["level"]: r for r in records(laws) if compiled_energy(r, scene)}
        if {PLAIN_SUMS, EXACT_SUMS} <= own.keys():
            return said(scene, own[PLAIN_SUMS], own[EXACT_SUMS])
    return ""


def compiled_energy(row: dict[str, Any], scene: str) -> bool:
    """Whether a row is that of the compiled reference's energy in a scene."""
    return bool(row["scene"] == scene and row["engine"] == COMPILED and row["quantity"] == "energy")


def said(scene: str, plain: dict[str, Any], exact: dict[str, Any]) -> str:
    """Sentence on both laws."""
    ratio = (known(plain["at_end"]) or 0.0) / (known(exact["at_end"]) or float("nan"))
    return (
        f"Rounding, on {scene}: energy drifts {law_text(plain)} at rtol = 1e-13, and {law_text(exact)} at 1e-14 with "
        f"compensated sums, {significant(ratio, 2)} times less at the end."
    )


def law_text(row: dict[str, Any]) -> str:
    """``as t⁰·⁹⁸ (0.95 to 1.01)``."""
    value, low, high = (known(row[k]) for k in ("exponent", "low", "high"))
    return f"as t{raised(value or 0.0)} ({low or 0.0:.2f} to {high or 0.0:.2f})"
