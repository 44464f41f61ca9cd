"""Stored tables of a stability study: everything that its page is rendered from.

A folder ``stability`` inside a result folder holds

``outcomes.csv``
    a row for each scene and engine, columns :data:`OUTCOMES`;
``evidence.csv``
    a row for each of their runs, columns :data:`EVIDENCE`;
``laws.csv``
    power laws of drifts and differences in time, in long scenes, columns :data:`LAWS`;
``long.csv``
    these drifts and differences over time, columns :data:`SERIES`;
``plain.csv``
    SciPy's solvers at their own default tolerances, columns :data:`PLAIN`;
``record.json``
    environment, and the scenes in words;
``trajectories/<scene>/<engine>[.coarse|.finer].parquet``
    one row per sample; ``solution.parquet`` is the reference solution.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, RUNS_FOLLOWED, Followed, Rows, add_runs, known, records
from reports.tables.schema import RunsRecord

if TYPE_CHECKING:
    from pathlib import Path

OUTCOMES = (
    "scene", "engine", "stability", "slow", "reason",
    "quantity", "exponent", "low", "high", "at_end", "expected", "change",
)  # fmt: skip
"""`slow`: the outcome depends on the machine's speed; ``at_end (t/T)^exponent`` is the law of a drift; `expected` and
`change` are empty without a record, and without a change"""
EVIDENCE = (
    "scene", "engine", "level", "setting", "run", "reason", "attitude_rad",
    "normalised_error", "normalised_error_of", "bound_ratio", "bound_of", "limit_s",
    "gap_m", "energy", "angular_momentum", "energy_exponent", "kinetic_ratio", "growth_excess",
    "steps", "mean_step_s", "simulate_s",
)  # fmt: skip
"""`attitude_rad`: largest difference from the reference solution up to its predictability limit; `gap_m`, `energy`,
`angular_momentum`: largest drift of the run; `kinetic_ratio`: largest kinetic energy about the centre of mass, relative
to its upper bound; `growth_excess`: growth of a departure relative to the error amplification of the scene"""
LAWS = ("scene", "engine", "level", "setting", "quantity", "exponent", "low", "high", "at_end")
SERIES = ("scene", "engine", "level", "quantity", "t_s", "value")
PLAIN = ("scene", "engine", "run", "reason", "attitude_rad", "judged", "seconds")
WORDS = (
    "scene", "engine", "stability", "reason", "quantity", "expected", "change", "level", "setting", "run",
    "normalised_error_of", "bound_of", "judged",
)  # fmt: skip
TABLES = {"outcomes": OUTCOMES, "evidence": EVIDENCE, "laws": LAWS, "long": SERIES, "plain": PLAIN}


class StabilityRecord(RunsRecord):
    """Entries of the record."""

    time_limit_s: float | None = None
    scenes: dict[str, dict[str, Any]] | None = None
    engines: dict[str, str] | None = None
    references: list[str] | None = None
    left_out: list[list[str]] | None = None


FILES = StudyFiles(
    "stability",
    TABLES,
    WORDS,
    frozenset(TABLES),
    ("slow",),
    StabilityRecord,
    folders=("trajectories", "differences"),
    pages=("stability.html",),
)


class Stability(StrEnum):
    """Class of an engine's behaviour in a scene."""

    STABLE = "stable"
    DRIFTING = "drifting"
    INACCURATE = "inaccurate"
    UNSTABLE = "unstable"
    FAILED = "failed"
    REJECTED = "rejected"
    UNSUPPORTED = "unsupported"

    @property
    def advice(self) -> str:
        """Meaning of the class."""
        return ADVICE[self]


ADVICE = {
    Stability.STABLE: "Every quantity agrees with the reference solution at the default and the finer setting, and "
    "all drifts are within their bounds.",
    Stability.DRIFTING: "All quantities agree point by point, but a conserved quantity drifts beyond its bound.",
    Stability.INACCURATE: "Finite and wrong: a normalised error above 1, or an error above the expected-error bound.",
    Stability.UNSTABLE: "Finite and unstable: spurious energy, a departure that grows faster than the error "
    "amplification of the scene, or an error that grows at a finer setting.",
    Stability.FAILED: "An exception, a crash, a time-out, NaN, or another end than that of the reference solution.",
    Stability.REJECTED: "The engine rejects the scene before its first step.",
    Stability.UNSUPPORTED: "The engine does not support an effect of this scene; the pair is skipped.",
}


read_stability = FILES.contents


MEASURED = {
    "attitude_rad": ("attitude", "max", "rad"), "limit_s": ("", "predictability_limit", "s"),
    "gap_m": ("gap", "drift", "m"), "energy": ("energy", "drift", "1"),
    "angular_momentum": ("angular_momentum", "drift", "1"), "energy_exponent": ("energy", "exponent", "1"),
    "kinetic_ratio": ("kinetic_energy", "bound_ratio", "1"), "growth_excess": ("growth", "excess", "1"),
    "steps": ("steps", COUNT, "1"), "mean_step_s": ("step", "mean", "s"), "simulate_s": ("simulate", "seconds", "s"),
}  # fmt: skip
"""Quantity, metric and unit of the columns of `evidence`"""
FOLLOWED = RUNS_FOLLOWED | {
    "class": Followed("verdict"),
    "run": Followed("verdict", "{metric}.{level}"),
}


def stability_rows(folder: Path) -> Rows:
    """Rows of a stability study: classes, evidence of each run, laws of drifts, and the runs."""
    tables, found = read_stability(folder), Rows(FILES.name)
    for row in records(tables.outcomes):
        where = {name: row[name] for name in ("scene", "engine")}
        found.add("class", outcome=row["stability"], reason=row["reason"], text=row["expected"], **where)
        if known(row["exponent"]):
            ends = {"low": row["low"], "high": row["high"]}
            found.add("drift_exponent", row["exponent"], quantity=row["quantity"], **ends, **where)
    for row in records(tables.evidence):
        where = {name: row[name] for name in ("scene", "engine", "setting", "level")}
        found.add("run", outcome=row["run"], reason=row["reason"], **where)
        found.measured(row, MEASURED, **where)
        for name, of in (("normalised_error", "normalised_error_of"), ("bound_ratio", "bound_of")):
            if known(row[name]):
                found.add(name, row[name], text=row[of], **where)
    for row in records(tables.laws):
        where = {name: row[name] for name in ("scene", "engine", "setting", "quantity", "level")}
        found.add("law_exponent", row["exponent"], low=row["low"], high=row["high"], **where)
        found.add("law_at_end", row["at_end"], **where)
    for row in records(tables.plain):
        where = {name: row[name] for name in ("scene", "engine")}
        found.add("plain_run", outcome=row["run"], reason=row["reason"], **where)
        columns = {"attitude_rad": ("attitude", "plain_max", "rad"), "seconds": ("simulate", "plain_seconds", "s")}
        found.measured(row, columns, text=row["judged"], **where)
    add_runs(found, tables.folder, tables.record)
    return found
