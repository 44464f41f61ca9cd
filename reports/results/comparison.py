"""Stored tables of a comparison: everything that a report is rendered from.

Its rows are a table ``metrics``, one value a row. An engine in parentheses stands for several engines together, or for
a missing judging solution; the scene :data:`ALL_SCENES` for all scenes together. Its series are

``trajectories/<scene>/<engine>``
    one row per sample; ``solution`` is the judging solution;
``differences/<scene>/<engine>``
    ``t_s`` and, for each compared quantity q: ``q_difference``, ``q_tolerance`` (the explained part) and
    ``q_bound`` (the expected-error bound), each the largest over the quantity's components;
    for each drift d: ``d_drift``, ``d_bound``;
``differences/<scene>/amplification``
    ``t_s, amplification``: factor by which a small perturbation of the attitude has grown.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from reports.results.files import StudyFiles
from reports.results.outcome import Outcome, gravest
from reports.results.reading import brief, damaged
from reports.results.rows import RUNS_FOLLOWED, Followed, add_runs
from reports.results.schema import RunsRecord
from reports.results.table import Table
from scenarios.channels import UNITS

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.results.files import Lines, StudyTables
    from reports.results.rows import Rows

QUANTITY_UNITS = UNITS | {"run": ""}
"""Units of all that has rows; ``run`` is the run as a whole"""
COMPARISON = "comparison"
"""Name of the study, and of its files"""
SOLUTION, AMPLIFICATION = "solution", "amplification"
JUDGING_SOLUTION = "(judging solution)"
"""Stands in the engine column for a scene's judging solution that could not be run"""
ROUNDING = "rounding"
"""Metric: largest share of round-off, amplified by the scene, in a difference or a drift"""
EXPLAINED = "explained by: "
"""Stands before the mistakes that explain an inconsistent result, in its reason"""
PARTED_RAD = 1e-2
"""Two runs whose attitudes differ by more have parted: later samples are not compared"""
LINEAR_GROWTH = 1e16
"""Largest error amplification that is measured: a perturbation of 1e-18 rad has then grown to 0.01 rad"""
ALL_SCENES = "(all scenes)"
"""Stands in the scene column of a row about an engine in all scenes together"""


def is_engine(name: str) -> bool:
    """Whether a name in the engine column is that of one engine."""
    return bool(name) and not name.startswith("(")


ERROR = Followed("error", "{quantity}.{metric}", within=ROUNDING, trajectory=True, besides=("relative_energy",))
"""Beyond the predictability limit, where `relative_energy` is looked at, rounding decides"""
FOLLOWED = RUNS_FOLLOWED | {
    "verdict": Followed("verdict", setting=""),
    **dict.fromkeys(("max", "rms", "final", "first_orbit_max", "drift"), ERROR),
    "predictability_limit": Followed("value", trajectory=True),
}
"""Metrics that nights follow; a verdict is followed at any setting"""


def add_verdicts(found: Rows, tables: Lines, record: Mapping[str, Any]) -> None:
    """Add a verdict for each engine in a scene, its predictability limit, and its runs."""
    pairs: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for row in tables.get("metrics", ()):
        pairs.setdefault((row["scene"], row["engine"], row["setting"]), []).append(row)
    for (scene, engine, setting), rows in pairs.items():
        if is_engine(engine) and scene != ALL_SCENES:
            worst = gravest(Outcome(row["outcome"]) for row in rows)
            reason = next((row["reason"] for row in rows if row["outcome"] == worst and row["reason"]), "")
            found.add("verdict", scene=scene, engine=engine, setting=setting, outcome=str(worst), reason=reason)
            limits = [row["limit_s"] for row in rows if row["metric"] == "max" and row["quantity"] == "attitude"]
            if limits:
                found.add("predictability_limit", limits[0], "s", scene=scene, engine=engine, setting=setting)
    add_runs(found, record)


METRICS = Table(
    ("scene", "engine", "setting", "quantity", "metric"),
    "",
    {
        "value": ".value", "unit": ".unit", "tolerance": ".limit", "outcome": ".outcome", "reason": ".reason",
        "limit_s": ".until_s",
    },
    only=frozenset(QUANTITY_UNITS),
)  # fmt: skip
"""One value a row"""
METRIC_COLUMNS = METRICS.columns
FILES = StudyFiles(
    COMPARISON,
    {"metrics": METRICS},
    followed=FOLLOWED,
    add_derived=add_verdicts,
    model=RunsRecord,
    report=("index.html", "summary.md"),
)


def read_results(folder: Path) -> StudyTables:
    """Read a result folder.

    Raises
    ------
    FileNotFoundError
        If it holds no comparison.
    DamagedResultsError
        If one of them is damaged, has another form, or belongs to another run than the other.
    SchemaVersionError
        If the record has another schema version.
    """
    if not FILES.has_record(folder):
        raise FileNotFoundError(f"{folder}: no comparison there; give a folder that compare or crossval wrote")
    found = FILES.contents(folder)
    path, metrics = folder / FILES.rows_name, found.metrics
    unknown = metrics[~metrics["outcome"].isin(list(Outcome))]
    if len(unknown):
        raise damaged(path, f"{brief(unknown['outcome'].iloc[0])[:40]!r} in row {unknown.index[0] + 1} is no outcome")
    passed = metrics[metrics["outcome"] == Outcome.PASS.value]
    empty = passed[~np.isfinite(passed["value"].to_numpy(float))]
    if len(empty):
        raise damaged(path, f"row {empty.index[0] + 1} passed without a number")
    return found
