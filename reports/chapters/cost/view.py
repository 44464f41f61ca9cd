"""View of a cost study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.chapters.cost.charts import FLOOR_MARGIN, ChartData, CostCurve, Front, by_family, overview
from reports.tables.cost import BASELINE, INDEPENDENT, KINDS, CostTables, read_cost
from reports.tables.files import flags
from reports.tables.outcome import Outcome
from reports.tables.rows import NOT_RUN
from reports.text.numerals import is_nan, number
from reports.text.record import is_complete, mapping, rows
from reports.text.words import anchor

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from reports.plotting.panels import Panel

QUANTITIES = {  # columns of errors and floors, label of the axis
    "attitude": ("attitude_error_rad", "attitude_floor_rad", "largest attitude error, rad"),
    "reaction": ("reaction_relative", "reaction_floor_relative", "largest reaction error / largest reaction"),
}


@dataclass(frozen=True)
class ReachCell:
    """Cost at which one engine reaches one error."""

    status: str
    cost: float | None = None
    ratio: tuple[float | None, float | None, float | None] = (None, None, None)
    """Relative to the fastest engine, with its interval"""
    over_baseline: tuple[float | None, float | None, float | None] = (None, None, None)

    @property
    def best(self) -> bool:
        """Whether no engine is faster."""
        return self.ratio[0] == 1.0

    @property
    def sign(self) -> str:
        """Sign before a cost that is only an upper bound."""
        return "≤ " if self.status == "at most" else ""


@dataclass(frozen=True)
class ReachGroup:
    """Costs of the engines of one kind: a row for each engine."""

    heading: str
    rows: tuple[tuple[str, tuple[ReachCell, ...]], ...]


@dataclass(frozen=True)
class ReachTable:
    """Costs to reach target errors, by kind of engine."""

    title: str
    targets: tuple[float, ...]
    groups: tuple[ReachGroup, ...]
    timed: bool

    @property
    def engines(self) -> tuple[str, ...]:
        """Names of the engines in the table."""
        return tuple(engine for group in self.groups for engine, _ in group.rows)


@dataclass(frozen=True)
class CostScene:
    """One scene's part of the chapter."""

    name: str
    anchor: str
    title: str
    orbits: float | None
    solution: dict[str, Any]
    """Facts of the certified solution, as in the record"""
    overviews: tuple[Panel, ...]
    families: tuple[Panel, ...]
    reach: tuple[ReachTable, ...]
    orders: tuple[dict[str, Any], ...]
    """Rows of orders.csv: measured orders of convergence"""
    price: tuple[dict[str, Any], ...]
    """One for each engine: ``engine``, and the row of price.csv for each measure (``seconds``, ``evaluations``)"""
    phase_times: tuple[dict[str, Any], ...]
    """One for each engine: ``engine``, ``version``, ``title``, and ``build_s``, ``compile_s``, ``read_s`` or None"""
    points: tuple[dict[str, Any], ...]
    """Rows of points.csv"""
    loads: tuple[dict[str, Any], ...]
    """Rows of loads.csv: share of barchain's loads in an engine's time"""
    shortened_s: float | None
    """Limit of a run once half of the time was used; None if it was not shortened"""
    left_out: tuple[dict[str, Any], ...]
    """Engines skipped on the scene: ``scene``, ``engine``, ``outcome``, ``reason``"""

    @property
    def baseline(self) -> ReachTable | None:
        """Table of times to reach an attitude error; None where the baseline engine was not run."""
        table = next((t for t in self.reach if t.timed), None)
        return table if table and self.baseline_name in table.engines else None

    @property
    def baseline_name(self) -> str:
        """Name of the baseline engine."""
        return BASELINE


@dataclass(frozen=True)
class CostView:
    """Contents of the chapter."""

    record: dict[str, Any]
    scenes: tuple[CostScene, ...]

    @property
    def finished(self) -> bool:
        """Whether the study was finished."""
        return is_complete(self.record)


