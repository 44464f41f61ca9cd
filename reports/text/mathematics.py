"""Typographic form of formulas typed in ASCII, as text that can be searched and copied."""

from __future__ import annotations

import re

from reports.text.numerals import number

GREEK = {
    "alpha": "α",
    "beta": "β",
    "gamma": "γ",
    "epsilon": "ε",
    "lambda": "λ",
    "mu": "μ",
    "omega": "ω",
    "phi": "φ",
    "pi": "π",
    "rho": "ρ",
    "theta": "θ",
}
RAISED = dict(zip("0123456789+-()np", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾ⁿᵖ", strict=True))
ROUND_OFF = 1e-12  # relative effects below it are zero up to round-off
AS_NONE = "0 (to round-off)"

LETTER = re.compile(rf"(?<![\w-])({'|'.join(GREEK)})(?![^\W_])")  # a name like generalized-alpha stays
ROOT = re.compile(r"sqrt\((\w+)\)")
POWER = re.compile(r"\^(\([-+\dnp]+\)|-?[\dnp]+)")
TIMES_TEN = re.compile(r"(?<![\w.=])(?<!= )(\d+(?:\.\d+)?)e([+-]?\d+)\b")  # a setting like rtol = 1e-13 is typed so
PRIMES = re.compile(r"(?<=[A-Za-zα-ω])''")
LEADING_MINUS = re.compile(r"(?:(?<=^)|(?<= )|(?<=\())-(?=[\d(α-ω ])")


def written(text: str) -> str:
    """Typographic form of a text: ``3 n^2 sin(phi)`` becomes ``3 n² sin(φ)``; text without formulas is unchanged."""
    text = TIMES_TEN.sub(power_of_ten, text)
    text = LETTER.sub(lambda m: GREEK[m[1]], text)
    text = PRIMES.sub("″", ROOT.sub(r"√\1", text))
    text = POWER.sub(lambda m: raised(m[1]), text)
    return LEADING_MINUS.sub("−", text).replace(">=", "≥").replace("<=", "≤")


def power_of_ten(found: re.Match[str]) -> str:
    """``5×10⁴``; ``10⁸`` for a mantissa of 1."""
    power = "10" + raised(str(int(found[2])))
    return power if found[1] == "1" else f"{found[1]}×{power}"


def raised(text: str) -> str:
    """Superscripts."""
    return "".join(RAISED[c] for c in text)


def written_row(row: dict[str, object]) -> dict[str, object]:
    """Row of a table with formulas of its texts in typographic form; numbers stay."""
    return {k: written(v) if isinstance(v, str) else v for k, v in row.items()}


def effect(value: object) -> str | float | None:
    """Relative effect as a number; in words if it is zero up to round-off."""
    found = number(value)
    return AS_NONE if found is not None and abs(found) < ROUND_OFF else found
