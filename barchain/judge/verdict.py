"""Verdict on one engine in one scene: findings of checks, and rows of the metrics table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.results.comparison import QUANTITY_UNITS
from reports.results.outcome import Outcome, gravest

if TYPE_CHECKING:
    import pandas as pd

    from adapters.engine import Setting
    from barchain.runs.job import Role

MIN_JUDGED_SHARE = 0.1
"""Least share of the run's samples that must be judged: agreement over less says nothing about the scene"""
JUDGED_METRICS = frozenset({"normalised_error", "bound_ratio", "finer_bound_ratio", "drift", "extrapolation_ratio"})
"""Metrics that are judged by their tolerance"""
TWO_SETTING_METRICS = frozenset({"extrapolation_ratio", "finer_bound_ratio"})
"""Metrics that need the second run to be the finer one"""
UNITLESS = frozenset({
    "normalised_error", "bound_ratio", "finer_bound_ratio", "detection_limit", "judged_share", "extrapolation_ratio",
    "own_state_ratio", "restart_ratio",
})  # fmt: skip
"""Metrics that are ratios, whatever their quantity's unit"""

Row = dict[str, Any]


@dataclass(frozen=True)
class CheckFinding:
    """Answer of a check, or a reported number."""

    quantity: str
    """Compared quantity, drift, or ``run`` for the run as a whole"""
    metric: str
    value: float | None = None
    tolerance: float | None = None
    outcome: Outcome = Outcome.REPORTED
    reason: str = ""

    def row(self, scene: str, engine: str, setting: Setting | None, limit_s: float | None) -> Row:
        """Row of the metrics table; `limit_s` is the last instant at which the quantity is compared."""
        return {
            "scene": scene,
            "engine": engine,
            "setting": "" if setting is None else str(setting),
            "quantity": self.quantity,
            "metric": self.metric,
            "value": self.value,
            "unit": "1" if self.metric in UNITLESS else QUANTITY_UNITS[self.quantity],
            "tolerance": self.tolerance,
            "outcome": str(self.outcome),
            "reason": self.reason,
            "limit_s": limit_s,
        }


@dataclass(frozen=True)
class Verdict:
    """Outcome of one engine on one scene."""

    rows: list[Row]
    """Rows of the metrics table"""
    series: pd.DataFrame | None = None
    """Differences over time; None where nothing was compared"""
    further_runs: tuple[Role, ...] = ()
    """Roles of further runs that would settle an outcome; empty if the outcome is settled"""

    @property
    def outcome(self) -> Outcome:
        """Gravest outcome of all rows."""
        return gravest(Outcome(row["outcome"]) for row in self.rows)


def no_verdict(scene: str, engine: str, setting: Setting | None, outcome: Outcome, reason: str) -> Verdict:
    """Verdict of one row, on a whole run that gave nothing to compare."""
    return Verdict([CheckFinding("run", "outcome", outcome=outcome, reason=reason).row(scene, engine, setting, None)])
