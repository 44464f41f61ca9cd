"""Limits of what a scene file may hold: sizes, lengths and numbers, each with its reason.

A file from outside must cost no more than its own error line. Three limits that a large scene may reach have an
environment variable each, which replaces the number; the others bound words, and magnitudes beyond all physics.
"""

from __future__ import annotations

import os
from dataclasses import dataclass


class LimitError(ValueError):
    """Text, number or size beyond a limit; the message says what is given and what is allowed."""


@dataclass(frozen=True)
class SizeLimit:
    """A size that may be changed for one's own files."""

    variable: str
    """Environment variable that replaces `usual`"""
    usual: int
    unit: str

    @property
    def most(self) -> int:
        """Largest size allowed.

        Raises
        ------
        LimitError
            If the environment variable holds no whole number above zero.
        """
        given = os.environ.get(self.variable, "").strip()
        if not given:
            return self.usual
        if not (given.isascii() and given.isdecimal() and len(given) <= MOST_DIGITS and int(given) > 0):
            raise LimitError(f"{self.variable}={given[:MOST_SHOWN]!r} given, allowed: a whole number above 0")
        return int(given)

    def check(self, size: int) -> None:
        """Reject a size beyond the limit.

        Raises
        ------
        LimitError
            With both sizes, and the variable that allows more.
        """
        if size > self.most:
            shown = size if size < 10**MOST_DIGITS else f"more than 1e{MOST_DIGITS}"
            raise LimitError(
                f"{shown} {self.unit} given, allowed: at most {self.most}; "
                f"the environment variable {self.variable} allows more"
            )


FILE_BYTES = SizeLimit("BARCHAIN_MOST_FILE_BYTES", 4_000_000, "bytes")
"""Eight lists of 20 000 numbers with 17 digits, sign and exponent (25 characters each). Python reads 4 MB of TOML in
some seconds."""
BARS = SizeLimit("BARCHAIN_MOST_BARS", 100_000, "bars")
"""The largest chain that `barchain scaling` measures. A scene of 1e9 bars took 23 GB before the first check."""
VALUES = SizeLimit("BARCHAIN_MOST_VALUES", 20_000_000, "values (bars times samples)")
"""A trajectory holds eight doubles a bar and sample (angle, rate, place, velocity, reaction): 1.3 GB. A comparison
holds several."""

MOST_MAGNITUDE = 1e30
"""Of any number, in the file's units. The ratio of two quantities is at most 1e60, and its fifth power is a double.
Kepler's third law cubes a radius over a gravitational parameter (1e120); a bar's moment of inertia is a mass times the
square of a length (1e90). The mass of the Sun is 2e30 kg, but scenes take its gravitational parameter, 1.3e20 m³/s²."""
LEAST_MAGNITUDE = 1.0 / MOST_MAGNITUDE
"""Of any number but zero, for the same ratios."""

MOST_TABLES = 1000
"""Of one kind of effect. Each instant is an event: the integration stops and starts again there."""
MOST_POINTS = 10_000
"""Of a thrust's table; each interval between two points is integrated by itself."""
MOST_TITLE = 200
"""Characters: a line of a report. The longest of the shipped scenes has 83."""
MOST_SOURCE = 1000
"""Characters: some references. The longest of the shipped scenes has 108."""
MOST_DESCRIPTION = 10_000
"""Characters: four pages. The longest of the shipped scenes has 386."""
MOST_TAG = 60
"""Characters: a word. The longest of the shipped scenes has 13."""
MOST_TAGS = 50
MOST_PATH = 1000
"""Characters of a path in a scene file; file systems hold 255 bytes in each name of it."""
MOST_NAME = 200
"""Bytes of each part of a scene's name. File systems hold 255 bytes in a name, and an ending is added."""
MOST_KEY = 60
"""Characters of a key that is compared with the known keys; the longest of these has 22. The time of a comparison grows
with the product of the lengths."""

MOST_FAULTS = 20
"""Lines that tell the faults of one file; the rest is counted."""
MOST_SHOWN = 60
"""Characters of a given value in an error line."""
MOST_LINE = 1000
"""Characters of an error line."""
MOST_DIGITS = 18
"""Of a whole number in a message or a variable: 64 bits. Python writes no numbers of more than 4300 digits."""
