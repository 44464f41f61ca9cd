"""Numbers as text: significant digits, powers of ten, SI prefixes, times and ratios."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

SMALLEST_PLAIN = 1e-3  # below it, zeros after the point take longer to count than a power of ten to read
MOST_DIGITS = 15  # that any double gives back
LARGEST_COUNT = 1e9  # whole numbers below it are counts, and written out
PREFIXES = (
    (1e9, "G"),
    (1e6, "M"),
    (1e3, "k"),
    (1.0, ""),
    (1e-3, "m"),
    (1e-6, "µ"),
    (1e-9, "n"),
    (1e-12, "p"),
)
Spread = tuple[float | None, float | None, float | None]
"""Number, lower and upper end of its interval"""
PADDED = re.compile(r"(?<![\w.])(\d[\d.]*e)(?:\+|(-))0*(\d+)\b")
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: object) -> float | None:
    """Float of a value; None if it is not a number (NaN is a number)."""
    if isinstance(value, bool) or value is None:
        return None
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None


def typed(value: float | None, digits: int = 3) -> str:
    """``0.0112``, ``5.40e-7``, ``NaN`` as a number is typed; empty for None."""
    if value is None:
        return ""
    if not math.isfinite(value):
        return "NaN" if math.isnan(value) else "inf" if value > 0 else "-inf"
    if value == 0.0:
        return "0"
    text = f"{value:#.{digits}g}"  # the one rounding: 999.6 becomes 1.00e3 here, never 1000 and 999 by turns
    if "e" in text or abs(value) < SMALLEST_PLAIN:
        return unpadded(f"{value:.{digits - 1}e}")
    return text.rstrip(".")


def significant(value: float | None, digits: int = 3) -> str:
    """``0.0112``, ``5.40×10⁻⁷``, ``NaN``, the same on pages and in plain text; empty for None."""
    return typographic(typed(value, digits))


def typeset(value: float | None, digits: int = 3) -> str:
    """``−5.40×10⁻⁷``, ``∞`` as on a page, with a true minus."""
    return powers(typed(value, digits))


def digits_apart(values: Iterable[float], least: int = 3) -> int:
    """Digits in which values differ from each other by three of their own: ``6667213`` and ``6667670`` need seven.

    They are at least `least`, and no more than a double has.
    """
    known = [value for value in values if math.isfinite(value)]
    size, spread = max(map(abs, known), default=0.0), max(known, default=0.0) - min(known, default=0.0)
    if not spread:
        return least
    return min(max(least, math.floor(math.log10(size)) - math.floor(math.log10(spread)) + 3), MOST_DIGITS)


def typographic(text: str) -> str:
    """``5.40×10⁻⁷`` of ``5.40e-7``, ``10⁻⁸`` of ``1e-8``; a text without an exponent is unchanged."""
    mantissa, e, exponent = text.partition("e")
    if not e:
        return text
    power = power_of_ten(int(exponent))
    return f"{mantissa[:-1]}{power}" if mantissa in ("1", "-1") else f"{mantissa}×{power}"


def powers(text: str) -> str:
    """Number given as text, as :func:`typeset`."""
    return typographic(text).replace("-", "−").replace("inf", "∞")


def powers_in(text: str) -> str:
    """Sentence with its powers of ten as superscripts."""
    return re.sub(r"(?<![\w.])\d[\d.]*e[-+]?\d+", lambda found: powers(found[0]), text)


def unpadded(text: str) -> str:
    """Text whose exponents have neither a plus nor zeros in front: ``rtol=1e-8`` of ``rtol=1e-08``."""
    return PADDED.sub(r"\1\2\3", text)


def power_of_ten(exponent: int) -> str:
    """``10⁻⁷``, for ticks, which take no markup."""
    return "10" + str(exponent).translate(SUPERSCRIPTS)


def prefixed(largest: float, unit: str) -> tuple[float, str]:
    """Factor and unit with an SI prefix, so that `largest` reads between 1 and 1000."""
    if not math.isfinite(largest) or largest <= 0.0 or not unit or unit == "1":
        return 1.0, unit
    size, letter = next(((s, p) for s, p in PREFIXES if largest >= 0.9995 * s), PREFIXES[-1])
    return 1.0 / size, letter + unit


def each(values: Sequence[object], unit: str) -> str:
    """``5 × 100 m`` for equal values, ``100, 60, 30 kg`` otherwise."""
    found = [v for v in map(number, values) if v is not None]
    if not found:
        return ""
    if len(set(found)) == 1:
        return f"{len(found)} × {found[0]:g} {unit}" if len(found) > 1 else f"{found[0]:g} {unit}"
    shown = ", ".join(f"{v:g}" for v in found[:12])
    return f"{shown}{', …' if len(found) > 12 else ''} {unit}"


def span(seconds: float | None) -> str:
    """``1 h 31 min 32 s`` for a duration."""
    if seconds is None or not math.isfinite(seconds):
        return ""
    if seconds < 60:
        return f"{seconds:.3g} s"
    minutes, s = divmod(round(seconds), 60)
    hours, m = divmod(minutes, 60)
    return " ".join(f"{n} {unit}" for n, unit in ((hours, "h"), (m, "min"), (s, "s")) if n)


def as_given(value: object) -> str:
    """Stored setting or count as text: whole numbers whole, words unchanged."""
    found = number(value)
    if found is None:
        return "" if value is None else str(value)
    if math.isfinite(found) and found == int(found) and abs(found) < LARGEST_COUNT:
        return f"{found:.0f}"
    digits = next((d for d in (1, 2) if float(f"{found:.{d - 1}e}") == found), 3)
    return typed(found, digits)


def given_markup(value: object) -> str:
    """Stored setting or count as on a page."""
    text, found = as_given(value), number(value)
    if found is None:
        return text
    if text.lstrip("-").isdigit():
        return f"{found:,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    return powers(text)


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
