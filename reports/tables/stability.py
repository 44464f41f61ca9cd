"""Rows of a stability study, as the tables that its page is rendered from.

``outcomes``
    a row for each scene and engine;
``evidence``
    a row for each of their runs;
``laws``
    power laws of drifts and differences in time, in long scenes;
``plain``
    SciPy's solvers at their own default tolerances;
``long``
    the drifts and differences of the laws over time, a series, beside
    ``trajectories/<scene>/<engine>[.coarse|.finer]``, one row per sample; ``solution`` is the reference solution.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, RUNS_FOLLOWED, Followed, Rows, add_runs
from reports.tables.schema import RunsRecord
from reports.tables.table import Number, Table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from reports.tables.files import Frames


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


TABLES = {
    "outcomes": Table(
        ("scene", "engine"),
        "class",
        {"outcome": "stability", "reason": "reason", "text": "expected"},
        numbers={  # ``at_end (t/T)^exponent`` is the law of a drift
            "exponent": Number("", "drift_exponent", "1", "low", "high", "quantity"),
            "at_end": Number("", "drift_at_end"),
        },
        words=("change",),  # from the recorded class; empty without a record, and without a change
        flags=("slow",),  # whether the outcome depends on the machine's speed
    ),
    "evidence": Table(
        ("scene", "engine", "level", "setting"),
        "run",
        {"outcome": "run", "reason": "reason"},
        numbers={
            # largest difference from the reference solution up to its predictability limit
            "attitude_rad": Number("attitude", "max", "rad"),
            "normalised_error": Number("", "normalised_error", text="normalised_error_of"),
            "bound_ratio": Number("", "bound_ratio", text="bound_of"),
            "limit_s": Number("", "predictability_limit", "s"),
            "gap_m": Number("gap", "drift", "m"),
            "energy": Number("energy", "drift"),
            "angular_momentum": Number("angular_momentum", "drift"),
            "energy_exponent": Number("energy", "exponent"),
            # largest kinetic energy about the centre of mass, relative to its upper bound
            "kinetic_ratio": Number("kinetic_energy", "bound_ratio"),
            # growth of a departure relative to the error amplification of the scene
            "growth_excess": Number("growth", "excess"),
            "steps": Number("steps", COUNT),
            "mean_step_s": Number("step", "mean", "s"),
            "simulate_s": Number("simulate", "seconds", "s"),
        },
    ),
    "laws": Table(
        ("scene", "engine", "level", "setting", "quantity"),
        "law_exponent",
        {"value": "exponent", "low": "low", "high": "high"},
        numbers={"at_end": Number("", "law_at_end")},
    ),
    "plain": Table(
        ("scene", "engine"),
        "plain_run",
        {"outcome": "run", "reason": "reason"},
        numbers={
            "attitude_rad": Number("attitude", "plain_max", "rad", text="judged"),
            "seconds": Number("simulate", "plain_seconds", "s"),
        },
    ),
}
SERIES = ("scene", "engine", "level", "quantity", "t_s", "value")
FOLLOWED = RUNS_FOLLOWED | {
    "class": Followed("verdict"),
    "run": Followed("verdict", "{metric}.{level}"),
}


def runs_of(tables: Frames, record: Mapping[str, Any]) -> Rows:
    """Rows of all runs."""
    del tables
    found = Rows(FILES.study)
    add_runs(found, record)
    return found


FILES = StudyFiles(
    "stability",
    TABLES,
    {"long": SERIES},
    followed=FOLLOWED,
    derived=runs_of,
    model=RunsRecord,
    title="Numerical stability on hard scenes",
    view="stability:view_stability",
)
read_stability = FILES.contents
