"""Round-off chapter: digits of named objects, charts of errors, fitted laws, dependence on the longitude, times."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.chapters.roundoff.charts import (
    engine_charts,
    evaluation_charts,
    least_and_growth,
    library_charts,
    run_charts,
)
from reports.chapters.roundoff.scenes import digits_of, floors_of
from reports.chapters.roundoff.study import METHODS, QUANTITIES, USUAL, Roundoff, rows_of, spelled
from reports.plotting.errors import LOST
from reports.results.roundoff import EVALUATION, FILES
from reports.results.rows import plain
from reports.text.numerals import as_given, span_text
from reports.text.record import is_complete

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from reports.results.rows import Row

STATES = ("generic", "80°", "fast spin", "unequal masses", "horizontal")
DIGIT_COLUMNS: dict[str, dict[str, str]] = {
    "generic: relative, float32": {"formulation": "relative", "arithmetic": "float32"},
    "generic: relative, float64": {"formulation": "relative"},
    "generic: absolute, float32": {"formulation": "absolute", "arithmetic": "float32"},
    "generic: absolute, float64": {"formulation": "absolute"},
    "horizontal: relative, float64": {"formulation": "relative", "state": "horizontal"},
    "horizontal: absolute, float64": {"formulation": "absolute", "state": "horizontal"},
    "80°: from relative positions, float64": {"formulation": "relative positions", "state": "80°"},
    "80°: from absolute positions, float64": {"formulation": "absolute positions", "state": "80°"},
}
FIRST, FURTHER = ("attitude", "reaction"), ("gap", "com")
FIRST_FORMULATIONS = ("relative", "absolute", "relative positions", "absolute positions")
FIRST_NAMES = ("state", "formulation", "arithmetic", "yardstick")
ALL_NAMES = ("state", "formulation", "bars", "arithmetic", "source", "yardstick")
SECTORS = ("state", "formulation", "arithmetic", "source", "ratio")
LEAST_SIZES = 3  # of a power law with an interval
SLACK = 0.05  # of an exponent: resolution of fits over a few decades of scattered medians
SIGNIFICANT = 0.05  # p below which sectors are said to differ
POWERS = {-3.0: "/ε³", -2.0: "/ε²", -1.0: "/ε", 0.0: ""}
BEYOND = "†"  # after a size that lies beyond the measured ones


def view_roundoff(folder: Path) -> SimpleNamespace:
    """Contents of the chapter, from the study in a result folder."""
    study = Roundoff(FILES.contents(folder))
    tables, record = study.tables, study.tables.record
    every = [(name, [study.digits(ratio, **key) for key in DIGIT_COLUMNS.values()]) for name, ratio in study.named]
    measured = [k for k in range(len(DIGIT_COLUMNS)) if any(cells[k] for _, cells in every)]
    laws, further = evaluation_laws(study)
    longitudes = [sectors(study, key, own) for key, own in tables.longitudes.groupby(list(SECTORS), sort=False)]
    sizes, parts = tables.evaluation.ratio, list((record.get("parts") or {}).values()) or [record]
    stops = [r for r in plain(tables.engines) if r["reason"]]
    scene_digits = [digits_of(str(scene), own) for scene, own in tables.digits.groupby("scene", sort=False)]
    scene_floors = [
        floors_of(str(scene), own, rows_of(tables.spread, scene=scene))
        for scene, own in tables.floors.groupby("scene", sort=False)
    ]
    return SimpleNamespace(
        record=record,
        scene_digits=scene_digits,
        scene_floors=scene_floors,
        general=not (scene_digits or scene_floors) or bool({*record["parts"]} - {"scenes", "floors"}),
        finished=is_complete(record),
        sizes=[study.size(float(e)) for e in (sizes.min(), sizes.max())] if len(sizes) and study.radius_m else [],
        digit_columns=[list(DIGIT_COLUMNS)[k] for k in measured],
        digits=[(name, [cells[k] for k in measured]) for name, cells in every if any(cells)],
        charts={  # open ones, and folded ones
            "evaluation": evaluation_charts(study),
            "orbit": (
                run_charts(study, "float64", FIRST),
                run_charts(study, "float64", FURTHER) + run_charts(study, "float32", (*FIRST, *FURTHER)),
            ),
            "least": (least_and_growth(study, FIRST), least_and_growth(study, FURTHER)),
            "engines": (
                [*library_charts(study), *engine_charts(study, "reaction")],
                [p for q in ("attitude", *FURTHER) for p in engine_charts(study, q)],
            ),
        },
        laws=laws,
        further_laws=further,
        best_laws=[best_law(study, r) for r in sorted(cells_of(tables.best_laws), key=lambda r: r["exponent"] is None)],
        growths=[
            law(study, r, (word_of(r), r["coordinates"], r["arithmetic"], study.size(r["ratio"])))
            for r in cells_of(tables.growth_laws)
        ],
        engines=[
            law(study, r, (r["engine"], r["frame"], study.size(r["ratio"]), word_of(r), r["against"].replace("_", " ")))
            for r in cells_of(tables.engine_laws)
        ],
        stops=list(
            dict.fromkeys((r["engine"], r["frame"], r["outcome"].replace("_", " "), r["reason"]) for r in stops)
        ),
        longitudes=longitudes,
        differing=[differing(longitudes, of_formula=of_formula) for of_formula in (True, False)],
        times=[times(r) for r in cells_of(tables.times)],
        units=[(name, spelled(u, 3)) for name, u in study.units.items()],
        failed=[task for part in parts for task in part.get("failed") or ()],
        made=[made for k, made in enumerate(parts) if made.get("created") and made not in parts[:k]],
    )


def cells_of(table: pd.DataFrame) -> list[Row]:
    """Rows of a table, None for a number that is empty or infinite."""
    return plain(table.replace([np.inf, -np.inf], np.nan))


def evaluation_laws(study: Roundoff) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Laws of one evaluation: those shown first, and further ones; none of fewer sizes than a law needs.

    First stand errors of formula and input together, in common arithmetics.
    """
    found: tuple[list[dict[str, Any]], list[dict[str, Any]]] = [], []
    order = {state: k for k, state in enumerate(STATES)}
    for r in sorted(cells_of(study.tables.laws), key=lambda r: order.get(r["state"], len(order))):
        errors = rows_of(study.tables.evaluation, **{name: r[name] for name in EVALUATION})
        if len(study.tables.evaluation) and errors.ratio.nunique() < LEAST_SIZES:
            continue
        usual = r["source"] == "both" and r["bars"] == USUAL["bars"] and r["arithmetic"] in ("float32", "float64")
        vanishing = r["state"] == "horizontal" and r["yardstick"] == "m n² l"
        first = usual and r["formulation"] in FIRST_FORMULATIONS and (r["yardstick"] == "reaction" or vanishing)
        names = FIRST_NAMES if first else ALL_NAMES
        found[not first].append(law(study, r, tuple(str(r[k]) for k in names), r["last_digit_ratio"]))
    return found