def view_cost(folder: Path) -> CostView:
    """View of the study in a result folder."""
    tables = read_cost(folder)
    return CostView(tables.record, tuple(view_scene(tables, s) for s in dict.fromkeys(tables.points.scene)))


def view_scene(tables: CostTables, scene: str) -> CostScene:
    """One scene's part of the chapter."""
    points = tables.points[tables.points.scene == scene]
    facts, name = mapping(mapping(tables.record.get("scenes")).get(scene)), f"cost-{anchor(scene)}"
    timed = chart_data(points, "attitude", "seconds", f"{name}-attitude")
    return CostScene(
        name=scene,
        anchor=name,
        title=str(facts.get("title") or scene),
        orbits=number(facts.get("orbits")),
        solution=mapping(mapping(tables.record.get("certified_solutions")).get(scene)),
        overviews=tuple(p for p in overviews(points, timed, name) if p),
        families=tuple(by_family(timed)),
        reach=reach_tables(tables.reach, scene),
        orders=tuple(records(tables.orders, scene)),
        price=tuple(prices(tables.price, scene)),
        phase_times=tuple(phase_times(points, tables.record)),
        points=tuple(records(points, scene)),
        loads=tuple(row | {"text": share_text(row)} for row in records(tables.loads, scene)),
        shortened_s=number(mapping(tables.record.get("shortened_limits_s")).get(scene)),
        left_out=tuple(r for r in rows(tables.record.get("left_out")) if r.get("scene") == scene),
    )


def overviews(points: pd.DataFrame, timed: ChartData, name: str) -> list[Panel | None]:
    """Charts of time for attitude (`timed`), time for reactions, evaluations for attitude."""
    reactions = chart_data(points, "reaction", "seconds", f"{name}-reaction")
    counted = chart_data(points, "attitude", "evaluations", f"{name}-count")
    return [
        overview(timed, "Time against attitude error", fronts(points)),
        overview(reactions, "Time against error of reactions"),
        overview(counted, "Evaluations against attitude error"),
    ]


def chart_data(points: pd.DataFrame, quantity: str, cost: str, name: str) -> ChartData:
    """Contents of the charts of a scene, one curve for each engine."""
    error, floor, label = QUANTITIES[quantity]
    unit = "simulate, s" if cost == "seconds" else "evaluations of the right-hand side"
    least = points[floor].max()
    found = [cost_curve(points[points.engine == e], error, floor, cost) for e in dict.fromkeys(points.engine)]
    without_track = {str(e) for e, own in points.groupby("engine") if own.com_error_m.isna().all()}
    # an undeclared quantity is no failure
    kept = [t for t in found if np.isfinite(t.error).any() or t.engine in without_track]
    return ChartData(
        name=name,
        x_label=label,
        y_label=unit,
        floor=float(least) if np.isfinite(least) else 0.0,
        tracks=tuple(kept),
    )


def cost_curve(own: pd.DataFrame, error: str, floor: str, cost: str) -> CostCurve:
    """Points of one engine, without runs skipped for their length."""
    run = own[~own.reason.str.startswith(NOT_RUN)]
    errors = run[error].to_numpy(float)
    return CostCurve(
        engine=str(own.engine.iloc[0]),
        error=errors,
        cost=run[cost].to_numpy(float),
        failed=(run.outcome != Outcome.PASS.value).to_numpy() & (cost == "seconds"),
        blurred=errors < FLOOR_MARGIN * run[floor].to_numpy(float),
        independent=str(own.kind.iloc[0]) == INDEPENDENT,
    )


def fronts(points: pd.DataFrame) -> tuple[Front, ...]:
    """Work-precision fronts of both kinds."""
    best = points[flags(points.on_front)].sort_values("attitude_error_rad", ascending=False)
    by_kind = ((kind == INDEPENDENT, best[best.kind == kind]) for kind in KINDS)
    return tuple(
        Front(own.attitude_error_rad.to_numpy(float), own.seconds.to_numpy(float), independent)
        for independent, own in by_kind
    )


