"""Stored tables of a cost study: everything that its chapter is rendered from.

A folder ``cost`` inside a result folder holds

``points.csv``
    one row for each planned run, columns :data:`POINT_COLUMNS`; errors are the largest over the samples; a cell is
    empty if the engine lacks the quantity or it was not measured; ``kind`` is one of :data:`KINDS` in all tables;
``times.csv``
    every measured time of `simulate`, s;
``orders.csv``, ``reach.csv``, ``price.csv``
    measured orders of convergence; costs to reach an error; cost factors of one more digit;
``loads.csv``
    share of barchain's loads in an engine's time, columns :data:`LOAD_COLUMNS`;
``record.json``
    environment, engines, certified solutions, and skipped pairs with their reasons.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import (
    COUNT,
    NOT_COMPARED,
    NOT_RUN,
    RUNS_FOLLOWED,
    Followed,
    Rows,
    known,
    records,
    split_not_run,
)
from reports.tables.schema import Record

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.tables.files import StudyTables

BASELINE = "reference-fast"  # times are also given relative to this engine's
INDEPENDENT, OWN_EQUATIONS = "independent physics", "barchain's equations"
"""Kinds of engines: those with equations of motion of their own, and integrators of barchain's"""
KINDS = {
    INDEPENDENT: "Engines with independent physics",
    OWN_EQUATIONS: "The reference, and integrators on barchain's equations",
}
"""Headings of both kinds, in the order in which they are shown"""
BUSY = 0.5
"""Processors used by other processes from which on times are not compared with those of other runs: ratios of two
engines then differ by up to a tenth from those on an idle machine"""
TIME_COLUMNS = ("scene", "engine", "setting", "turn", "seconds")
LOAD_COLUMNS = ("scene", "engine", "setting", "kind", "seconds", "seconds_twice", "share", "share_low", "share_high")
POINT_COLUMNS = (
    "scene", "engine", "kind", "setting", "parameter", "value", "step_s", "outcome", "reason",
    "attitude_error_rad", "attitude_floor_rad",
    "reaction_error_N", "reaction_floor_N", "reaction_relative", "reaction_floor_relative",
    "com_error_m", "com_floor_m", "gap_m", "energy_error", "under_floor",
    "seconds", "seconds_low", "seconds_high", "turns", "build_s", "compile_s", "read_s",
    "evaluations", "steps", "on_front",
)  # fmt: skip
WORDS = (
    "scene", "engine", "kind", "setting", "parameter", "outcome", "reason", "under_floor", "status", "fastest",
    "quantity", "against", "measure",
)  # fmt: skip


class CostRecord(Record):
    """Entries of the record."""

    engines: dict[str, dict[str, Any]] | None = None
    scenes: dict[str, dict[str, Any]] | None = None
    certified_solutions: dict[str, dict[str, Any]] | None = None
    left_out: list[dict[str, Any]] | None = None
    shortened_limits_s: dict[str, float] | None = None
    """Limit of a run in the scenes where half of the time was used before all was run"""
    other_processors: float | None = None
    """Mean number of processors that other processes used while times were measured"""


FILES = StudyFiles(
    "cost",
    {"points": POINT_COLUMNS, "times": TIME_COLUMNS, "orders": (), "reach": (), "price": (), "loads": LOAD_COLUMNS},
    WORDS,
    optional=frozenset({"loads"}),
    flags=("on_front",),
    model=CostRecord,
    pages=("cost.html",),
)


def read_cost(folder: Path) -> StudyTables:
    """Record and tables of the study in a result folder, without single times; errors as `FILES.contents`."""
    return FILES.contents(folder, "points", "orders", "reach", "price", "loads")


POINTS = {
    "attitude_error_rad": ("attitude", "error", "rad"), "attitude_floor_rad": ("attitude", "floor", "rad"),
    "reaction_error_N": ("reaction", "error", "N"), "reaction_floor_N": ("reaction", "floor", "N"),
    "reaction_relative": ("reaction", "relative_error", "1"),
    "reaction_floor_relative": ("reaction", "relative_floor", "1"),
    "com_error_m": ("com", "error", "m"), "com_floor_m": ("com", "floor", "m"),
    "gap_m": ("gap", "max", "m"), "energy_error": ("energy", "error", "1"), "step_s": ("step", "mean", "s"),
    "seconds": ("simulate", "seconds", "s"), "build_s": ("build", "seconds", "s"),
    "compile_s": ("compile", "seconds", "s"), "read_s": ("read", "seconds", "s"), "turns": ("simulate", "turns", "1"),
    "evaluations": ("evaluations", COUNT, "1"), "steps": ("steps", COUNT, "1"),
}  # fmt: skip
"""Quantity, metric and unit of the columns of `points`"""
REACHED = frozenset({"reached", "at most"})
INTERRUPTED = "the study was interrupted"
FOLLOWED = {
    COUNT: RUNS_FOLLOWED[COUNT],
    "outcome": Followed("verdict"),
    "reach": Followed("verdict", setting="{quantity}<={target:g}", besides=(BASELINE,)),
    "time_ratio": Followed("ratio", setting="{quantity}<={target:g}"),
    "order": Followed("value", "{metric}.{quantity}.{against}", setting=""),
}


