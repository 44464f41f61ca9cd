"""Units in the header of a table: ``h``, ``km/s``, ``deg/s``, ``N m``."""

from __future__ import annotations

import math
import re
from collections import Counter

from scenarios.nearest import nearest

DEGREE = math.pi / 180.0
ATOMS: dict[str, tuple[float, str]] = {
    "m": (1.0, "m"), "mm": (1e-3, "m"), "cm": (1e-2, "m"), "km": (1e3, "m"),
    "s": (1.0, "s"), "ms": (1e-3, "s"), "min": (60.0, "s"), "h": (3600.0, "s"), "d": (86400.0, "s"),
    "rad": (1.0, "rad"), "mrad": (1e-3, "rad"), "deg": (DEGREE, "rad"), "°": (DEGREE, "rad"),
    "rev": (2.0 * math.pi, "rad"),
    "N": (1.0, "N"), "mN": (1e-3, "N"), "uN": (1e-6, "N"), "µN": (1e-6, "N"), "kN": (1e3, "N"),
}  # fmt: skip
"""Factor to the SI unit, and that unit; ``orbit`` is the scene's own period"""
WORDS = {
    "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "sec": "s", "second": "s", "seconds": "s",
    "hour": "h", "hours": "h", "hr": "h", "minute": "min", "minutes": "min", "day": "d", "days": "d",
    "meter": "m", "metre": "m", "meters": "m", "metres": "m", "orbits": "orbit", "Nm": "N m", "mNm": "mN m",
    "kNm": "kN m", "Ns": "N s", "rpm": "rev/min",
}  # fmt: skip


ATOM = r"(/?)\s*([^\s/*·^\d-]+)\^?(-?\d*)"
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


def parsed(text: str, orbit_s: float) -> tuple[float, Counter[str]]:
    """Factor of a unit to SI, and the exponents of its SI units."""
    whole, kind, over = 1.0, Counter[str](), False
    spelt = " ".join(WORDS.get(word, word) for word in re.split(r"[\s*·.]+", text.strip()))
    spelt = spelt.replace("²", "^2").replace("⁻¹", "^-1")
    if re.sub(ATOM, "", spelt).strip():
        raise UnitError(f"the unit {text} given, allowed: units without numbers, such as km or 1/s written s^-1")
    for sign, atom, power in re.findall(ATOM, spelt):
        over = over or sign == "/"
        each, name = (orbit_s, "s") if atom == "orbit" else ATOMS.get(WORDS.get(atom, atom), (0.0, ""))
        if not name:
            known = [*ATOMS, "orbit"]
            raise UnitError(f"the unit {text} given{nearest(atom, known)}, allowed: {', '.join(known)}, and / and ^")
        exponent = int(power or 1) * (-1 if over else 1)
        whole *= each**exponent
        kind[name] += exponent
    return whole, Counter({name: n for name, n in kind.items() if n})
