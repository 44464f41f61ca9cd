"""Units in the header of a table: ``h``, ``km/s``, ``deg/s``, ``N m``."""

from __future__ import annotations

import math
import re
from collections import Counter

from scenarios.nearest import nearest

DEGREE = math.pi / 180.0
PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6}
ATOMS: dict[str, tuple[float, str]] = {
    f"{prefix}{unit}": (size, unit) for unit in ("m", "s", "rad", "N") for prefix, size in PREFIXES.items()
} | {
    "min": (60.0, "s"), "h": (3600.0, "s"), "d": (86400.0, "s"), "ft": (0.3048, "m"), "AU": (1.495978707e11, "m"),
    "deg": (DEGREE, "rad"), "mdeg": (1e-3 * DEGREE, "rad"), "°": (DEGREE, "rad"), "gon": (math.pi / 200.0, "rad"),
    "arcmin": (DEGREE / 60.0, "rad"), "arcsec": (DEGREE / 3600.0, "rad"), "mas": (1e-3 * DEGREE / 3600.0, "rad"),
    "rev": (2.0 * math.pi, "rad"), "lbf": (4.4482216152605, "N"),
}  # fmt: skip
"""Factor to the SI unit, and that unit; ``orbit`` is the scene's own period"""
WORDS = {
    "degree": "deg", "degrees": "deg", "degs": "deg", "radian": "rad", "radians": "rad", "rads": "rad", "sec": "s",
    "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "millisecond": "ms", "milliseconds": "ms", "usec": "us",
    "microsecond": "us", "microseconds": "us", "nsec": "ns", "nanosecond": "ns", "nanoseconds": "ns", "hour": "h",
    "hours": "h", "hr": "h", "hrs": "h", "minute": "min", "minutes": "min", "mins": "min", "day": "d", "days": "d",
    "meter": "m", "metre": "m", "meters": "m", "metres": "m", "kilometer": "km", "kilometers": "km", "kilometre": "km",
    "kilometres": "km", "feet": "ft", "newton": "N", "newtons": "N", "revs": "rev", "revolution": "rev",
    "revolutions": "rev", "turn": "rev", "turns": "rev", "cycle": "rev", "cycles": "rev", "arcseconds": "arcsec",
    "arcminutes": "arcmin", "orbits": "orbit", "Nm": "N m", "mNm": "mN m", "kNm": "kN m", "Ns": "N s", "mNs": "mN s",
    "rpm": "rev/min", "mps": "m/s", "kmps": "km/s", "dps": "deg/s", "per": "/",
}  # fmt: skip
MOST_POWER = 3
"""Largest power in a unit: no quantity has a higher one"""
MOST_CHARACTERS = 60
"""Of a unit"""
SAME = str.maketrans({"μ": "µ", "º": "°", "˚": "°", "−": "-", "²": "^2", "⁻": "^-", "¹": "1", "⋅": "·", "×": "·"})
"""Characters that look alike; of powers too"""
ATOM = r"(/?)\s*([^\s/*·^\d-]+)\^?(-?[0-9]*)"
"""A unit with its power, and whether it is divided by"""


class UnitError(ValueError):
    """A unit that is not known, or of another quantity; the message is one line."""


def factor(given: str, wanted: str, orbit_s: float) -> float:
    """Factor from a unit to an SI unit of the same quantity.

    Parameters
    ----------
    given : str
        As in a header: ``deg/s``, ``km``, ``N*m``, ``m s^-1``.
    wanted : str
        SI unit in the same form.
    orbit_s : float
        Period that the unit ``orbit`` stands for, s.

    Raises
    ------
    UnitError
        If the unit is not known, or does not measure that quantity.
    """
    found, kind = parsed(given, orbit_s)
    _, needed = parsed(wanted, orbit_s)
    if kind != needed:
        raise UnitError(f"the unit {given} given, allowed: {wanted} or another unit of the same quantity")
    return found


def is_unit(text: str) -> bool:
    """Whether a cell below a header is a unit, in brackets or not, or says that there is none."""
    cell = text.strip().strip("[](){}").strip()
    try:
        return cell in ("", "-", "1") or bool(parsed(cell, 1.0))
    except UnitError:
        return False


def parsed(text: str, orbit_s: float) -> tuple[float, Counter[str]]:
    """Factor of a unit to SI, and the exponents of its SI units."""
    if len(text) > MOST_CHARACTERS:
        raise UnitError(f"a unit of {len(text)} characters given, allowed: at most {MOST_CHARACTERS}")
    whole, kind, over = 1.0, Counter[str](), False
    plain = text.strip().translate(SAME).replace("**", "^")
    spelt = " ".join(spelling(word) for word in re.split(r"[\s*·.]+", plain))
    if re.sub(ATOM, "", spelt).strip():
        raise UnitError(f"the unit {text} given, allowed: units without numbers, such as km or 1/s written s^-1")
    for sign, atom, power in re.findall(ATOM, spelt):
        over = over or sign == "/"
        each, name = (orbit_s, "s") if atom == "orbit" else ATOMS.get(spelling(atom), (0.0, ""))
        if not name:
            known = [*ATOMS, "orbit"]
            raise UnitError(f"the unit {text} given{nearest(atom, known)}, allowed: {', '.join(known)}, and / and ^")
        if power == "-" or len(power) > 2 or abs(int(power or 1)) > MOST_POWER:
            raise UnitError(f"the unit {text} given, allowed: powers up to {MOST_POWER}")
        exponent = int(power or 1) * (-1 if over else 1)
        whole *= each**exponent
        kind[name] += exponent
    return whole, Counter({name: n for name, n in kind.items() if n})


def spelling(word: str) -> str:
    """Short form of a unit in words; capitals as in ``DEG`` count where nothing else has that name."""
    if word in ATOMS or word in WORDS:
        return WORDS.get(word, word)
    low = word.lower()
    return WORDS.get(low, low if low in ATOMS else word)
