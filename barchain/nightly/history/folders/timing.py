"""Figures of the studies that time engines: cost, scaling, effects, and the times of the round-off study."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.nightly.history.changes.steps import LEAST_EFFECT
from barchain.nightly.history.folders.collector import FigureCollector, real, records
from barchain.nightly.history.model.figures import FigureKind
from reports.tables.cost import BASELINE, BUSY, NOT_RUN, read_cost
from reports.tables.effects import UNITS, read_effects
from reports.tables.roundoff import FILES as ROUNDOFF_FILES
from reports.tables.roundoff import read_roundoff
from reports.tables.scaling import read_scaling

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from barchain.nightly.history.model.figures import Figure

REACHED = frozenset({"reached", "at most"})
INTERRUPTED = f"{NOT_RUN}: the study was interrupted"
PAGE_B = 4096
LEAST_MEMORY_B = PAGE_B / LEAST_EFFECT
"""Least peak memory that is followed: of a smaller one, a page more or less would be a step"""
WITHOUT_EFFECT = "without"
Row = dict[str, Any]


def cost_figures(folder: Path) -> tuple[Figure, ...]:
    """Outcomes and counters of each setting, times at equal errors relative to the baseline, orders of convergence."""
    tables, found = read_cost(folder), FigureCollector("cost")
    busy = busy_machine(tables.record)
    interrupted = "" if tables.record.get("complete") else INTERRUPTED
    cut: dict[tuple[str, str], str] = {}
    for row in records(tables.points):
        place = (row["scene"], row["engine"], row["setting"])
        add_outcome(found, place, row)
        found.counts(place, {name: row[name] for name in ("evaluations", "steps")})
        if str(row["reason"]).startswith(NOT_RUN):
            cut.setdefault(place[:2], row["reason"])
    for row in records(tables.reach):
        add_equal_error_cost(found, row, cut.get((row["scene"], row["engine"]), interrupted), busy)
    for row in records(tables.orders):
        place, quantity = (row["scene"], row["engine"], ""), f"order.{row['quantity']}.{row['against']}"
        ends = {"low": row["order_low"], "high": row["order_high"]}
        order = np.nan if interrupted else row["order"]
        found.number(place, quantity, FigureKind.VALUE, order, reason=interrupted or "too few points", **ends)
    return found.figures


def add_outcome(found: FigureCollector, place: tuple[str, str, str], row: Row) -> None:
    """Add the outcome of a point; one that the time limit left out has none, as that depends on the machine's load."""
    skipped = str(row["reason"]).startswith(NOT_RUN)
    found.word(place, "outcome", FigureKind.VERDICT, "" if skipped else row["outcome"], row["reason"])


def busy_machine(record: Mapping[str, Any]) -> str:
    """Why the times of a study tell nothing of its engines; empty if they do."""
    others = real(record.get("other_processors"))
    return f"other processes used {others:.1f} processors" if others is not None and others > BUSY else ""


def add_equal_error_cost(found: FigureCollector, row: Row, not_run: str, busy: str) -> None:
    """Add the time to an error relative to the baseline's: both were timed in turns.

    `not_run` is the reason why a finer setting of the engine was not run: whether it reaches the error is then unknown.
    `busy` is the reason why times are missing.
    """
    if row["engine"] == BASELINE or row["measure"] != "seconds":
        return
    place = (row["scene"], row["engine"], f"{row['quantity']}<={row['target']:g}")
    sure = {"reached"} if not_run == INTERRUPTED else REACHED  # its coarsest point may be missing
    unknown = bool(not_run) and row["status"] not in sure
    found.word(place, "reach", FigureKind.VERDICT, "" if unknown else row["status"], not_run if unknown else "")
    ends = {"low": row["over_baseline_low"], "high": row["over_baseline_high"]}
    if row["status"] in REACHED and real(row["over_baseline"]) is not None:
        ratio = np.nan if busy else row["over_baseline"]
        found.number(place, "time_ratio", FigureKind.RATIO, ratio, anchor=BASELINE, reason=busy, **ends)


