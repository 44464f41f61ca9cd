"""Record of a stability study: outcomes with their reasons, and how predictable each hard scene is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from reports.results.stability import FILES

if TYPE_CHECKING:
    from pathlib import Path


def stability_rows(folder: Path) -> tuple[list[dict[str, Any]], list[dict[str, Any]], dict[str, Any]]:
    """Rows of outcomes, rows of scenes, and the study's record."""
    found = FILES.contents(folder, "outcomes")
    record, outcomes = found.record, found.outcomes
    rows = outcomes[["scene", "engine", "stability", "reason"]].to_dict("records")
    return [{str(k): v for k, v in row.items()} for row in rows], scene_rows(record), record


def scene_rows(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Predictability limit, error amplification and condition number of each scene."""
    return [
        {
            "scene": name,
            "limit_s": facts.get("solution_limit_s", math.nan),
            "amplification": facts.get("growth_total", math.nan),
            "condition_high": (facts.get("condition") or [math.nan, math.nan])[-1],
        }
        for name, facts in (record.get("scenes") or {}).items()
    ]
