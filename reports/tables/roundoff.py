"""Stored tables of a round-off study: everything that its chapter is rendered from.

A folder ``roundoff`` inside a result folder holds, each error as quantiles over an ensemble's members (``q05``,
``median``, ``q95``, ``largest``, and their number ``members``)

``evaluation.csv``
    errors of one evaluation of the reactions: :data:`EVALUATION_COLUMNS`; ``ratio`` is the size ratio, a bar's length
    divided by the Earth's radius; ``source`` formula, input or both; ``yardstick`` the reaction itself or m n² l;
``laws.csv``
    power laws of these medians in the size ratio: :data:`LAW_COLUMNS`; the error is ``constant`` u ratio^``expected``,
    and ``last_digit_ratio`` where that is 0.1;
``longitudes.csv``
    errors of formula and input by sector of the longitude: :data:`LONGITUDE_COLUMNS`; ``p_value`` is the
    probability of at least these differences between equal sectors (Kruskal-Wallis test);
``trajectories.csv``, ``best.csv``, ``best_laws.csv``
    errors of a run against step or tolerance, the smallest of them, and its law in the size ratio;
``growth.csv``, ``growth_laws.csv``
    errors against time, and their exponents;
``engines.csv``, ``engine_laws.csv``
    errors of other engines, in the inertial frame and in a moving frame, against step and size ratio;
``times.csv``
    time of an evaluation in relative coordinates relative to absolute ones;
``record.json``
    environment, and the objects named on the axes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import Followed, Rows, known, records
from reports.tables.schema import Part, Record

if TYPE_CHECKING:
    from pathlib import Path

SPREAD = ("q05", "median", "q95", "largest", "members")
FIT = ("exponent", "low", "high", "expected", "points", "first", "last", "remark")
EVALUATION_COLUMNS = ("state", "bars", "ratio", "formulation", "arithmetic", "source", "yardstick", *SPREAD)
LAW_COLUMNS = (
    "state", "bars", "formulation", "arithmetic", "source", "yardstick", *FIT, "constant", "last_digit_ratio",
)  # fmt: skip
LONGITUDE_COLUMNS = ("state", "ratio", "formulation", "arithmetic", "source", "sector_deg", *SPREAD, "p_value")
RUN = ("ratio", "quantity", "coordinates", "arithmetic", "method")
TRAJECTORY_COLUMNS = (*RUN, "steps_per_orbit", "rtol", "evaluations", *SPREAD, "known")
BEST_COLUMNS = (*RUN, "steps_per_orbit", "rtol", *SPREAD, "known", "settled")
BEST_LAW_COLUMNS = ("quantity", "coordinates", "arithmetic", "method", *FIT, "constant")
GROWTH_COLUMNS = (*RUN, "orbits", *SPREAD, "known", "exponent_low", "exponent_high")
GROWTH_LAW_COLUMNS = (*RUN, *FIT)
ENGINE_COLUMNS = (
    "engine", "frame", "ratio", "quantity", "steps_per_orbit", "rtol", *SPREAD, "known", "outcome", "reason",
)  # fmt: skip
ENGINE_LAW_COLUMNS = ("engine", "frame", "ratio", "quantity", "against", *FIT)
TIME_COLUMNS = (
    "code", "arithmetic", "bars", "relative_s", "absolute_s", "ratio", "low", "high", "turns",
)  # fmt: skip
COLUMNS = {
    "evaluation": EVALUATION_COLUMNS,
    "laws": LAW_COLUMNS,
    "longitudes": LONGITUDE_COLUMNS,
    "trajectories": TRAJECTORY_COLUMNS,
    "best": BEST_COLUMNS,
    "best_laws": BEST_LAW_COLUMNS,
    "growth": GROWTH_COLUMNS,
    "growth_laws": GROWTH_LAW_COLUMNS,
    "engines": ENGINE_COLUMNS,
    "engine_laws": ENGINE_LAW_COLUMNS,
    "times": TIME_COLUMNS,
}
PARTS = {
    "evaluation": ("evaluation", "laws", "longitudes"),
    "trajectories": ("trajectories", "best", "best_laws", "growth", "growth_laws"),
    "engines": ("engines", "engine_laws"),
    "times": ("times",),
}
"""Tables of each part of the study"""
WORDS = (
    "state", "formulation", "arithmetic", "source", "yardstick", "remark", "quantity", "coordinates", "method",
    "engine", "frame", "outcome", "reason", "against", "code",
)  # fmt: skip


class RoundoffPart(Part):
    """Entries of one part's provenance."""

    command: str | None = None
    created: str | None = None
    complete: bool = False
    seconds: float | None = None
    failed: list[dict[str, Any]] | None = None


