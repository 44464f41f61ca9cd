"""View of a scaling study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.scaling.charts import ScalingChart, ScalingCurve, all_engines, each_family
from reports.tables.measured import spread_rows
from reports.tables.outcome import Outcome
from reports.tables.rows import tabled
from reports.tables.scaling import FILES, FITTED, POINTS
from reports.text.numerals import is_nan, number, significant
from reports.text.record import is_complete, mapping, rows

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from reports.plotting.panels import Panel

QUANTITIES = ("evaluation", "orbit", "evaluations per orbit", "steps per orbit", "memory")
SHARED = "Outlined: a part of an orbit, scaled up."
STEPS = "Outlined: time of a step, for engines that do not count evaluations."
SHOWN_MEMORY_B = 2.0**20  # allocators hide less


@dataclass(frozen=True)
class Exponent:
    """Fitted exponent of a cost."""

    value: float
    low: float
    high: float
    per: str
    points: int
    bars: tuple[int, ...]

    @property
    def text(self) -> str:
        """``1.02 (0.98 to 1.06)``, with true minuses and no negative zero."""
        value, low, high = (f"{v:z.2f}".replace("-", "\N{MINUS SIGN}") for v in (self.value, self.low, self.high))
        return f"{value} ({low} to {high})"

    @property
    def range(self) -> str:
        """``N = 20 … 500``."""
        return f"N = {self.bars[0]:,} … {self.bars[1]:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


@dataclass(frozen=True)
class OrbitCell:
    """Time of an orbit."""

    seconds: float
    part: bool
    """Whether a part of it was run and scaled up"""


@dataclass(frozen=True)
class ScalingView:
    """Contents of the chapter."""

    record: dict[str, Any]
    overviews: tuple[Panel, ...]
    families: tuple[Panel, ...]
    exponents: tuple[tuple[str, tuple[Exponent | None, ...]], ...]
    """One row for each engine, in the order of :data:`QUANTITIES`"""
    bars: tuple[int, ...]
    orbits: tuple[tuple[str, tuple[OrbitCell | None, ...]], ...]
    """One row for each engine, in the order of `bars`"""
    stops: tuple[tuple[str, int, str], ...]
    """Engine, bars, reason of the failure or skip"""
    points: tuple[dict[str, Any], ...]
    targets: tuple[dict[str, Any], ...]

    @property
    def finished(self) -> bool:
        """Whether the study was finished."""
        return is_complete(self.record)

    @property
    def scene(self) -> dict[str, Any]:
        """Recorded facts of the chain."""
        return mapping(self.record.get("scene"))


def view_scaling(folder: Path) -> ScalingView:
    """View of the study in a result folder."""
    record, rows_found = FILES.sound_record(folder), spread_rows(FILES, folder)
    points = tabled(rows_found, "outcome", ("engine", "bars"), POINTS).rename(columns={"text": "per"})
    charts = [c for c in charts_of(points) if c.tracks]
    timed = points[points.orbit_s.notna()]
    bars = tuple(sorted({int(n) for n in timed.bars}))
    return ScalingView(
        record,
        tuple(p for p in map(all_engines, charts) if p),
        tuple(p for c in charts for p in each_family(c)),
        tuple(exponents(rows_found)),
        bars,
        tuple((str(e), orbit_cells(own, bars)) for e, own in timed.groupby("engine", sort=False)),
        tuple(stops(points)),
        tuple(cells(r) for r in points.to_dict("records")),
        tuple(rows(record.get("targets"))),
    )


def charts_of(points: pd.DataFrame) -> list[ScalingChart]:
    """Charts of the time of an evaluation, the time of an orbit, and memory."""
    part, step = points.share < 1.0, points.per == "steps"
    large = points.assign(memory_B=points.memory_B.where(points.memory_B >= SHOWN_MEMORY_B))
    evaluations, orbits = tracks(points, "evaluation_s", step), tracks(points, "orbit_s", part)
    memory = tracks(large, "memory_B", part & False)
    names = tuple(dict.fromkeys(t.engine for t in (*evaluations, *orbits, *memory)))
    return [
        ScalingChart("scaling-evaluation", "Time of one evaluation", "s", evaluations, names, STEPS),
        ScalingChart("scaling-orbit", "Time of one orbit", "s", orbits, names, SHARED, (1, 2)),
        ScalingChart("scaling-memory", "Peak memory above that of three bars", "bytes", memory, names),
    ]


def tracks(points: pd.DataFrame, column: str, hollow: pd.Series) -> tuple[ScalingCurve, ...]:
    """Each engine's measured values of a column."""
    found = []
    for engine, own in points.groupby("engine", sort=False):
        good = own[(own[column] > 0.0)].sort_values("bars")
        if len(good):
            flags = hollow.loc[good.index].to_numpy(bool)
            found.append(ScalingCurve(str(engine), good.bars.to_numpy(float), good[column].to_numpy(float), flags))
    return tuple(found)


def exponents(found: pd.DataFrame) -> list[tuple[str, tuple[Exponent | None, ...]]]:
    """Exponents, one row for each engine that has any."""
    range_of = found[found.metric.isin(FITTED)].set_index(["engine", "quantity", "metric"])["value"]
    fits: dict[tuple[str, str], Exponent] = {}
    for r in found[found.metric == "exponent"].to_dict("records"):
        points, *ends = (int(range_of[r["engine"], r["quantity"], name]) for name in FITTED)
        fits[r["engine"], r["quantity"]] = Exponent(r["value"], r["low"], r["high"], r["text"], points, tuple(ends))
    return [(e, tuple(fits.get((e, q)) for q in QUANTITIES)) for e in dict.fromkeys(e for e, _ in fits)]


def orbit_cells(own: pd.DataFrame, bars: tuple[int, ...]) -> tuple[OrbitCell | None, ...]:
    """One engine's times of an orbit."""
    known = zip(own.bars.astype(int), own.orbit_s.astype(float), own.share < 1.0, strict=True)
    found = {n: OrbitCell(seconds, bool(part)) for n, seconds, part in known}
    return tuple(found.get(n) for n in bars)


def stops(points: pd.DataFrame) -> list[tuple[str, int, str]]:
    """Skipped and failed points; of skipped orbits of an engine only the first."""
    found: dict[tuple[str, str], tuple[str, int, str]] = {}
    for row in points[["engine", "bars", "outcome", "reason"]].to_dict("records"):
        engine, bars, good = str(row["engine"]), int(row["bars"]), row["outcome"] == Outcome.PASS.value
        if not good or row["reason"]:
            found.setdefault((engine, "orbit" if good else f"at {bars}"), (engine, bars, str(row["reason"])))
    return list(found.values())


def cells(row: dict[Any, Any]) -> dict[str, Any]:
    """Row of the points for a table: None for NaN, memory in words."""
    found = {str(k): None if is_nan(v) else v for k, v in row.items()}
    memory = number(found["memory_B"])
    return found | {"memory": memory_text(memory)}


def memory_text(value: float | None) -> str:
    """``12.3 MB``; less than one is hidden by allocators."""
    if value is None:
        return ""
    return "< 1 MB" if value < SHOWN_MEMORY_B else f"{significant(value / 1e6)} MB"
