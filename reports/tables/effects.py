"""Rows of an effect budget, as the table that its page is rendered from: a row for each effect, in SI units.

A cell is empty without a measurement.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, Followed
from reports.tables.schema import StudyRecord
from reports.tables.table import Number, Table
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Mapping

SIZES = ("between", "torque", "common")
"""Of an effect's accelerations: differences between bars relative to the tide's, torque relative to 3 n² J, mean
relative to g"""
CHANGED = tuple(CHANNELS[name] for name in ("com", "attitude", "reaction"))
"""Channels whose change by an effect is measured"""
RATIOS = ("time_ratio", "evaluation_ratio")
WITHOUT = "without"
"""What the time with an effect is relative to"""


class EffectKind(StrEnum):
    """Kind of a switchable effect."""

    GRAVITY = "gravity"
    """Another gravity model in place of the scene's"""
    NATURE = "nature"
    """Environmental effect, present in nature"""
    DESIGN = "design"
    """Effect of the chain's design or control"""


TABLE = Table(
    ("effect", "engine"),
    "relevance",
    {"outcome": "said", "reason": "reason", "text": "title"},
    numbers={
        **{f"{name}_{when}": Number(name, when) for when in ("start", "largest") for name in SIZES},
        **{c.column_of(): Number(c.name, "change", c.unit) for c in CHANGED},
        **{c.column_of("noise"): Number(c.name, "noise", c.unit) for c in CHANGED},
        **{r: Number("", r, "1", f"{r}_low", f"{r}_high", relative_to=WITHOUT) for r in RATIOS},
        "seconds": Number("simulate", "seconds", "s"),
        "evaluation_s": Number("evaluation", "seconds", "s"),
        "evaluations": Number("evaluations", COUNT),
        "evaluations_ratio": Number("", "evaluations_ratio"),
        "rounds": Number("simulate", "rounds"),
        "compared_s": Number("", "compared", "s"),
        "width_least_m": Number("", "width_least", "m"),
        "width_largest_m": Number("", "width_largest", "m"),
    },
    words=("kind", "caveat", "ended"),
    flags=("on",),
)
FOLLOWED = {
    "relevance": Followed("verdict", setting="{effect}"),
    "change": Followed("value", "{metric}.{quantity}", setting="{effect}", within="noise"),
    "time_ratio": Followed("ratio", setting="{effect}"),
    "evaluation_ratio": Followed("ratio", setting="{effect}"),
}


def scene_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Scene of all rows."""
    return {"scene": str((record.get("scene") or {}).get("name") or "")}


FILES = StudyFiles(
    "effects",
    {"effects": TABLE},
    followed=FOLLOWED,
    place=scene_of,
    model=StudyRecord,
    title="Relevance of each effect",
    view="effects:view_effects",
    in_report=True,
)
read_effects = FILES.contents
