"""Words of what is wrong in equations of motion: anchors of conventions, names, and factors of right values."""

from __future__ import annotations

import math

from barchain.judge.diagnosis.fitted import factor_words as number_words

GRAVITY, LOADS, BODIES = "gravity", "loads", "masses-lengths-and-inertia"
"""Anchors of the conventions that equations of motion break"""
FACTORS = {
    0.0: "missing", -1.0: "of the opposite sign", 0.5: "half the right value", 2.0: "twice the right value",
    math.degrees(1.0): "180/pi times the right value, as if per degree",
    math.radians(1.0): "pi/180 times the right value, as if per radian",
}  # fmt: skip
"""Factors of a right value that have words"""
UNIT_POWERS = (-9, -6, -3, -2, 2, 3, 6, 9)
"""Powers of ten that a slip of units gives"""
NICE = 1e-4
"""Difference from a number that has words, relative to it, below which a fitted number is that number"""


def nice_factor(factor: float) -> str:
    """Words of a factor that a slip would give; empty for another one."""
    power = round(math.log10(factor)) if factor > 0.0 else 0
    if power in UNIT_POWERS and abs(factor / 10.0**power - 1.0) <= NICE:
        return f"1e{power} times the right value, as in other units"
    return next((said for nice, said in FACTORS.items() if abs(factor - nice) <= NICE * max(abs(nice), 1.0)), "")


def near_one(factor: float) -> str:
    """Factor as text, with three digits of its departure from 1 where that is small."""
    departure = abs(factor - 1.0)
    digits = 3 - math.floor(math.log10(departure)) if 0.0 < departure < 1.0 else 7
    return f"{factor:.{min(max(digits, 7), 14) - 1}g}"


def factor_words(factor: float) -> str:
    """Words after "is" for a factor of the right value."""
    return nice_factor(factor) or f"{number_words(factor)} times the right value"


def named(label: str) -> str:
    """Name of a label: its words with hyphens."""
    return "-".join(label.removeprefix("the ").replace("'", "").lower().split())