def cost_rows(folder: Path) -> Rows:
    """Rows of a cost study: its points, times to reach an error, orders, prices of a digit, and shares of loads."""
    tables, found = read_cost(folder), Rows(FILES.name)
    busy, interrupted = busy_machine(tables.record), "" if tables.record.get("complete") else INTERRUPTED
    cut: dict[tuple[str, str], str] = {}
    for row in records(tables.points):
        where = {name: row[name] for name in ("scene", "engine", "setting")}
        outcome, reason = split_not_run(row["outcome"], row["reason"])
        found.add("outcome", outcome=outcome, reason=reason, text=row["under_floor"], **where)
        found.measured(row, POINTS, **where)
        if outcome == NOT_RUN:
            cut.setdefault((row["scene"], row["engine"]), reason)
    for row in records(tables.reach):
        add_reach(found, row, cut.get((row["scene"], row["engine"]), interrupted), busy)
    for row in records(tables.orders):
        add_order(found, row, interrupted)
    for row in records(tables.price):
        where = {name: row[name] for name in ("scene", "engine", "quantity", "measure")}
        found.add("price_of_a_digit", row["factor"], low=row["factor_low"], high=row["factor_high"], **where)
    for row in records(tables.loads):
        where = {name: row[name] for name in ("scene", "engine", "setting")}
        found.measured(
            row, {"share": ("loads", "share", "1"), "seconds_twice": ("loads", "seconds_twice", "s")}, **where
        )
    return found


def busy_machine(record: Mapping[str, Any]) -> str:
    """Why the times of a study tell nothing of its engines; empty if they do."""
    others = record.get("other_processors")
    return f"other processes used {others:.1f} processors" if known(others) and others > BUSY else ""


def add_reach(found: Rows, row: Mapping[str, Any], not_run: str, busy: str) -> None:
    """Add the cost to an error, and its ratio to the fastest engine's and the baseline's, which was timed in turns.

    `not_run` is the reason why a finer setting of the engine was not run: whether it reaches the error is then unknown.
    `busy` is the reason why times are not compared.
    """
    where = {name: row[name] for name in ("scene", "engine", "quantity", "target")}
    measure, status = row["measure"], row["status"]
    unit = "s" if measure == "seconds" else "1"
    ends = {"low": row["cost_low"], "high": row["cost_high"]}
    found.add(f"{measure}_to_reach", row["cost"], unit, outcome=status, reason=row.get("reason", ""), **ends, **where)
    if measure == "seconds":
        sure = {"reached"} if not_run == INTERRUPTED else REACHED  # its coarsest point may be missing
        unknown = bool(not_run) and status not in sure
        found.add("reach", outcome=NOT_RUN if unknown else status, reason=not_run if unknown else "", **where)
    for anchor, column in ((BASELINE, "over_baseline"), (row.get("fastest", ""), "over_fastest")):
        if row["engine"] != anchor and status in REACHED and known(row[column]):
            name = f"{'time' if measure == 'seconds' else measure}_ratio"
            ends = {"low": row[f"{column}_low"], "high": row[f"{column}_high"]}
            said: dict[str, Any] = {"outcome": NOT_COMPARED, "reason": busy} if busy and measure == "seconds" else {}
            metric = name if column == "over_baseline" else f"{name}_to_fastest"
            found.add(metric, row[column], relative_to=anchor, **ends, **said, **where)


def add_order(found: Rows, row: Mapping[str, Any], interrupted: str) -> None:
    """Add an order of convergence, and the order of the engine's method; of an interrupted study none is known."""
    where = {name: row[name] for name in ("scene", "engine", "quantity", "against")}
    if interrupted:
        found.add("order", outcome=NOT_RUN, reason=interrupted, **where)
        return
    reason = "" if known(row["order"]) else "too few points"
    found.add("order", row["order"], low=row["order_low"], high=row["order_high"], reason=reason, **where)
    if known(row["theory"]):
        found.add("theoretical_order", row["theory"], **where)
