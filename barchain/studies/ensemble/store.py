"""An ensemble's tables in a folder, as :mod:`reports.chapters.ensemble.page` reads them."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from barchain.record.environment import environment, now, packages
from barchain.record.facts import scene_facts
from reports.tables.schema import KEY, SCHEMA_VERSION

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.studies.ensemble.ensemble import EnsembleResult

FOLDER = "ensemble"


def write(
    result: EnsembleResult, out: Path, *, command: str, vary: tuple[str, ...], settings: dict[str, object]
) -> None:
    """Write ``ensemble/quantiles.csv``, ``ensemble/runs.csv`` and ``ensemble/record.json`` into `out`."""
    folder = out / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    result.quantiles.to_csv(folder / "quantiles.csv", index=False)
    result.runs.to_csv(folder / "runs.csv", index=False)
    record = {
        KEY: SCHEMA_VERSION,
        "created": now(),
        "command": command,
        "scene": {"name": result.scene.name} | scene_facts(result.scene),
        "vary": list(vary),
        "runs": len(result.runs),
        "outcomes": result.runs["outcome"].value_counts().to_dict(),
        "evaluations": int(result.runs["evaluations"].sum()),
        "seconds": result.seconds,
        "environment": environment(),
        "packages": packages(),
    }
    (folder / "record.json").write_text(json.dumps(record | settings, indent=2), encoding="utf-8")
