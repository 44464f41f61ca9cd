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

from reports.results.files import StudyFiles
from reports.results.rows import RUNS_FOLLOWED, Followed, add_runs
from reports.results.schema import RunsRecord
from reports.results.table import Table


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
        {
            "stability": ".outcome", "reason": ".reason", "expected": ".text",
            # ``at_end (t/T)^exponent`` is the law of a drift
            "exponent": "drift_exponent", "low": "drift_exponent.low", "high": "drift_exponent.high",
            "quantity": "drift_exponent.text", "at_end": "drift_at_end",
            "change": "change.text",  # from the recorded class; empty without a record, and without a change
            "slow": "slow",  # whether the outcome depends on the machine's speed
        },
        flags=("slow",),
    ),
    "evidence": Table(
        ("scene", "engine", "level", "setting"),
        "run",
        {
            "run": ".outcome", "reason": ".reason",
            # largest difference from the reference solution up to its predictability limit
            "attitude_rad": "max:attitude rad",
            "normalised_error": "normalised_error", "normalised_error_of": "normalised_error.text",
            "bound_ratio": "bound_ratio", "bound_of": "bound_ratio.text",
            "limit_s": "predictability_limit s",
            "gap_m": "drift:gap m", "energy": "drift:energy", "angular_momentum": "drift:angular_momentum",
            "energy_exponent": "exponent:energy",
            "kinetic_ratio": "bound_ratio:kinetic_energy",  # about the centre of mass, relative to its upper bound
            "growth_excess": "excess:growth",  # of a departure relative to the error amplification of the scene
            "steps": "count:steps", "mean_step_s": "mean:step s", "simulate_s": "seconds:simulate s",
        },
    ),
    "laws": Table(
        ("scene", "engine", "level", "setting", "quantity"),
        "law_exponent",
        {"exponent": ".value", "low": ".low", "high": ".high", "at_end": "law_at_end"},
    ),
    "plain": Table(
        ("scene", "engine"),
        "plain_run",
        {
            "run": ".outcome", "reason": ".reason", "attitude_rad": "plain_max:attitude rad",
            "judged": "plain_max:attitude.text", "seconds": "plain_seconds:simulate s",
        },
    ),
}  # fmt: skip
SERIES = ("scene", "engine", "level", "quantity", "t_s", "value")
FOLLOWED = RUNS_FOLLOWED | {
    "class": Followed("verdict"),
    "run": Followed("verdict", "{metric}.{level}"),
}


FILES = StudyFiles(
    "stability",
    TABLES,
    {"long": SERIES},
    followed=FOLLOWED,
    add_derived=lambda found, _, record: add_runs(found, record),
    model=RunsRecord,
    title="Numerical stability on hard scenes",
    view="stability:view_stability",
)