def best_law(study: Roundoff, row: Row) -> dict[str, Any]:
    """Law of the smallest error of runs, with the size at which an error that falls with the size leaves no digit."""
    constant, expected, u = row["constant"], row["expected"], study.units.get(row["arithmetic"])
    last = (LOST / (constant * u)) ** (1.0 / expected) if constant and u and expected < 0.0 else None
    method = str(METHODS.get(row["method"], row["method"]))
    of: tuple[str, ...] = (word_of(row), row["coordinates"], row["arithmetic"], method)
    return law(study, row, of, last)


def law(study: Roundoff, row: Row, of: tuple[str, ...], last_digit_ratio: float | None = None) -> dict[str, Any]:
    """Cells of a fitted law.

    Parameters
    ----------
    study : Roundoff
    row : dict
        Row of a table of laws.
    of : tuple of str
        What the law is about.
    last_digit_ratio : float, optional
        Size ratio at which the error leaves no digit; it is marked if it was extrapolated.
    """
    exponent, low, high, expected = (row[k] for k in ("exponent", "low", "high", "expected"))
    constant, sizes = row.get("constant"), study.tables.evaluation.ratio
    fitted = not any(v is None for v in (exponent, low, high))
    beyond = last_digit_ratio is not None and not sizes.min() <= last_digit_ratio <= sizes.max()
    power = "" if expected is None else POWERS.get(expected, f" ε^{expected:g}")
    return {
        "of": of,
        "exponent": exponent,
        "wanted": expected,
        "expected": as_given(expected).replace("-", "\N{MINUS SIGN}"),
        "text": f"{signed(exponent)} ({signed(low)} to {signed(high)})" if fitted else "",
        "off": fitted and expected is not None and not low - SLACK <= expected <= high + SLACK,
        "constant": "" if constant is None else f"{spelled(constant)}\N{NO-BREAK SPACE}u{power}",
        "last_digit": study.size(last_digit_ratio) + BEYOND * beyond,
        "span": " … ".join(study.size(row[k]) for k in ("first", "last") if row[k] is not None),
        "points": int(row["points"] or 0),
        "remark": row["remark"],
    }


def signed(value: float | None) -> str:
    """``−1.01``: a true minus, and none before zero."""
    return "" if value is None else f"{value:z.2f}".replace("-", "\N{MINUS SIGN}")


def word_of(row: Row) -> str:
    """Word of a row's quantity."""
    return QUANTITIES.get(row["quantity"], (row["quantity"], ""))[0].lower()


def sectors(study: Roundoff, key: tuple[Any, ...], own: pd.DataFrame) -> dict[str, Any]:
    """Medians of the sectors of the longitude, beside the 5 to 95 % range of a typical sector."""
    *named, ratio = key
    low, high = float(own.q05.median()), float(own.q95.median())
    least, largest = float(own["median"].min()), float(own["median"].max())
    p = cells_of(own)[0]["p_value"]
    return {
        "of": (*map(str, named), study.size(float(ratio))),
        "medians": " to ".join(dict.fromkeys((spelled(least), spelled(largest)))),
        "bound": " to ".join(dict.fromkeys((spelled(low), spelled(high)))),
        "inside": low <= least and largest <= high,
        "p": p,
        "p_text": spelled(p),
    }


def differing(longitudes: list[dict[str, Any]], *, of_formula: bool) -> tuple[int, int, float]:
    """Tests of sectors that differ, all tests, and those that differ by chance: of the formulas' errors or the input's.

    Only the input's may depend on the longitude.
    """
    own = [r["p"] for r in longitudes if (r["of"][SECTORS.index("source")] == "formula") is of_formula]
    return sum(p is not None and p < SIGNIFICANT for p in own), len(own), SIGNIFICANT * len(own)


def times(row: Row) -> tuple[str, ...]:
    """Code, arithmetic, number of bars; time of an evaluation in relative and absolute coordinates, and the ratio."""
    ends = "" if row["low"] is None or row["high"] is None else f" ({signed(row['low'])} to {signed(row['high'])})"
    told = "" if row["ratio"] is None else f"{signed(row['ratio'])}{ends}"
    seconds = (span_text(row[k]) for k in ("relative_s", "absolute_s"))
    return row["code"], row["arithmetic"], as_given(row["bars"]), *seconds, told
