"""Rows of a cost study, as the tables that its chapter is rendered from.

``points``
    a row for each planned run; errors are the largest over the samples; a cell is empty if the engine lacks the
    quantity or it was not measured;
``orders``, ``reach``, ``price``
    measured orders of convergence; costs to reach an error; cost factors of one more digit;
``loads``
    share of barchain's loads in an engine's time;
``times``
    every measured time of `simulate`, s, a series.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from reports.tables.files import StudyFiles
from reports.tables.rows import COUNT, NOT_COMPARED, NOT_RUN, RUNS_FOLLOWED, Followed, Rows, known, records, was_run
from reports.tables.schema import StudyRecord
from reports.tables.table import Number, Table

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.tables.files import Frames, StudyTables

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
REACHED = frozenset({"reached", "at most"})
INTERRUPTED = "the study was interrupted"
TIMES = ("scene", "engine", "setting", "turn", "seconds")


RUN = ("scene", "engine", "setting")
TABLES = {
    "points": Table(
        RUN,
        "outcome",
        {"outcome": "outcome", "reason": "reason", "text": "under_floor"},
        numbers={
            "attitude_error_rad": Number("attitude", "error", "rad"),
            "attitude_floor_rad": Number("attitude", "floor", "rad"),
            "reaction_error_N": Number("reaction", "error", "N"),
            "reaction_floor_N": Number("reaction", "floor", "N"),
            "reaction_relative": Number("reaction", "relative_error"),
            "reaction_floor_relative": Number("reaction", "relative_floor"),
            "com_error_m": Number("com", "error", "m"),
            "com_floor_m": Number("com", "floor", "m"),
            "gap_m": Number("gap", "max", "m"),
            "energy_error": Number("energy", "error"),
            "step_s": Number("step", "mean", "s"),
            "seconds": Number("simulate", "seconds", "s", "seconds_low", "seconds_high"),
            "build_s": Number("build", "seconds", "s"),
            "compile_s": Number("compile", "seconds", "s"),
            "read_s": Number("read", "seconds", "s"),
            "turns": Number("simulate", "turns"),
            "evaluations": Number("evaluations", COUNT),
            "steps": Number("steps", COUNT),
            "value": Number("", "setting_value"),
        },
        words=("parameter",),
        flags=("on_front",),
    ),
    "orders": Table(
        ("scene", "engine", "quantity", "against"),
        "order",
        {"value": "order", "low": "order_low", "high": "order_high", "outcome": "outcome", "reason": "reason"},
        numbers={
            "theory": Number("", "theory"),
            "points": Number("", "points"),
            "error_from": Number("", "error_from"),
            "error_to": Number("", "error_to"),
            "least_error": Number("", "least_error"),
        },
        prefix="order.",
    ),
    "reach": Table(
        ("scene", "engine", "quantity", "measure", "target"),
        "cost_to_reach",
        {"value": "cost", "low": "cost_low", "high": "cost_high", "outcome": "status", "reason": "reason"},
        numbers={
            "over_fastest": Number("", "over_fastest", "1", "over_fastest_low", "over_fastest_high", "fastest"),
            "over_baseline": Number("", "over_baseline", "1", "over_baseline_low", "over_baseline_high"),
        },
        words=("reached_by",),
        sizes=("target",),
        prefix="reach.",
    ),
    "price": Table(
        ("scene", "engine", "quantity", "measure"),
        "price_of_a_digit",
        {"value": "factor", "low": "factor_low", "high": "factor_high"},
        prefix="price.",
    ),
    "loads": Table(
        RUN,
        "loads_timed",
        numbers={
            "share": Number("loads", "share", "1", "share_low", "share_high"),
            "seconds": Number("loads", "seconds", "s"),
            "seconds_twice": Number("loads", "seconds_twice", "s"),
        },
        prefix="loads.",
    ),
}
FOLLOWED = {
    COUNT: RUNS_FOLLOWED[COUNT],
    "outcome": Followed("verdict"),
    "reach": Followed("verdict", setting="{quantity}<={target:g}", besides=(BASELINE,)),
    "time_ratio": Followed("ratio", setting="{quantity}<={target:g}"),
    "order": Followed("value", "{metric}.{quantity}.{against}", setting=""),
}


def derived(tables: Frames, record: Mapping[str, Any]) -> Rows:
    """Verdicts on what an engine reaches, and times relative to the baseline's; of an interrupted study no orders."""
    found, interrupted = Rows(FILES.study), "" if record.get("complete") else INTERRUPTED
    if "orders" in tables:
        orders = tables["orders"]
        if interrupted:
            unknown = dict.fromkeys(("order", "order_low", "order_high"), float("nan"))
            orders = orders.assign(**unknown, outcome=NOT_RUN, reason=INTERRUPTED)
        else:
            orders["reason"] = np.where(orders["order"].notna(), "", "too few points")
        tables["orders"] = orders
    cut = {
        (row["scene"], row["engine"]): row["reason"]
        for row in reversed(list(records(tables["points"]) if "points" in tables else ()))
        if not was_run(row["outcome"])
    }
    for row in records(tables["reach"]) if "reach" in tables else ():
        if row["measure"] == "seconds":
            add_reach(found, row, cut.get((row["scene"], row["engine"]), interrupted), busy_machine(record))
    return found


def add_reach(found: Rows, row: Mapping[str, Any], not_run: str, busy: str) -> None:
    """Add the verdict on an error that an engine reaches, and its time relative to the baseline's, timed in turns.

    `not_run` is the reason why a finer setting of the engine was not run: whether it reaches the error is then unknown.
    `busy` is the reason why times are not compared. "At most" is "reached" here: noise in times alone makes a coarser
    setting slower than a finer one, and then takes it out of the curve.
    """
    where = {name: row[name] for name in ("scene", "engine", "quantity", "target")}
    reached = row["status"] in REACHED
    unknown = bool(not_run) and not reached
    said = NOT_RUN if unknown else "reached" if reached else row["status"]
    found.add("reach", outcome=said, reason=not_run if unknown else "", **where)
    if row["engine"] != BASELINE and reached and known(row["over_baseline"]):
        ends = {"low": row["over_baseline_low"], "high": row["over_baseline_high"]}
        left_out: dict[str, Any] = {"outcome": NOT_COMPARED, "reason": busy} if busy else {}
        found.add("time_ratio", row["over_baseline"], relative_to=BASELINE, **ends, **left_out, **where)


def busy_machine(record: Mapping[str, Any]) -> str:
    """Why the times of a study tell nothing of its engines; empty if they do."""
    others = record.get("other_processors")
    return f"other processes used {others:.1f} processors" if known(others) and others > BUSY else ""


FILES = StudyFiles(
    "cost",
    TABLES,
    {"times": TIMES},
    followed=FOLLOWED,
    derived=derived,
    model=StudyRecord,
    title="Cost of accuracy",
    view="cost:view_cost",
    in_report=True,
)


def read_cost(folder: Path) -> StudyTables:
    """Record and tables of the study in a result folder, without single times; errors as `FILES.contents`.

    Each table has a column ``kind`` besides, from the record; the reference stands there even where it was not timed.
    """
    found = FILES.contents(folder, *TABLES)
    kinds = {name: facts.get("kind") for name, facts in (found.record.get("engines") or {}).items()}
    for table in found.tables.values():
        table["kind"] = table["engine"].map(kinds).fillna(OWN_EQUATIONS)
    return found
