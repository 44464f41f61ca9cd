"""Times and ratios as text."""

from __future__ import annotations

import math

from reports.text.numerals import power_of_ten, prefixed, significant

Spread = tuple[float | None, float | None, float | None]


def span_text(value: float | None) -> str:
    """``1.24 ms``."""
    if value is None:
        return ""
    factor, unit = prefixed(value, "s")
    return f"{significant(value * factor)} {unit}"


def ratio_text(ratio: Spread, sign: str = "×") -> str:
    """``×12 (11–13)``; an unknown interval is omitted."""
    value, low, high = ratio
    if value is None:
        return ""
    text = f"{sign}{short(value)}"
    return text if low is None or high is None else f"{text} ({short(low)}–{short(high)})"


def decade(target: float) -> str:
    """``10⁻⁴``; other numbers with two digits."""
    exponent = math.log10(target)
    return power_of_ten(round(exponent)) if abs(exponent - round(exponent)) < 1e-9 else significant(target, 2)


def short(value: float) -> str:
    """Two significant digits, three from 100 on: ``1.3``, ``13``, ``1320``."""
    if abs(value) >= 100.0:
        return f"{float(f'{value:.2e}'):.0f}"
    return significant(value, 2)
