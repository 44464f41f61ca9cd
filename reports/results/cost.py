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

from reports.results.files import StudyFiles
from reports.results.rows import COUNT, NOT_COMPARED, NOT_RUN, RUNS_FOLLOWED, Followed, Rows, known, was_run
from reports.results.schema import StudyRecord
from reports.results.table import Table

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.results.files import Lines, StudyTables

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
        {
            "outcome": ".outcome", "reason": ".reason", "under_floor": ".text",
            "attitude_error_rad": "error:attitude rad", "attitude_floor_rad": "floor:attitude rad",
            "reaction_error_N": "error:reaction N", "reaction_floor_N": "floor:reaction N",
            "reaction_relative": "relative_error:reaction", "reaction_floor_relative": "relative_floor:reaction",
            "com_error_m": "error:com m", "com_floor_m": "floor:com m",
            "gap_m": "max:gap m", "energy_error": "error:energy", "step_s": "mean:step s",
            "seconds": "seconds:simulate s", "seconds_low": "seconds:simulate.low",
            "seconds_high": "seconds:simulate.high", "build_s": "seconds:build s", "compile_s": "seconds:compile s",
            "read_s": "seconds:read s", "turns": "turns:simulate", "evaluations": "count:evaluations",
            "steps": "count:steps", "value": "setting_value", "parameter": "parameter.text", "on_front": "on_front",
        },
        flags=("on_front",),
    ),
    "orders": Table(
        ("scene", "engine", "quantity", "against"),
        "order",
        {
            "order": ".value", "order_low": ".low", "order_high": ".high", "outcome": ".outcome", "reason": ".reason",
            **{name: f"order.{name}" for name in ("theory", "points", "error_from", "error_to", "least_error")},
        },
    ),
    "reach": Table(
        ("scene", "engine", "quantity", "measure", "target"),
        "cost_to_reach",
        {
            "cost": ".value", "cost_low": ".low", "cost_high": ".high", "status": ".outcome", "reason": ".reason",
            "over_fastest": "reach.over_fastest", "over_fastest_low": "reach.over_fastest.low",
            "over_fastest_high": "reach.over_fastest.high", "fastest": "reach.over_fastest.text",
            "over_baseline": "reach.over_baseline", "over_baseline_low": "reach.over_baseline.low",
            "over_baseline_high": "reach.over_baseline.high", "reached_by": "reach.reached_by.text",
        },
        sizes=("target",),
    ),
    "price": Table(
        ("scene", "engine", "quantity", "measure"),
        "price_of_a_digit",
        {"factor": ".value", "factor_low": ".low", "factor_high": ".high"},
    ),
    "loads": Table(
        RUN,
        "loads_timed",
        {
            "share": "loads.share:loads", "share_low": "loads.share:loads.low", "share_high": "loads.share:loads.high",
            "seconds": "loads.seconds:loads s", "seconds_twice": "loads.seconds_twice:loads s",
        },
    ),
}  # fmt: skip
FOLLOWED = {
    COUNT: RUNS_FOLLOWED[COUNT],
    "outcome": Followed("verdict"),
    "reach": Followed("verdict", setting="{quantity}<={target:g}", besides=(BASELINE,)),
    "time_ratio": Followed("ratio", setting="{quantity}<={target:g}"),
    "order": Followed("value", "{metric}.{quantity}.{against}", setting=""),
}


def add_verdicts(found: Rows, tables: Lines, record: Mapping[str, Any]) -> None:
    """Add verdicts on what an engine reaches, and times relative to the baseline's."""
    interrupted = "" if record.get("complete") else INTERRUPTED
    cut = {
        (row["scene"], row["engine"]): row["reason"]
        for row in reversed(tables.get("points", []))
        if not was_run(row["outcome"])
    }
    for row in tables.get("reach", []):
        if row["measure"] == "seconds":
            add_reach(found, row, cut.get((row["scene"], row["engine"]), interrupted), busy_machine(record))


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
    add_derived=add_verdicts,
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
