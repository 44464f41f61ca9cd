"""Record of the studies of releases: what each release of an engine's distribution makes of the same scenes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from reports.chapters.releases import release_rows
from reports.results.releases import FILES

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

STUDIED = {
    "exudyn": "1.9", "rebound": "4.0", "pymunk": "6.5", "mujoco": "3.2", "heyoka": "7.10", "pinocchio": "3.3",
}  # fmt: skip
"""First release that is measured, by engine"""
B_MB = 1e6


def releases_rows(folder: Path) -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Rows of the table ``releases``, and the study's record."""
    tables = FILES.contents(folder)
    found = []
    for row, shown in zip(tables.releases.to_dict("records"), release_rows(tables), strict=True):
        version = shown["version"]
        found.append(
            {
                "engine": row["engine"], "version": version, "released": shown["released"], "state": shown["state"],
                "reason": shown["reason"], "digits": shown["digits"], "verdicts": verdicts(tables.errors, version),
                "wheel_MB": row["wheel_B"] / B_MB, "import_s": row["import_s"],
            }
            | finest(tables.times, version)
        )  # fmt: skip
    return found, tables.record


def verdicts(errors: pd.DataFrame, version: str) -> str:
    """Outcomes of a release on its scenes, e.g. ``pass``."""
    own = errors[errors["version"].astype(str) == version]
    return ", ".join(sorted({str(word) for word in own["verdict"] if word}))


def finest(times: pd.DataFrame, version: str) -> dict[str, Any]:
    """Time at equal error relative to the anchor, at the finest error that the release reached."""
    own = times[times["version"].astype(str) == version]
    if not len(own):
        return {"at": "", "ratio": math.nan}
    last = own.iloc[-1]
    return {"at": str(last["setting"]), "ratio": float(last["ratio"])}
