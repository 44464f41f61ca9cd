"""Stored tables of an effect budget: everything that its page is rendered from.

A folder ``effects`` inside a result folder holds

``effects.csv``
    one row for each effect, columns :data:`COLUMNS`, SI units; a cell is empty without a measurement;
``record.json``
    scene, thresholds of relevance, and environment.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, Followed, Rows, known, records
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

SIZES = ("between", "torque", "common")
"""Of an effect's accelerations: differences between bars relative to the tide's, torque relative to 3 n² J, mean
relative to g"""
QUANTITIES = ("com", "attitude", "reaction")
COLUMNS = (
    "effect", "title", "kind", "on", "said", "reason", "caveat", "width_least_m", "width_largest_m", "engine",
    *(f"{name}_{when}" for when in ("start", "largest") for name in SIZES),
    "com_m", "com_noise_m", "attitude_rad", "attitude_noise_rad", "reaction_N", "reaction_noise_N",
    "compared_s", "ended",
    "time_ratio", "time_ratio_low", "time_ratio_high", "rounds",
    "evaluation_ratio", "evaluation_ratio_low", "evaluation_ratio_high", "evaluations_ratio",
    "seconds", "evaluation_s", "evaluations",
)  # fmt: skip
WORDS = ("effect", "title", "kind", "said", "reason", "caveat", "engine", "ended")


class EffectsRecord(Record):
    """Entries of the record."""

    scene: dict[str, Any] | None = None
    rtol: float | None = None
    looser: float | None = None
    parted_rad: float | None = None
    matters: float | None = None
    width_m: float | None = None


FILES = StudyFiles(
    "effects",
    {"effects": COLUMNS},
    WORDS,
    flags=("on",),
    model=EffectsRecord,
    pages=("effects.html",),
)
UNITS = {"com": "m", "attitude": "rad", "reaction": "N"}


class EffectKind(StrEnum):
    """Kind of a switchable effect."""

    GRAVITY = "gravity"
    """Another gravity model in place of the scene's"""
    NATURE = "nature"
    """Environmental effect, present in nature"""
    DESIGN = "design"
    """Effect of the chain's design or control"""


read_effects = FILES.contents


WITHOUT = "without"
"""What the time with an effect is relative to"""
MEASURED = {
    **{f"{name}_{when}": (name, when, "1") for when in ("start", "largest") for name in SIZES},
    **{f"{name}_{unit}": (name, "change", unit) for name, unit in UNITS.items()},
    **{f"{name}_noise_{unit}": (name, "noise", unit) for name, unit in UNITS.items()},
    "seconds": ("simulate", "seconds", "s"), "evaluation_s": ("evaluation", "seconds", "s"),
    "evaluations": ("evaluations", COUNT, "1"), "evaluations_ratio": ("", "evaluations_ratio", "1"),
}  # fmt: skip
"""Quantity, metric and unit of the columns of numbers"""
FOLLOWED = {
    "relevance": Followed("verdict", setting="{effect}"),
    "change": Followed("value", "{metric}.{quantity}", setting="{effect}", within="noise"),
    "time_ratio": Followed("ratio", setting="{effect}"),
    "evaluation_ratio": Followed("ratio", setting="{effect}"),
}


def effects_rows(folder: Path) -> Rows:
    """Rows of an effect budget: relevance, sizes and changes of each effect, and its time relative to a run without."""
    tables = read_effects(folder)
    found = Rows(FILES.name, str((tables.record.get("scene") or {}).get("name") or ""))
    for row in records(tables.effects):
        where = {name: row[name] for name in ("engine", "effect")}
        found.add("relevance", outcome=row["said"], reason=row["reason"], text=row["title"], **where)
        found.measured(row, MEASURED, **where)
        for name in ("time_ratio", "evaluation_ratio"):
            if known(row[name]) and row[name] > 0.0:
                found.measured(row, {name: ("", name, "1")}, relative_to=WITHOUT, **where)
    return found
