"""Rows of an effect budget, as the table that its page is rendered from: a row for each effect, in SI units.

A cell is empty without a measurement.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.results.files import StudyFiles
from reports.results.rows import Followed
from reports.results.schema import StudyRecord
from reports.results.table import Table
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
    {
        "said": ".outcome", "reason": ".reason", "title": ".text",
        **{f"{name}_{when}": f"{when}:{name}" for when in ("start", "largest") for name in SIZES},
        **{c.column_of(): f"change:{c.name} {c.unit}" for c in CHANGED},
        **{c.column_of("noise"): f"noise:{c.name} {c.unit}" for c in CHANGED},
        "time_ratio": "time_ratio/without", "time_ratio_low": "time_ratio.low", "time_ratio_high": "time_ratio.high",
        "evaluation_ratio": "evaluation_ratio/without", "evaluation_ratio_low": "evaluation_ratio.low",
        "evaluation_ratio_high": "evaluation_ratio.high",
        "seconds": "seconds:simulate s", "evaluation_s": "seconds:evaluation s", "evaluations": "count:evaluations",
        "evaluations_ratio": "evaluations_ratio", "rounds": "rounds:simulate", "compared_s": "compared s",
        "width_least_m": "width_least m", "width_largest_m": "width_largest m",
        "kind": "kind.text", "caveat": "caveat.text", "ended": "ended.text", "on": "on",
    },
    flags=("on",),
)  # fmt: skip
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
