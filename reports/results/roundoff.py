"""Rows of a round-off study, as the tables that its chapter is rendered from.

Each error is given as quantiles over an ensemble's members (``q05``, ``median``, ``q95``, ``largest``, and their number
``members``).

``evaluation``
    errors of one evaluation of the reactions; ``ratio`` is the size ratio, a bar's length
    divided by the Earth's radius; ``source`` formula, input or both; ``yardstick`` the reaction itself or m n² l;
``laws``
    power laws of these medians in the size ratio; the error is ``constant`` u ratio^``expected``,
    and ``last_digit_ratio`` where that is 0.1;
``longitudes``
    errors of formula and input by sector of the longitude; ``p_value`` is the
    probability of at least these differences between equal sectors (Kruskal-Wallis test);
``trajectories``, ``best``, ``best_laws``
    errors of a run against step or tolerance, the smallest of them, and its law in the size ratio;
``growth``, ``growth_laws``
    errors against time, and their exponents;
``engines``, ``engine_laws``
    errors of other engines, in the inertial frame and in a moving frame, against step and size ratio;
``times``
    time of an evaluation in relative coordinates relative to absolute ones;
``digits``
    errors of scenes over their time, in each set of coordinates and each precision: of angles in rad, of reactions over
    the largest of the run, of the track over the distance from the body's centre;
``floors``, ``spread``
    spread of an engine's results over variants of a scene, in SI units: each channel's ``floor`` over what the scene
    amplifies, with a ``tolerance`` there and for the whole run, and the ``class`` of precision; the spread over time,
    with ``grown``, what the scene amplifies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from reports.results.files import StudyFiles
from reports.results.rows import Followed
from reports.results.schema import StudyRecord
from reports.results.table import Table

if TYPE_CHECKING:
    from collections.abc import Mapping

RUN = ("ratio", "quantity", "coordinates", "arithmetic", "method")
SIZES = ("bars", "ratio", "steps_per_orbit", "rtol", "orbits", "sector_deg")
"""Columns of numbers among those that tell rows apart"""


def errors(name: str, index: tuple[str, ...], *numbers: str, flags: tuple[str, ...] = (), **further: str) -> Table:
    """Table of errors as quantiles, with further columns of numbers and flags, and others with their cells."""
    quantiles = {"median": ".value", "q05": ".low", "q95": ".high"}
    cells = {column: f"{name}.{column}" for column in ("largest", "members", *numbers, *flags)}
    return Table(index, f"{name}.median", quantiles | further | cells, flags, SIZES)


def fits(name: str, index: tuple[str, ...], *numbers: str) -> Table:
    """Table of power laws, with further columns of numbers."""
    exponent = {"exponent": ".value", "low": ".low", "high": ".high", "remark": ".reason"}
    cells = {column: f"{name}.{column}" for column in ("expected", "points", "first", "last", *numbers)}
    return Table(index, f"{name}.exponent", exponent | cells, (), SIZES)


EVALUATION = ("state", "bars", "formulation", "arithmetic", "source", "yardstick")
STEPS = ("steps_per_orbit", "rtol")
PAIR = ("scene", "engine", "setting", "quantity")
FLOORS = ("median", "q95", "repeats", "tolerance", "rtol", "run_tolerance", "run_rtol", "scale")
TABLES = {
    "evaluation": errors("evaluation", (*EVALUATION, "ratio")),
    "laws": fits("laws", EVALUATION, "constant", "last_digit_ratio"),
    "longitudes": errors(
        "longitudes", ("state", "ratio", "formulation", "arithmetic", "source", "sector_deg"), "p_value"
    ),
    "trajectories": errors("trajectories", (*RUN, *STEPS), "evaluations", flags=("known",)),
    "best": errors("best", RUN, *STEPS, flags=("known", "settled")),
    "best_laws": fits("best_laws", RUN[1:], "constant"),
    "growth": errors("growth", (*RUN, "orbits"), "exponent_low", "exponent_high", flags=("known",)),
    "growth_laws": fits("growth_laws", RUN),
    "engines": errors(
        "engines", ("engine", "frame", "ratio", "quantity", *STEPS), flags=("known",),
        outcome=".outcome", reason=".reason",
    ),
    "engine_laws": fits("engine_laws", ("engine", "frame", "ratio", "quantity", "against")),
    "times": Table(
        ("code", "arithmetic", "bars"),
        "time_ratio",
        {
            "ratio": "/absolute", "low": ".low", "high": ".high", "relative_s": "relative_seconds:evaluation s",
            "absolute_s": "absolute_seconds:evaluation s", "turns": "turns:evaluation",
        },
        sizes=SIZES,
    ),
    "digits": errors("digits", ("scene", "quantity", "coordinates", "arithmetic", "orbits")),
    "floors": Table(
        PAIR,
        "floors.floor",
        {"floor": ".value", "class": ".text", "reason": ".reason"} | {name: f"floors.{name}" for name in FLOORS},
    ),
    "spread": errors("spread", (*PAIR, "orbits"), "grown"),
}  # fmt: skip
PARTS = {
    "evaluation": ("evaluation", "laws", "longitudes"),
    "trajectories": ("trajectories", "best", "best_laws", "growth", "growth_laws"),
    "engines": ("engines", "engine_laws"),
    "times": ("times",),
    "scenes": ("digits",),
    "floors": ("floors", "spread"),
}
"""Tables of each part of the study"""


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


def place_of(record: Mapping[str, Any]) -> dict[str, str]:
    """Scene of all rows, and the quantity of those that name none."""
    return {"scene": str(record.get("scene") or ""), "quantity": "reaction"}


FILES = StudyFiles(
    "roundoff",
    TABLES,
    followed=FOLLOWED,
    place=place_of,
    parts=PARTS,
    model=StudyRecord,
    title="Round-off in absolute and relative coordinates",
    view="roundoff.view:view_roundoff",
    in_report=True,
)
