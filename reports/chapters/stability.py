"""Chapter of a stability study: matrix of hard scenes and engines, largest deviation, drifts of long runs, evidence."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import ChartFrame, Legend, Line, Panel, draw, guide, linear_panel, log_panel
from reports.plotting.series import Array, decade_range, numbered, thin
from reports.plotting.svg import Chart, across, upwards
from reports.results.rows import NOT_RUN, plain
from reports.results.stability import FILES, Stability
from reports.text.numerals import SUPERSCRIPTS
from reports.text.record import is_complete
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    import pandas as pd

    from reports.results.files import StudyTables

SIGNS = {
    Stability.STABLE: ("✓", "pass"),
    Stability.DRIFTING: ("↗", "gone"),
    Stability.INACCURATE: ("≠", "fail"),
    Stability.UNSTABLE: ("⇈", "fail"),
    Stability.FAILED: ("✗", "fail"),
    Stability.REJECTED: ("⊘", "gone"),
    Stability.UNSUPPORTED: ("–", "aside"),
}
"""Sign and colour class of each outcome"""
LATE = ("◷", "timed out", "gone")
CHANGES = {"better": "↑ better", "worse": "↓ worse"}
LARGE_ERROR_RAD = 0.01  # of the attitude: a larger error counts as wrong
NAMES = {"coarse": "{}.coarse", "default": "{}", "finer": "{}.finer"}

GUIDES = {0.5: "√t", 1.0: "t", 2.0: "t²"}
LEVEL_DASHES = {"coarse": (2.0, 1.6), "default": (), "finer": (6.0, 2.0)}
LEVEL_PENS = {level: Pen(COLOURS["s3"], "", dash) for level, dash in LEVEL_DASHES.items()}
SOLUTION_PEN = Pen(COLOURS["ink"])
OUTSIDE_RAD = 2.0 * np.pi  # beyond the range of the reference solution: a diverged run is not drawn farther
COMPILED, PLAIN_SUMS, EXACT_SUMS = "reference-fast", "solution", "exact"
SUMS = {  # of tight runs: label, pen
    PLAIN_SUMS: ("rtol = 1e-13", Pen(COLOURS["accent"], "", (6.0, 2.0))),
    EXACT_SUMS: ("rtol = 1e-14, compensated", Pen(COLOURS["accent"])),
}
LONG = {
    "energy": ("Energy", "change relative to kinetic energy"),
    "attitude": ("Attitude", "difference from reference, rad"),
}
"""Title and vertical axis of the quantities of long runs"""


def view_stability(folder: Path) -> SimpleNamespace:
    """Contents of the page, from the study in a result folder."""
    tables = FILES.contents(folder)
    record = tables.record
    engines, references = list(record.get("engines") or {}), list(record.get("references") or ())
    scenes = scenes_of(tables, engines)
    outcomes = [o for s in scenes for o in s["outcomes"].values()]
    own = [o for o in outcomes if o["engine"] in references]
    return SimpleNamespace(
        record=record,
        finished=is_complete(record),
        engines=engines,
        references=references,
        scenes=scenes,
        outcomes=outcomes,
        counts={str(s): n for s in Stability if (n := sum(o["stability"] == s for o in outcomes))},
        unstable=[o for o in own if not o["slow"] and o["stability"] != Stability.STABLE],
        late=[o for o in own if o["slow"]],
        changed=[o for o in outcomes if o["changed"]],
        signs=[(SIGNS[s][0], str(s), SIGNS[s][1], s.advice) for s in Stability],
        timed_out=LATE,
        worst=worst(tables, {(o["scene"], o["engine"]): o for o in outcomes}),
        long=[long_scene(tables, name, engines) for name in dict.fromkeys(tables.laws.scene)],
        sums=sums(tables.laws),
        plain=plain(tables.plain),
        wrong=wrong_successes(tables.plain),
        large_error_rad=LARGE_ERROR_RAD,
    )


def scenes_of(tables: StudyTables, engines: list[str]) -> list[dict[str, Any]]:
    """Scenes in the order of the command: name, record, outcomes by engine, evidence."""
    outcomes = {(r["scene"], r["engine"]): outcome(r) for r in plain(tables.outcomes)}
    evidence = plain(tables.evidence)
    return [
        {
            "name": name,
            "about": about,
            "outcomes": {e: outcomes[name, e] for e in engines if (name, e) in outcomes},
            "evidence": [row for row in evidence if row["scene"] == name],
        }
        for name, about in (tables.record.get("scenes") or {}).items()
    ]


def outcome(row: dict[str, Any]) -> dict[str, Any]:
    """Row of `outcomes` with its sign, word, colour, exponent of a drift and change since the recorded outcome."""
    if row["stability"] == NOT_RUN:  # a finer run than one that took too long
        row = row | {"stability": Stability.FAILED.value, "reason": f"{NOT_RUN}: {row['reason']}"}
    stability = Stability(row["stability"])
    sign, kind = SIGNS[stability]
    word, exponent = row["stability"], row["exponent"]
    if row["slow"]:
        sign, word, kind = LATE
    return row | {
        "sign": sign,
        "word": word,
        "kind": kind,
        "below": "" if exponent is None else f"t{raised(exponent, 1)}",
        "changed": f"{CHANGES[row['change']]}, was {row['expected']}" if row["change"] else "",
        "advice": stability.advice,
    }


def raised(exponent: float, digits: int = 2) -> str:
    """``⁰·⁹⁸``, for text where no markup can go."""
    return f"{exponent:.{digits}f}".translate(SUPERSCRIPTS).replace(".", "·")


def wrong_successes(table: pd.DataFrame) -> dict[str, int]:
    """Successes that SciPy reports at its defaults: all, those with a large error or another end, the latter alone."""
    succeeded = [r for r in plain(table) if r["run"] == "pass"]
    ended = [r for r in succeeded if r["judged"] == "incomplete"]
    off = [r for r in succeeded if (r["attitude_rad"] or 0.0) > LARGE_ERROR_RAD]
    wrong = {(r["scene"], r["engine"]) for r in (*off, *ended)}
    return {"succeeded": len(succeeded), "wrong": len(wrong), "ended": len(ended)}


def sums(laws: pd.DataFrame) -> dict[str, Any] | None:
    """Energy drifts of plain and of compensated sums, in the first long scene with both runs."""
    energy = [r for r in plain(laws) if r["engine"] == COMPILED and r["quantity"] == "energy"]
    for scene in dict.fromkeys(laws.scene):
        own = {r["level"]: r | {"power": raised(r["exponent"] or 0.0)} for r in energy if r["scene"] == scene}
        if own.keys() >= SUMS.keys():
            rounded, exact = own[PLAIN_SUMS], own[EXACT_SUMS]
            ratio = (rounded["at_end"] or 0.0) / (exact["at_end"] or math.nan)
            return {"scene": scene, "plain": rounded, "exact": exact, "ratio": ratio}
    return None


def worst(tables: StudyTables, outcomes: dict[tuple[str, str], dict[str, Any]]) -> dict[str, Any] | None:
    """Run with the largest deviation: largest energy of unstable runs, else largest error of inaccurate ones.

    Only runs with a stored attitude can be drawn.
    """
    rows = {(r["scene"], r["engine"]): r for r in plain(tables.evidence) if r["level"] == "default"}
    for kind, measure in ((Stability.UNSTABLE, "kinetic_ratio"), (Stability.INACCURATE, "attitude_rad")):
        sizes = {p: rows[p][measure] for p, o in outcomes.items() if o["stability"] == kind and p in rows}
        for pair in sorted((p for p, v in sizes.items() if v is not None), key=lambda p: -sizes[p]):
            about = tables.record["scenes"][pair[0]]
            panels = worst_charts(tables, *pair, about)
            if panels:
                return {"outcome": outcomes[pair], "title": str(about.get("title") or pair[0]), "panels": panels}
    return None


def worst_charts(tables: StudyTables, scene: str, engine: str, about: dict[str, Any]) -> list[Panel]:
    """Charts of the bar with the largest error beside the reference solution, and of the error at each setting."""
    frames = {k: tables.trajectory(scene, name.format(engine)) for k, name in NAMES.items()}
    solution = tables.trajectory(scene, "solution")
    right = None if solution is None else numbered(solution, *CHANNELS["attitude"].columns)
    runs = {k: (f["t_s"].to_numpy(float), a) for k, f in frames.items()
            if f is not None and (a := numbered(f, *CHANNELS["attitude"].columns)) is not None}  # fmt: skip
    if solution is None or right is None or not runs:
        return []
    period, duration = about.get("period_s") or 0.0, about.get("duration_s") or 0.0
    unit_s, x_label = (period, "orbits") if period > 0.0 and duration > 0.5 * period else (1.0, "s")
    t = solution["t_s"].to_numpy(float) / unit_s
    errors = {k: np.abs(a[: len(right)] - right[: len(a)]) for k, (_, a) in runs.items()}
    common = min(map(len, errors.values()))
    bar = int(np.argmax(np.max([e[:common].max(axis=0) for e in errors.values()], axis=0)))
    followed = [Line(t, right[:, bar], SOLUTION_PEN)]
    followed += [Line(x / unit_s, near(a[:, bar], right[:, bar]), LEVEL_PENS[k]) for k, (x, a) in runs.items()]
    off = [Line(runs[k][0][: len(e)] / unit_s, e.max(axis=1), LEVEL_PENS[k]) for k, e in errors.items() if len(e)]
    legend = [Legend(f"{engine}, {k} setting", LEVEL_PENS[k]) for k in runs]
    span = (0.0, float(t[-1]))
    found = (
        (linear_panel(ChartFrame(f"Angle of bar {bar + 1}", x_label, "rad", span, followed)),
         [Legend("reference solution", SOLUTION_PEN), *legend]),
        (log_panel(ChartFrame("Largest error of all angles", x_label, "rad", span, off)), legend),
    )  # fmt: skip
    return [Panel(p.title, p.svg, p.note, tuple(words)) for p, words in found if p]


def near(angle: Array, right: Array) -> Array:
    """Angle until it leaves the range of the reference solution."""
    inside = (angle >= right.min() - OUTSIDE_RAD) & (angle <= right.max() + OUTSIDE_RAD)
    return np.where(np.logical_and.accumulate(inside), angle, np.nan)


def long_scene(tables: StudyTables, name: str, engines: list[str]) -> dict[str, Any]:
    """Charts and laws of one long scene."""
    about = tables.record["scenes"][name]
    period_s = about.get("period_s") or 1.0
    series = tables.long[(tables.long.scene == name) & tables.long.level.isin(["default", *SUMS])]
    panels = [drift_chart(series[series.quantity == q], f"{title}, {name}", y_label, engines, period_s)
              for q, (title, y_label) in LONG.items()]  # fmt: skip
    laws = [r for r in plain(tables.laws) if r["scene"] == name]
    return {"name": name, "title": str(about.get("title") or name), "panels": list(filter(None, panels)), "laws": laws}


def drift_chart(
    series: pd.DataFrame, title: str, y_label: str, engines: Iterable[str], period_s: float
) -> Panel | None:
    """Log-log chart of drifts against time with guide lines of known powers; None if there is nothing to draw."""
    lines, order = [], {engine: k for k, engine in enumerate(engines)}
    for (engine, level), rows in series.groupby(["engine", "level"], sort=False):
        words, pen = SUMS.get(str(level), ("", engine_pen(order.get(str(engine), 0))))
        x, y = rows.t_s.to_numpy(float) / period_s, rows.value.to_numpy(float)
        if (y > 0.0).any():
            lines.append((f"{engine}, {words}" if words else str(engine), pen, x, y))
    up = decade_range([y for *_, y in lines])
    if up is None:
        return None
    ends = min(float(x[x > 0.0].min()) for *_, x, _ in lines), max(float(x.max()) for *_, x, _ in lines)
    chart = Chart(across(*ends, log=True), upwards(up.low, up.high, log=True))
    chart.axes("orbits", y_label)
    for power, word in GUIDES.items():
        guide(chart, power, word)
    for _, pen, x, y in lines:
        good = (y > 0.0) & (x > 0.0)
        draw(chart, Line(x[good], y[good], pen), *thin(x[good], y[good]))
    legend = tuple(Legend(label, pen) for label, pen, *_ in lines)
    svg = chart.svg(title.partition(",")[0])
    return Panel(title, svg, "Dotted: powers of t. Curves are running maxima.", legend)
