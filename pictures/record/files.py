"""Tables of the record: names, columns, reading, writing, and where each came from."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from pictures.paths import RECORD
from reports.results.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

DIGITS = "%.3g"
COLUMNS = {
    "certified": (
        "scene", "source", "com_error_m", "attitude_error_rad", "reaction_error_N", "amplification", "limit_s",
    ),
    "comparison": (
        "scene", "engine", "setting", "outcome", "attitude_rad", "reaction_N", "com_m", "detection_limit", "limit_s",
        "reason",
    ),
    "versions": ("engine", "version"),
    "stability": ("scene", "engine", "stability", "reason"),
    "hard": ("scene", "limit_s", "amplification", "condition_high"),
    "cost": (
        "scene", "engine", "setting", "outcome", "attitude_error_rad", "reaction_error_N", "com_error_m", "seconds",
        "steps",
    ),
    "orders": ("scene", "engine", "against", "order", "order_low", "order_high", "theory", "points"),
    "reach": (
        "scene", "engine", "target", "status", "cost", "over_baseline", "over_baseline_low", "over_baseline_high",
    ),
    "releases": (
        "engine", "version", "released", "state", "reason", "digits", "verdicts", "wheel_MB", "import_s", "at", "ratio",
    ),
}  # fmt: skip
"""Columns of each table; numbers have three digits"""
WORDS = (
    "scene", "engine", "source", "setting", "outcome", "reason", "stability", "against", "status", "version",
    "released", "state", "digits", "verdicts", "at",
)  # fmt: skip
RUNS = "runs.json"
FACTS = ("barchain", "created", "command", "seconds", "environment", "packages")


def write_table(name: str, rows: Iterable[Mapping[str, Any]]) -> None:
    """Write a table of the record, rows in the order given."""
    frame = pd.DataFrame(list(rows), columns=list(COLUMNS[name]))
    RECORD.mkdir(parents=True, exist_ok=True)
    write_atomically(RECORD / f"{name}.csv", frame.to_csv(index=False, float_format=DIGITS, lineterminator="\n"))


def read_table(name: str) -> pd.DataFrame:
    """Table of the record; without rows if it was not measured."""
    path = RECORD / f"{name}.csv"
    if not path.exists():
        return pd.DataFrame(columns=list(COLUMNS[name]))
    found = pd.read_csv(path, dtype=dict.fromkeys(WORDS, str), keep_default_na=False, na_values={
        c: [""] for c in COLUMNS[name] if c not in WORDS
    })  # fmt: skip
    return found[list(COLUMNS[name])]


def read_runs() -> dict[str, dict[str, Any]]:
    """Facts of the runs behind each table, by its stage."""
    path = RECORD / RUNS
    found: dict[str, dict[str, Any]] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return found


def note_run(stage: str, record: Mapping[str, Any]) -> None:
    """Keep version, day, command and machine of the runs behind a stage's tables."""
    facts = {key: record[key] for key in FACTS if key in record}
    facts["created"] = str(facts["created"])[:10]
    facts["seconds"] = round(float(facts["seconds"]))
    RECORD.mkdir(parents=True, exist_ok=True)
    write_atomically(RECORD / RUNS, json.dumps(read_runs() | {stage: facts}, indent=1, sort_keys=True) + "\n")