def records(table: pd.DataFrame, scene: str) -> list[dict[str, Any]]:
    """Rows of a scene with None for NaN."""
    own = table[table.scene == scene]
    return [{str(k): None if is_nan(v) else v for k, v in row.items()} for row in own.to_dict("records")]


def reach_tables(reach: pd.DataFrame, scene: str) -> tuple[ReachTable, ...]:
    """Tables of times and evaluations for attitude, and of times for reactions."""
    wanted = (
        ("attitude", "seconds", "Time to reach an attitude error"),
        ("reaction", "seconds", "Time to reach a relative reaction error"),
        ("attitude", "evaluations", "Evaluations to reach an attitude error"),
    )
    found = (reach_table(reach, scene, q, m, title) for q, m, title in wanted)
    return tuple(t for t in found if t.groups)


def reach_table(reach: pd.DataFrame, scene: str, quantity: str, measure: str, title: str) -> ReachTable:
    """Table of one quantity and measure."""
    own = reach[(reach.scene == scene) & (reach.quantity == quantity) & (reach.measure == measure)]
    targets = tuple(float(t) for t in dict.fromkeys(own.target))
    cells = {(r["engine"], r["target"]): cell(r) for r in records(own, scene)}
    groups = (
        ReachGroup(heading, tuple((str(e), tuple(cells[e, t] for t in targets)) for e in dict.fromkeys(of.engine)))
        for heading, of in by_heading(own)
    )
    return ReachTable(title, targets, tuple(groups), measure == "seconds")


def by_heading(table: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """Rows of each kind of engine, with its heading; kinds without rows are left out."""
    found = [(heading, table[table.kind == kind]) for kind, heading in KINDS.items()]
    return [(heading, own) for heading, own in found if len(own)]


def cell(row: dict[str, Any]) -> ReachCell:
    """Cell of a row of reach.csv."""

    def with_interval(name: str) -> tuple[float | None, float | None, float | None]:
        return number(row.get(name)), number(row.get(f"{name}_low")), number(row.get(f"{name}_high"))

    why = row.get("reason")  # of results before 0.7 there is none
    status = str(why) if isinstance(why, str) and why else str(row["status"])
    return ReachCell(status, number(row.get("cost")), with_interval("over_fastest"), with_interval("over_baseline"))


def share_text(load: dict[str, Any]) -> tuple[str, str]:
    """Share of the loads and its interval, in per cent; not resolved where the interval is wider than the share.

    A share lies between 0 and 1: an interval beyond tells of the machine's noise alone.
    """
    share, low, high = (number(load.get(name)) for name in ("share", "share_low", "share_high"))
    if share is None or low is None or high is None:
        return ("" if share is None else f"{100.0 * share:.0f} %"), ""
    if low <= 0.0 or high >= 1.0 or high - low > share:
        return "not resolved", ""
    return f"{100.0 * share:.0f} %", f"{100.0 * low:.0f} to {100.0 * high:.0f} %"


def prices(price: pd.DataFrame, scene: str) -> list[dict[str, Any]]:
    """Cost factors of one more digit, one row for each engine: in time and in evaluations."""
    found: dict[str, dict[str, Any]] = {}
    for row in records(price, scene):
        found.setdefault(row["engine"], {"engine": row["engine"], "kind": row["kind"]})[row["measure"]] = row
    return list(found.values())


def phase_times(points: pd.DataFrame, record: dict[str, Any]) -> list[dict[str, Any]]:
    """Times of each engine to build, compile and read out."""
    engines = mapping(record.get("engines"))
    found = []
    for engine in dict.fromkeys(points.engine):
        own = points[points.engine == engine]
        times = {k: number(own[k].median()) for k in ("build_s", "read_s")}
        found.append(
            {
                "engine": engine,
                "kind": str(own.kind.iloc[0]),
                "version": mapping(engines.get(engine)).get("version") or "",
            }
            | {k: None if is_nan(v) else v for k, v in times.items()}
            | {"compile_s": number(own.compile_s.max()) if own.compile_s.notna().any() else None}
            | {"title": mapping(engines.get(engine)).get("title") or ""}
        )
    return found