class RoundoffRecord(Record):
    """Entries of the record."""

    parts: dict[str, RoundoffPart] | None = None
    """Provenance of each part: parts are run together or one by one"""
    scene: str | None = None
    members: int | None = None
    exact_digits: int | None = None
    unit_roundoff: dict[str, float] | None = None
    long_doubles: bool | None = None
    objects: list[dict[str, Any]] | None = None
    failed: list[dict[str, Any]] | None = None


FILES = StudyFiles(
    "roundoff",
    COLUMNS,
    WORDS,
    optional=frozenset(COLUMNS),
    flags=("known", "settled"),
    model=RoundoffRecord,
    parts=PARTS,
    pages=("roundoff.html",),
)


read_roundoff = FILES.contents


KEYS = {
    "evaluation": ("state", "bars", "ratio", "formulation", "arithmetic", "source", "yardstick"),
    "laws": ("state", "bars", "formulation", "arithmetic", "source", "yardstick"),
    "longitudes": ("state", "ratio", "formulation", "arithmetic", "source", "sector_deg"),
    "trajectories": (*RUN, "steps_per_orbit", "rtol"),
    "best": RUN,
    "best_laws": ("quantity", "coordinates", "arithmetic", "method"),
    "growth": (*RUN, "orbits"),
    "growth_laws": RUN,
    "engines": ("engine", "frame", "ratio", "quantity", "steps_per_orbit", "rtol"),
    "engine_laws": ("engine", "frame", "ratio", "quantity", "against"),
}
"""Columns that tell the rows of each table apart"""
LAWS = {
    "laws": "{state} {bars:g} {formulation} {arithmetic} {source} {yardstick}",
    "best_laws": "{quantity} {coordinates} {arithmetic} {method}",
    "growth_laws": "{ratio:g} {quantity} {coordinates} {arithmetic} {method}",
    "engine_laws": "{frame} {ratio:g} {quantity} {against}",
}
"""Tables of laws, and the names of their figures' settings in nights"""
FOLLOWED = {
    **{f"{table}.exponent": Followed("value", setting=setting) for table, setting in LAWS.items()},
    "time_ratio": Followed("ratio", setting="{code}, {arithmetic}, bars={bars:g}"),
}


def roundoff_rows(folder: Path) -> Rows:
    """Rows of a round-off study: medians with 5 % and 95 % quantiles, laws, and ratios of times."""
    tables = read_roundoff(folder)
    found = Rows(FILES.name, str(tables.record.get("scene") or ""))
    for table, keys in KEYS.items():
        for row in records(getattr(tables, table)):
            where = {"quantity": "reaction"} | {key: row[key] for key in keys}
            if row.get("against") == "steps" and not row["expected"] >= 0.0:  # beside the law of round-off
                where["against"] = "steps, truncation"
            if table in LAWS:
                ends = {"low": row["low"], "high": row["high"], "reason": row["remark"]}
                found.add(f"{table}.exponent", row["exponent"], **ends, **where)
                rest: tuple[str, ...] = ("expected", "constant", "last_digit_ratio")
            else:
                said = {"outcome": row.get("outcome", ""), "reason": row.get("reason", "")}
                found.add(f"{table}.median", row["median"], low=row["q05"], high=row["q95"], **said, **where)
                rest = ("largest", "p_value")
            for name in rest:
                if known(row.get(name)):
                    found.add(f"{table}.{name}", row[name], **where)
    for row in records(tables.times):
        where = {key: row[key] for key in ("code", "arithmetic", "bars")}
        found.add("time_ratio", row["ratio"], low=row["low"], high=row["high"], relative_to="absolute", **where)
        for coordinates in ("relative", "absolute"):
            seconds = row[f"{coordinates}_s"]
            found.add("seconds", seconds, "s", quantity="evaluation", coordinates=coordinates, **where)
    return found
