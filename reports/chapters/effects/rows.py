"""Rows of an effect budget: input of the page, the charts and the advice."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.tables.effects import QUANTITIES, SIZES, UNITS, EffectKind
from reports.text.numerals import number
from reports.text.record import mapping

if TYPE_CHECKING:
    from reports.tables.effects import EffectsTables

MODELS = ("none", "point", "gradient", "quadrupole", "slender")
"""Gravity models, each richer than the model before"""
FEWEST_ROUNDS = 3  # with an interval: the range of n times holds the median with 1 - 2^(1-n), of three 75 %


@dataclass(frozen=True)
class EffectChange:
    """Change of one quantity by switching an effect."""

    name: str
    value: float
    """SI units"""
    noise: float
    """Numerical error of the change, SI units"""
    scale: float
    """Scale of the quantity: initial distance, one radian, largest reaction; 0 if unknown"""

    @property
    def resolved(self) -> bool:
        """Whether the change exceeds its numerical error."""
        return self.value > self.noise

    @property
    def bound(self) -> float:
        """Resolved change, or else its upper bound, SI units."""
        return self.value if self.resolved else self.noise

    @property
    def share(self) -> float:
        """Bound relative to the scale."""
        return self.bound / self.scale if self.scale else math.inf


@dataclass(frozen=True)
class Ratio:
    """Time with an effect relative to the time without it, and its interval."""

    value: float | None
    low: float | None = None
    """None with fewer than :data:`FEWEST_ROUNDS` rounds"""
    high: float | None = None

    @property
    def known(self) -> bool:
        """Whether the interval excludes 1."""
        return self.low is not None and self.high is not None and not self.low <= 1.0 <= self.high


@dataclass(frozen=True)
class EffectRow:
    """One effect."""

    effect: str
    title: str
    kind: EffectKind
    on: bool
    said: str
    reason: str
    """Reason for not switching it; empty if it was switched"""
    caveat: str
    """Limitation of its default in this scene, in a sentence"""
    widths_m: tuple[float, float] | None
    """Least and largest width of the bars; None for an effect without one"""
    engine: str
    sizes: dict[str, tuple[float | None, float | None]]
    """Sizes at the start, and largest over the run"""
    changes: tuple[EffectChange, ...]
    compared_s: float | None
    ended: str
    time: Ratio
    evaluation: Ratio
    evaluations_ratio: float | None
    evaluation_s: float | None

    def change(self, name: str) -> EffectChange | None:
        """Change of one quantity."""
        return next((c for c in self.changes if c.name == name), None)

    @property
    def model(self) -> str:
        """Gravity model that the row stands for; empty for an effect."""
        return self.effect.removeprefix("gravity.") if self.kind is EffectKind.GRAVITY else ""

    @property
    def state(self) -> str:
        """State in the scene: ``on``, ``off``, or the gravity model that it replaces."""
        return self.said if self.kind is EffectKind.GRAVITY else "on" if self.on else "off"

    @property
    def rest(self) -> float | None:
        """Factor of the run time due to work between evaluations: event search and restarted steps.

        None if the run's ratio is not resolved.
        """
        factors = self.time.value, self.evaluation.value, self.evaluations_ratio
        if None in factors or not self.time.known:
            return None
        run, one, number_of = (f or 0.0 for f in factors)
        return run / (one * number_of) if one * number_of else None


@dataclass(frozen=True)
class BudgetScope:
    """Scene, thresholds and settings of a budget."""

    name: str
    gravity: str
    bound: bool
    period_s: float
    duration_s: float
    limit_s: float
    end_s: float
    ended: str
    scales: dict[str, float]
    matters: float
    rtol: float
    looser: float
    parted_rad: float
    rounds: int
    """Number of timing rounds"""
    timed_s: float
    """Part of the run that was timed"""


def scope_of(record: dict[str, Any]) -> BudgetScope:
    """Scope of a budget from its record."""
    scene = mapping(record.get("scene"))

    def value(key: str) -> float:
        return number(scene.get(key)) or 0.0

    def limit(key: str) -> float:
        return number(record.get(key)) or 0.0

    return BudgetScope(
        str(scene.get("name") or ""), str(scene.get("gravity") or ""), bool(scene.get("bound")), value("period_s"),
        value("duration_s"), value("limit_s"), value("end_s"), str(scene.get("ended") or ""),
        {"com": value("radius0_m"), "attitude": 1.0, "reaction": value("largest_reaction_N")},
        limit("matters"), limit("rtol"), limit("looser"), limit("parted_rad"),
        int(limit("rounds")), limit("timed_s") or value("duration_s"),
    )  # fmt: skip


def rows_of(tables: EffectsTables, scope: BudgetScope) -> list[EffectRow]:
    """All effects of a budget."""
    return [row_of(r, scope) for r in tables.effects.to_dict("records")]


def row_of(found: dict[Any, Any], scope: BudgetScope) -> EffectRow:
    """One row of effects.csv."""

    def value(key: str) -> float | None:
        known = number(found.get(key))
        return known if known is not None and math.isfinite(known) else None

    def ratio(key: str, measured: float) -> Ratio:
        spread = (value(f"{key}_low"), value(f"{key}_high")) if measured >= FEWEST_ROUNDS else (None, None)
        return Ratio(value(key), *spread)

    least, largest = value("width_least_m"), value("width_largest_m")
    changes = [(q, value(f"{q}_{UNITS[q]}"), value(f"{q}_noise_{UNITS[q]}")) for q in QUANTITIES]
    return EffectRow(
        str(found["effect"]), str(found["title"]), EffectKind(found["kind"]), bool(found["on"]), str(found["said"]),
        str(found["reason"]), str(found["caveat"]),
        None if least is None or largest is None else (least, largest), str(found["engine"]),
        {name: (value(f"{name}_start"), value(f"{name}_largest")) for name in SIZES},
        tuple(EffectChange(q, v, n, scope.scales[q]) for q, v, n in changes if v is not None and n is not None),
        value("compared_s"), str(found["ended"]),
        ratio("time_ratio", value("rounds") or 0.0), ratio("evaluation_ratio", math.inf), value("evaluations_ratio"),
        value("evaluation_s"),
    )  # fmt: skip
