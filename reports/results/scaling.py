"""Rows of a scaling study, as the tables that its chapter is rendered from.

``points``
    a row for each engine and number of bars: times in s, memory in bytes, counts and times of an orbit scaled up from
    the part that was run; a cell is empty without a measurement;
``exponents``
    exponents of each cost in the number of bars, with the range of bars that they are fitted to.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.results.cost import BASELINE, busy_machine
from reports.results.effects import scene_of
from reports.results.files import StudyFiles
from reports.results.rows import NOT_COMPARED, Followed, known
from reports.results.schema import StudyRecord
from reports.results.table import Table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from reports.results.files import Lines
    from reports.results.rows import Rows


POINTS = Table(
    ("engine", "bars"),
    "outcome",
    {
        "outcome": ".outcome", "reason": ".reason", "per": ".text",
        "evaluation_s": "seconds:evaluation s", "evaluation_low": "seconds:evaluation.low",
        "evaluation_high": "seconds:evaluation.high",
        "orbit_s": "seconds:orbit s", "orbit_low": "seconds:orbit.low", "orbit_high": "seconds:orbit.high",
        "share": "share:orbit", "simulate_s": "seconds:simulate s", "build_s": "seconds:build s",
        "turns": "turns:evaluation", "evaluations": "count:evaluations", "steps": "count:steps", "memory_B": "memory B",
    },
    sizes=("bars",),
)  # fmt: skip
EXPONENTS = Table(
    ("engine", "quantity"),
    "exponent",
    {
        "exponent": ".value", "low": ".low", "high": ".high", "per": ".text",
        "points": "points", "bars_from": "bars_from", "bars_to": "bars_to",
    },
)  # fmt: skip
FOLLOWED = {
    "outcome": Followed("verdict", setting="bars={bars:g}"),
    "memory": Followed("memory", setting="bars={bars:g}"),
    "evaluation_ratio": Followed("ratio", setting="bars={bars:g}"),
}


def add_ratios(found: Rows, tables: Lines, record: Mapping[str, Any]) -> None:
    """Add times relative to the baseline's with as many bars; their intervals span both."""
    rows, busy = tables.get("points", []), busy_machine(record)
    said: dict[str, Any] = {"outcome": NOT_COMPARED, "reason": busy} if busy else {}
    anchors = {row["bars"]: row for row in rows if row["engine"] == BASELINE}
    for row in (row for row in rows if row["engine"] != BASELINE and row["bars"] in anchors):
        anchor = anchors[row["bars"]]
        mine, base = row["evaluation_s"], anchor["evaluation_s"]
        if known(mine) and known(base) and base:
            ends: dict[str, Any] = {
                "low": over(row["evaluation_low"], anchor["evaluation_high"]),
                "high": over(row["evaluation_high"], anchor["evaluation_low"]),
            }
            where: dict[str, Any] = {"engine": row["engine"], "bars": row["bars"], "relative_to": BASELINE}
            where |= scene_of(record)
            found.add("evaluation_ratio", mine / base, **ends, **said, **where)


def over(a: float, b: float) -> float | None:
    """Ratio of two numbers; None if one is unknown."""
    return a / b if known(a) and known(b) and b else None


FILES = StudyFiles(
    "scaling",
    {"points": POINTS, "exponents": EXPONENTS},
    followed=FOLLOWED,
    add_derived=add_ratios,
    place=scene_of,
    model=StudyRecord,
    title="Cost against the number of bars",
    view="scaling:view_scaling",
    in_report=True,
)
