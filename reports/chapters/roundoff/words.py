"""Numbers of a round-off study in words: powers of ten as text, lengths with prefixes, laws in units of u."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.text.numerals import prefixed, typed, typographic
from reports.text.ratios import short

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.chapters.roundoff.series import ErrorLaw, RoundoffData

POWERS = {-3.0: "/ε³", -2.0: "/ε²", -1.0: "/ε", 0.0: ""}
LARGEST_PLAIN = 1e4
NBSP = "\N{NO-BREAK SPACE}"


def spelled(value: float | None, digits: int = 2) -> str:
    """``5.7×10⁻¹²``; ``0.57``; ``350``: the same in HTML and in plain text."""
    if value is None:
        return ""
    text = typed(value, digits)
    if "e" not in text:
        return text.replace("-", "\N{MINUS SIGN}")
    if 1.0 <= abs(value) < LARGEST_PLAIN:
        return f"{float(text):.0f}"
    return typographic(text)


def length(metres: float) -> str:
    """``24 m``; ``0.15 mm``."""
    factor, unit = prefixed(metres, "m")
    return f"{short(metres * factor)}{NBSP}{unit}"


def size(study: RoundoffData, ratio: float | None) -> str:
    """Length of a bar of a size ratio: ``64 m``; the ratio itself without named objects."""
    if ratio is None:
        return ""
    metres = study.metres
    return f"ε = {spelled(ratio)}" if metres is None else length(ratio * metres)


def unit_text(law: ErrorLaw) -> str:
    """``0.57 u/ε``."""
    return f"{spelled(law.constant)}{NBSP}u{POWERS.get(law.expected, f' ε^{law.expected:g}')}"


def between(values: Sequence[float], digits: int = 2) -> str:
    """``3.4×10⁻¹⁴ to 4.3×10⁻¹⁴``, or one number if both agree."""
    low, high = spelled(min(values), digits), spelled(max(values), digits)
    return low if low == high else f"{low} to {high}"