def scaling_figures(folder: Path) -> tuple[Figure, ...]:
    """Outcomes, memory, and the time of an evaluation relative to the baseline's with as many bars."""
    tables, found = read_scaling(folder), FigureCollector("scaling")
    scene = str((tables.record.get("scene") or {}).get("name") or "")
    rows = list(records(tables.points))
    anchors = {row["bars"]: row for row in rows if row["engine"] == BASELINE}
    for row in rows:
        place = (scene, row["engine"], f"bars={row['bars']:g}")
        add_outcome(found, place, row)
        if (real(row["memory_B"]) or 0.0) >= LEAST_MEMORY_B:
            found.number(place, "memory", FigureKind.MEMORY, row["memory_B"], "B")
        if row["engine"] != BASELINE and row["bars"] in anchors:
            add_ratio(found, place, row, anchors[row["bars"]], busy_machine(tables.record))
    return found.figures


def add_ratio(found: FigureCollector, place: tuple[str, str, str], row: Row, anchor: Row, busy: str) -> None:
    """Add the ratio of two times; its interval spans both. `busy` is the reason why it is missing."""
    mine, base = ([real(r[f"evaluation_{end}"]) for end in ("s", "low", "high")] for r in (row, anchor))
    if mine[0] is None or not base[0]:
        return
    low, high = over(mine[1], base[2]), over(mine[2], base[1])
    ratio = np.nan if busy else mine[0] / base[0]
    found.number(place, "evaluation_ratio", FigureKind.RATIO, ratio, anchor=BASELINE, reason=busy, low=low, high=high)


def over(a: float | None, b: float | None) -> float:
    """Ratio of two numbers; NaN if one is unknown."""
    return a / b if a is not None and b else float(np.nan)


def effects_figures(folder: Path) -> tuple[Figure, ...]:
    """Changes by each effect, and its time relative to a run without."""
    tables, found = read_effects(folder), FigureCollector("effects")
    scene = str((tables.record.get("scene") or {}).get("name") or "")
    for row in records(tables.effects):
        place = (scene, row["engine"], row["effect"])
        found.word(place, "relevance", FigureKind.VERDICT, row["said"], row["reason"])
        for name, unit in UNITS.items():
            value, noise = real(row[f"{name}_{unit}"]), row[f"{name}_noise_{unit}"]
            if value is not None:
                found.number(place, f"change.{name}", FigureKind.VALUE, value, unit, tolerance=noise)
        for name in ("time_ratio", "evaluation_ratio"):
            if (real(row[name]) or 0.0) > 0.0:
                ends = {"low": row[f"{name}_low"], "high": row[f"{name}_high"]}
                found.number(place, name, FigureKind.RATIO, row[name], anchor=WITHOUT_EFFECT, **ends)
    return found.figures


def roundoff_figures(folder: Path) -> tuple[Figure, ...]:
    """Exponents of all laws with their intervals, and times of relative coordinates relative to absolute ones."""
    tables, found = read_roundoff(folder), FigureCollector("roundoff")
    scene = str(tables.record.get("scene") or "")
    for name in ("laws", "best_laws", "growth_laws", "engine_laws"):
        keys = [c for c in ROUNDOFF_FILES.tables[name] if c in ROUNDOFF_FILES.words or c in {"bars", "ratio"}]
        for row in records(getattr(tables, name)):
            setting = " ".join(word(row[key]) for key in keys if key not in {"remark", "engine"})
            place, ends = (scene, row.get("engine", ""), setting), {"low": row["low"], "high": row["high"]}
            value = row["exponent"]
            found.number(place, f"{name}.exponent", FigureKind.VALUE, value, reason=row["remark"], **ends)
    for row in records(tables.times):
        place = (scene, "", f"{row['code']}, {row['arithmetic']}, bars={row['bars']:g}")
        ends = {"low": row["low"], "high": row["high"]}
        found.number(place, "time_ratio", FigureKind.RATIO, row["ratio"], anchor="absolute", **ends)
    return found.figures


def word(value: Any) -> str:
    """Key of a row as text."""
    return value if isinstance(value, str) else f"{value:g}"
