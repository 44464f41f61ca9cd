"""Cells of the stability matrix and rows of evidence, for the page and the terminal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.stability import Stability
from reports.text.numerals import SUPERSCRIPTS, number, significant

if TYPE_CHECKING:
    import pandas as pd

SIGNS = {
    Stability.STABLE: "✓",
    Stability.DRIFTING: "↗",
    Stability.INACCURATE: "≠",
    Stability.UNSTABLE: "⇈",
    Stability.FAILED: "✗",
    Stability.REJECTED: "⊘",
    Stability.UNSUPPORTED: "–",
}
KINDS = {
    Stability.STABLE: "pass",
    Stability.DRIFTING: "gone",
    Stability.INACCURATE: "fail",
    Stability.UNSTABLE: "fail",
    Stability.FAILED: "fail",
    Stability.REJECTED: "gone",
    Stability.UNSUPPORTED: "aside",
}
LATE = "◷"
CHANGES = {"better": "↑ better", "worse": "↓ worse"}


@dataclass(frozen=True)
class EngineStability:
    """Outcome of one engine in one scene."""

    scene: str
    engine: str
    stability: Stability
    slow: bool
    reason: str
    expected: str
    change: str
    exponent: float | None

    @property
    def sign(self) -> str:
        """Symbol of the outcome."""
        return LATE if self.slow else SIGNS[self.stability]

    @property
    def word(self) -> str:
        """Name of the outcome; ``timed out`` of a run ended at its time limit."""
        return "timed out" if self.slow else str(self.stability)

    @property
    def below(self) -> str:
        """Second line of the cell: the exponent of a drift."""
        return "" if self.exponent is None else f"t{raised(self.exponent, 1)}"

    @property
    def kind(self) -> str:
        """Class of its colour."""
        return "gone" if self.slow else KINDS[self.stability]

    @property
    def changed(self) -> str:
        """``↓ worse, was stable``; empty without a change."""
        return f"{CHANGES[self.change]}, was {self.expected}" if self.change else ""


@dataclass(frozen=True)
class SceneRows:
    """One scene: its outcomes, and the evidence."""

    name: str
    about: dict[str, Any]
    outcomes: dict[str, EngineStability]
    evidence: tuple[dict[str, Any], ...]

    @property
    def facts(self) -> dict[str, str]:
        """Recorded facts of the scene and its reference solution, in words."""
        return {k: v for k, v in scene_facts(self.about).items() if v}


def outcomes(table: pd.DataFrame) -> dict[tuple[str, str], EngineStability]:
    """Outcomes by scene and engine."""
    return {(str(r["scene"]), str(r["engine"])): outcome({str(k): v for k, v in r.items()}) for r in records(table)}


def outcome(row: dict[str, Any]) -> EngineStability:
    """Outcome of a row of outcomes.csv."""
    found = Stability(row["stability"])
    names = ("scene", "engine", "reason", "expected", "change")
    scene, engine, reason, expected, change = (str(row[n]) for n in names)
    return EngineStability(scene, engine, found, bool(row["slow"]), reason, expected, change, known(row["exponent"]))


def records(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of a table, empty numbers as None."""
    rows = table.to_dict("records")
    return [{str(k): None if isinstance(v, float) and math.isnan(v) else v for k, v in r.items()} for r in rows]


def raised(exponent: float, digits: int = 2) -> str:
    """``⁰·⁹⁸``, for text where no markup can go."""
    return f"{exponent:.{digits}f}".translate(SUPERSCRIPTS).replace(".", "·")


def known(value: object) -> float | None:
    """Number in a table, None for an empty cell."""
    found = number(value)
    return None if found is None or math.isnan(found) else found


def scene_facts(about: dict[str, Any]) -> dict[str, str]:
    """Facts of a scene by name; empty without a record."""
    predictability_limit, duration = known(about.get("solution_limit_s")), known(about.get("duration_s"))
    whole = (
        predictability_limit is not None
        and duration is not None
        and (predictability_limit >= duration or bool(about.get("ended")))
    )
    condition = about.get("condition")
    rate, amplification, error = (
        known(about.get(k)) for k in ("growth_rate_per_s", "growth_total", "solution_error_rad")
    )
    return {
        "Tags": ", ".join(about.get("tags") or ()),
        "Bars": str(about.get("bars", "")),
        "Run": run_words(about),
        "Reference solution": solution_words(about, error),
        "Predictability limit": ""
        if predictability_limit is None
        else "the whole run"
        if whole
        else f"{predictability_limit:.6g} s",
        "Error amplification": "" if amplification is None else f"{amplification:.2g} times" + rate_words(rate),
        "Condition of the joint system": "" if not condition else f"{condition[0]:.2g} to {condition[1]:.2g}",
    }


def run_words(about: dict[str, Any]) -> str:
    """``5492 s (1 × the period), 201 samples``."""
    duration, period = known(about.get("duration_s")), known(about.get("period_s"))
    if duration is None:
        return ""
    orbits = f" ({duration / period:.3g} × the period)" if period else ""
    ended = f"; {about['ended']}" if about.get("ended") else ""
    return f"{duration:.6g} s{orbits}, {about.get('samples')} samples{ended}"


def solution_words(about: dict[str, Any], error: float | None) -> str:
    """Engine, setting and accuracy of the reference solution."""
    if about.get("solution_failed"):
        return f"none: {about['solution_failed']}"
    if error is None:
        return ""
    steps = known(about.get("solution_steps"))
    counted = f", {steps:.0f} steps" if steps else ""
    run = f"{about.get('solution_engine')} at {about.get('solution_setting')}"
    return f"{run}{counted}, attitude error {significant(error, 2)} rad"


def rate_words(rate: float | None) -> str:
    """Clause on the linear growth rate; empty without any."""
    return "" if rate is None else f", as e^(t / {1.0 / rate:.4g} s) while it is small"
