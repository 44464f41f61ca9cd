"""Rows of an effect budget as the page, the charts and the advice see them."""

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
"""Of gravity, each richer than the one before"""
FEWEST_ROUNDS = 3  # whose range tells anything: it holds the median with 1 - 2^(1-n), 75 %; of two with a half


@dataclass(frozen=True)
class Change:
    """What switching an effect changed in one quantity, as a share of that quantity's scale."""

    name: str
    value: float
    """SI units"""
    noise: float
    """What the numerics may have made of it, alike"""
    scale: float
    """What counts as 1: the initial distance, one radian, the largest reaction; 0 where that is not known"""

    @property
    def resolved(self) -> bool:
        """Whether the numerics can't have made it."""
        return self.value > self.noise

    @property
    def bound(self) -> float:
        """The change, or what it is below."""
        return self.value if self.resolved else self.noise

    @property
    def share(self) -> float:
        """The bound over its scale."""
        return self.bound / self.scale if self.scale else math.inf


@dataclass(frozen=True)
class Ratio:
    """A time with an effect over that without it, and where it lies."""

    value: float | None
    low: float | None = None
    """None where it was measured fewer than :data:`FEWEST_ROUNDS` times"""
    high: float | None = None

    @property
    def known(self) -> bool:
        """Whether the clock tells it from 1."""
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
    """Why it was not switched; empty if it was"""
    caveat: str
    """What its default can't tell in this scene, in a sentence"""
    engine: str
    sizes: dict[str, tuple[float | None, float | None]]
    """At the start, and the largest over the run"""
    changes: tuple[Change, ...]
    compared_s: float | None
    ended: str
    time: Ratio
    evaluation: Ratio
    evaluations_ratio: float | None
    evaluation_s: float | None

    def change(self, name: str) -> Change | None:
        """Change of one quantity."""
        return next((c for c in self.changes if c.name == name), None)

    @property
    def model(self) -> str:
        """Model of gravity that it stands for."""
        return self.effect.removeprefix("gravity.") if self.kind is EffectKind.GRAVITY else ""

    @property
    def state(self) -> str:
        """Whether the scene has it: ``on``, ``off``, or what it would be instead of."""
        return self.said if self.kind is EffectKind.GRAVITY else "on" if self.on else "off"

    @property
    def rest(self) -> float | None:
        """What of the run's ratio lies between evaluations: the search for instants, steps begun anew there.

        None where the clock does not tell the ratio.
        """
        factors = self.time.value, self.evaluation.value, self.evaluations_ratio
        if None in factors or not self.time.known:
            return None
        run, one, number_of = (f or 0.0 for f in factors)
        return run / (one * number_of) if one * number_of else None


@dataclass(frozen=True)
class Whole:
    """The scene as it is."""

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
    """Of timing"""
    timed_s: float
    """Part of the run that was timed"""


def whole_of(record: dict[str, Any]) -> Whole:
    """What the record says of the scene as it is."""
    scene = mapping(record.get("scene"))

    def value(key: str) -> float:
        return number(scene.get(key)) or 0.0

    def limit(key: str) -> float:
        return number(record.get(key)) or 0.0

    return Whole(
        str(scene.get("name") or ""), str(scene.get("gravity") or ""), bool(scene.get("bound")), value("period_s"),
        value("duration_s"), value("limit_s"), value("end_s"), str(scene.get("ended") or ""),
        {"com": value("radius0_m"), "attitude": 1.0, "reaction": value("largest_reaction_N")},
        limit("matters"), limit("rtol"), limit("looser"), limit("parted_rad"),
        int(limit("rounds")), limit("timed_s") or value("duration_s"),
    )  # fmt: skip


def rows_of(tables: EffectsTables, whole: Whole) -> list[EffectRow]:
    """All effects of a budget."""
    return [row_of(r, whole) for r in tables.effects.to_dict("records")]


def row_of(found: dict[Any, Any], whole: Whole) -> EffectRow:
    """One row of effects.csv."""

    def value(key: str) -> float | None:
        known = number(found.get(key))
        return known if known is not None and math.isfinite(known) else None

    def ratio(key: str, measured: float) -> Ratio:
        spread = (value(f"{key}_low"), value(f"{key}_high")) if measured >= FEWEST_ROUNDS else (None, None)
        return Ratio(value(key), *spread)

    changes = [(q, value(f"{q}_{UNITS[q]}"), value(f"{q}_noise_{UNITS[q]}")) for q in QUANTITIES]
    return EffectRow(
        str(found["effect"]), str(found["title"]), EffectKind(found["kind"]), bool(found["on"]), str(found["said"]),
        str(found["reason"]), str(found["caveat"]), str(found["engine"]),
        {name: (value(f"{name}_start"), value(f"{name}_largest")) for name in SIZES},
        tuple(Change(q, v, n, whole.scales[q]) for q, v, n in changes if v is not None and n is not None),
        value("compared_s"), str(found["ended"]),
        ratio("time_ratio", value("rounds") or 0.0), ratio("evaluation_ratio", math.inf), value("evaluations_ratio"),
        value("evaluation_s"),
    )  # fmt: skip
