"""Numbers and paths as options: what every option rejects, and the largest counts, each with its reason."""

from __future__ import annotations

from typing import Any

import click

from barchain.runs.job import MOST_SECONDS

MOST_MINUTES = 10_080.0
"""A week."""
MOST_ORBITS = 1e9
"""More than any scene has: the longest shipped one has 10 000."""
MOST_WORKERS = 1024
"""Each worker is a process of some 200 MB, or a thread; more than the cores of one machine only wait."""
MOST_REPEATS = 1_000_000
"""Of a timing."""
MOST_SAMPLES = 1_000_000
"""As in a scene file."""
MOST_RUNS = 1_000_000_000
"""Of an ensemble; its memory has a limit of its own."""
MOST_BARS = 1_000_000
"""Ten times the largest chain that is measured by default."""
MOST_SEED = 2**63 - 1
"""Seeds are recorded as 64-bit numbers."""


class RealNumber(click.FloatRange):
    """Real number in a range: NaN and infinity are none."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Check a number; every comparison with NaN is false, so that a range alone lets NaN pass."""
        number = click.FLOAT.convert(value, param, ctx)
        if not abs(number) < float("inf"):
            self.fail(f"{value} given, allowed: a number in the range {self._describe_range()}.", param, ctx)
        return float(super().convert(number, param, ctx))


class NamedPath(click.Path):
    """Path of a file or folder; no text is no path."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check that there is text; an empty one would mean the current folder."""
        if str(value) in {"", "\0"} or not str(value).strip():
            self.fail("no text given, allowed: a path; . is the current folder.", param, ctx)
        return super().convert(value, param, ctx)


class Words(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.5 on
    """Text that is not empty."""

    name = "text"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Check that there is text."""
        if not str(value).strip():
            self.fail("no text given, allowed: some.", param, ctx)
        return str(value)


POSITIVE_SECONDS = RealNumber(0.0, MOST_SECONDS, min_open=True)
MINUTES = RealNumber(0.0, MOST_MINUTES)
ORBITS = RealNumber(0.0, MOST_ORBITS, min_open=True)
SEED = click.IntRange(0, MOST_SEED)
WORDS = Words()
