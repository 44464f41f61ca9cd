"""Latest results of each engine in each scene over the nights of a history, as a results page shows them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reports.results.nights.trends import TrendCurve

FILE, TABLE = "index.html", "results.csv"


@dataclass(frozen=True)
class Measured:
    """Latest result of one figure."""

    setting: str
    """Setting of the run; of a time the error that is reached, such as ``attitude<=1e-06``"""
    quantity: str
    night: str
    """Name of the night of the result"""
    value: float | None = None
    word: str = ""
    """Of a verdict"""
    unit: str = ""
    low: float | None = None
    """Ends of the interval: of an error by its rounding, of a time by its repetitions"""
    high: float | None = None
    anchor: str = ""
    """Of a time: the engine whose time is 1"""
    reason: str = ""
    """Of a verdict: the judge's"""
    since: str = ""
    """Of a verdict: first of the nights in a row with the same word"""
    curve: TrendCurve | None = None
    """Number over the nights; None if it was the same on all of them"""
    nights: int = 0
    """Number of nights that measured it"""


@dataclass(frozen=True)
class PairResult:
    """Latest results of an engine in a scene; what was never measured is None."""

    engine: str
    scene: str
    version: str
    """Of the engine, on the night of its latest result here"""
    verdict: Measured | None
    error: Measured | None
    time: Measured | None
    worse_since: str = ""
    """Earliest night since which a figure of the pair is worse than accepted; empty if none is"""


@dataclass(frozen=True)
class Unmeasured:
    """Results that an engine lacks, for one reason."""

    engine: str
    what: str
    reason: str
    scenes: tuple[str, ...]


@dataclass(frozen=True)
class SiteFile:
    """All that a results page shows beside the facts of the latest night."""

    nights: tuple[str, ...]
    """Names of the nights that count, in their order: trends have their numbers"""
    pairs: tuple[PairResult, ...]
    """By engine and scene"""
    releases: dict[str, tuple[tuple[int, str], ...]]
    """Versions of each engine, each with the number of its first night"""
    unmeasured: tuple[Unmeasured, ...]
