"""Chapter of an effect budget: what each effect changes, by how much, and at what cost in time.

An effect is relevant if it changes, over the compared time, the attitude by more than M radians, the reactions by more
than M of the largest, or the position of the centre of mass by more than M of its initial distance from the centre of
the body. The last threshold rotates the local horizontal by M radians. An unresolved change counts by its bound: above
M the effect is undecided.
"""

from __future__ import annotations

import math
from enum import StrEnum
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from reports.page import paragraphs
from reports.plotting.palette import COLOURS, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import FINE, TOP, Chart, Scale, across, decade_ticks, upwards
from reports.results.effects import CHANGED, FILES, SIZES, EffectKind
from reports.results.rows import plain
from reports.text.numerals import prefixed, short, significant
from reports.text.record import is_complete
from scenarios.channels import UNITS

if TYPE_CHECKING:
    from pathlib import Path

    from reports.results.rows import Row

MODELS = ("none", "point", "gradient", "quadrupole", "slender")
"""Gravity models, each richer than the model before"""
FEWEST_ROUNDS = 3  # with an interval: the range of n times holds the median with 1 - 2^(1-n), of three 75 %
LEAST_PERCENT = 1e-4  # of the largest reaction: smaller shares read better as powers of ten
WHOLE_RUN = 1e-9  # of the run: a comparison that ends closer to its end covers the run
TITLES = {
    "reaction": ("Change of the reactions", "relative to the largest reaction"),
    "attitude": ("Change of the attitude", "rad"),
    "com": ("Displacement of the centre of mass", "relative to its initial distance"),
}
ROOM = 10.0  # times, below a bound, for its arrow
MARGIN = 1.08  # of the horizontal axis beyond the least and the largest ratio
NARROWEST = 1.15  # ratio that the axis reaches at least, either way
TENTHS, FEWEST_TICKS = 0.1, 3
NAMES, LINE = 120.0, 11.0  # room for the names at the right of a chart, and height of a line, px


class Relevance(StrEnum):
    """Relevance of an effect in a scene."""

    RELEVANT = "relevant"
    UNDECIDED = "undecided"
    """The numerical resolution is coarser than the threshold of relevance"""
    NEGLIGIBLE = "negligible"
    """Resolved, and below the threshold"""
    UNRESOLVED = "unresolved"
    """All changes are below the numerical resolution, which is below the threshold"""
    NOT_SWITCHED = "not switched"


OMISSIBLE = (Relevance.NEGLIGIBLE, Relevance.UNRESOLVED)


class Change(NamedTuple):
    """Change of one quantity by switching an effect."""

    bound: float
    """The change, or its numerical error where that is larger, SI units"""
    resolved: bool
    """Whether the change exceeds its numerical error"""
    share: float
    """Bound relative to the initial distance, to one radian, or to the largest reaction; infinite if that is unknown"""


class BudgetTable(NamedTuple):
    """One of the chapter's tables: a row for each effect."""

    title: str
    headings: tuple[str, ...]
    rows: list[tuple[str, ...]]
    wordy: int = 1
    """Number of text columns at the left"""


def view_effects(folder: Path) -> SimpleNamespace:
    """Contents of the chapter, from the budget in a result folder."""
    tables = FILES.contents(folder)
    record, scene = tables.record, tables.record.get("scene") or {}
    gravity, matters = str(scene.get("gravity") or ""), record.get("matters") or 0.0
    effects = [effect(row, matters, scene) for row in plain(tables.effects.replace([np.inf, -np.inf], np.nan))]
    switched = [e for e in effects if e["relevance"] is not Relevance.NOT_SWITCHED]
    timed = [e for e in effects if e["changes"] and e["time"][0]]
    timed = [e | {"pen": engine_pen(k + 2)} for k, e in enumerate(timed)]
    limit_s, end_s, duration_s = (scene.get(key) or 0.0 for key in ("limit_s", "end_s", "duration_s"))
    timed_s, duration = record.get("timed_s") or duration_s, times(duration_s, scene)
    return SimpleNamespace(
        record=record,
        finished=is_complete(record),
        scene=scene,
        effects=effects,
        remarks=paragraphs("effects/remarks.txt.j2", effects=effects, duration=duration, scene=scene),
        groups=groups(effects, gravity),
        tables=(
            BudgetTable(
                "Changes by each effect",
                ("effect", "in the scene", "relevance", "CM moves by", "bars rotate by", "reactions change by"),
                [change_cells(e) for e in effects],
                wordy=3,
            ),
            BudgetTable(
                "Times with the effect / without it",
                ("effect", "run", "one evaluation", "evaluations", "remainder"),
                [price_cells(e) for e in switched],
            ),
            BudgetTable(
                "Size of each effect",
                ("effect", "differential / tidal", "torque / 3n²J", "common / g"),
                [(e["title"], *(size_text(e, name) for name in SIZES)) for e in switched],
            ),
        ),
        duration=duration,
        predictability_limit=times(limit_s, scene) if 0.0 < limit_s < min(end_s, duration_s) else "",
        rounds=int(record.get("rounds") or 0),
        timed=times(timed_s, scene) if timed_s < duration_s else "",
        charts=[p for name in TITLES if (p := effect_chart(name, timed, matters))],
        legend=[Legend(e["title"] if e["model"] else f"{e['title']} ({e['state']})", e["pen"]) for e in timed],
    )


def effect(row: Row, matters: float, scene: dict[str, Any]) -> dict[str, Any]:
    """Row of the table `effects` with what it means: its changes, its relevance, its ratios of time."""
    duration_s, compared_s = scene.get("duration_s") or 0.0, row["compared_s"]
    cut = compared_s is not None and compared_s < (1.0 - WHOLE_RUN) * duration_s
    widths = [length_text(w) for k in ("least", "largest") if (w := row[f"width_{k}_m"]) is not None]
    gravity, own = row["kind"] == EffectKind.GRAVITY, str(scene.get("gravity") or "")
    scales = {"com": scene.get("radius0_m"), "attitude": 1.0, "reaction": scene.get("largest_reaction_N")}
    changes = {}
    for q, channel in ((c.name, c) for c in CHANGED):
        value, noise, scale = row[channel.column_of()], row[channel.column_of("noise")], scales[q]
        if value is not None and noise is not None:
            bound = max(value, noise)
            changes[q] = Change(bound, value > noise, bound / scale if scale else math.inf)
    relevance = Relevance.NOT_SWITCHED if row["reason"] else classify(changes, matters)
    time = [row[f"time_ratio{end}"] for end in ("", "_low", "_high")]
    found = row | {
        "model": row["effect"].removeprefix("gravity.") if gravity else "",
        "state": row["said"] if gravity else "on" if row["on"] else "off",
        "widths": list(dict.fromkeys(widths)) if len(widths) == 2 else [],
        "changes": changes,
        "relevance": relevance,
        "time": time if (row["rounds"] or 0.0) >= FEWEST_ROUNDS else [time[0], None, None],
        "compared": times(compared_s or 0.0, scene) if cut else "",
        "at_end": cut and (compared_s or 0.0) >= (1.0 - WHOLE_RUN) * (scene.get("end_s") or 0.0),
    }
    return found | {"advice": advice(found, own)}


def classify(changes: dict[str, Change], matters: float) -> Relevance:
    """Classify an effect by its changes and the threshold `matters`."""
    if not changes:
        return Relevance.NOT_SWITCHED
    large = [c for c in changes.values() if c.share > matters]
    if large:
        return Relevance.RELEVANT if any(c.resolved for c in large) else Relevance.UNDECIDED
    return Relevance.NEGLIGIBLE if any(c.resolved for c in changes.values()) else Relevance.UNRESOLVED


def advice(e: dict[str, Any], own: str) -> str:
    """What to do, with the scene's gravity model `own`; empty on a relevant effect of the design, which is wanted."""
    relevance, omissible, model = e["relevance"], e["relevance"] in OMISSIBLE, e["model"]
    if relevance is Relevance.NOT_SWITCHED:
        return str(e["reason"] or "not run")
    if relevance is Relevance.UNDECIDED:
        return "use a smaller --rtol"
    if model and MODELS.index(model) > MODELS.index(own):
        return f"{own} suffices" if omissible else f"use {model}"
    if model:
        return f"{model} would suffice" if omissible else f"keep {own}"
    if omissible:
        return "can be switched off" if e["on"] else "leave it off"
    needless = e["kind"] == EffectKind.DESIGN
    return "" if needless else "keep it on" if e["on"] else "switch it on"


def groups(effects: list[dict[str, Any]], own: str) -> dict[str, list[str]]:
    """Titles of the effects by relevance, and gravity models by their difference from the scene's own."""
    relevant = (Relevance.RELEVANT,)
    shown = (
        ("Relevant", relevant, False),
        ("Negligible", OMISSIBLE, False),
        ("Undecided", (Relevance.UNDECIDED,), False),
        ("No conclusion", (Relevance.NOT_SWITCHED,), False),
        (f"Gravity models that differ from {own}", relevant, True),
        (f"Gravity models that agree with {own}", OMISSIBLE, True),
    )
    found = {
        name: [e["model"] or e["title"] for e in effects if bool(e["model"]) is models and e["relevance"] in kinds]
        for name, kinds, models in shown
    }
    return {name: titles or ["none"] for name, titles in found.items() if titles or name == "Relevant"}


def change_cells(e: dict[str, Any]) -> tuple[str, ...]:
    """Cells of an effect's changes."""
    said = f"{e['relevance']}: {e['advice']}" if e["advice"] else str(e["relevance"])
    known = {} if e["relevance"] is Relevance.NOT_SWITCHED else e["changes"]
    changes = (change_text(c.name, known[c.name]) if c.name in known else "" for c in CHANGED)
    return (e["title"], e["state"], said, *changes)


def change_text(quantity: str, change: Change) -> str:
    """``612 km``, or ``unresolved, < 70 mm``: never zero; reactions relative to the largest."""
    if quantity == "com":
        text = length_text(change.bound)
    elif quantity == "attitude" or math.isinf(change.share):
        text = f"{significant(change.bound, 2)} {UNITS[quantity]}"
    else:
        text = share_text(change.share)
    return text if change.resolved else f"unresolved, < {text}"


def length_text(metres: float) -> str:
    """``612 km``; from a kilometre on kilometres, below it metres or parts of one."""
    factor, unit = (1e-3, "km") if metres >= 1e3 else prefixed(metres, "m")
    return f"{short(metres * factor)} {unit}"


def share_text(share: float) -> str:
    """``0.13 %``; ``3.1×10⁻⁸``."""
    return f"{short(100.0 * share)} %" if share >= LEAST_PERCENT else significant(share, 2)


def times(seconds: float, scene: dict[str, Any]) -> str:
    """``2.76 orbits``, or seconds where nothing is orbited."""
    if scene.get("bound") and scene.get("period_s"):
        count = f"{seconds / scene['period_s']:.3g}"
        return f"{count} orbit{'s' * (count != '1')}"
    return f"{seconds:.4g} s"


def price_cells(e: dict[str, Any]) -> tuple[str, ...]:
    """Cells of an effect's cost; the remainder is the factor of the run due to work between evaluations.

    That is event search and restarted steps. It stands where the run's ratio is resolved.
    """
    (run, low, high), one, count = e["time"], e["evaluation_ratio"], e["evaluations_ratio"]
    resolved = low is not None and high is not None and not low <= 1.0 <= high
    remainder = run / (one * count) if resolved and run is not None and one and count else None
    evaluation = (one, e["evaluation_ratio_low"], e["evaluation_ratio_high"])
    return (e["title"], *(ratio_text(*r) for r in ((run, low, high), evaluation, (count,), (remainder,))))


def ratio_text(value: float | None, low: float | None = None, high: float | None = None) -> str:
    """``1.62 (1.58-1.70)``, with an en dash; ``23.4``."""
    if value is None:
        return ""
    text = f"{value:.2f}" if value < 10.0 else significant(value)
    return text if low is None or high is None else f"{text} ({ratio_text(low)}\N{EN DASH}{ratio_text(high)})"


def size_text(e: dict[str, Any], name: str) -> str:
    """Size at the start, and the largest over the run if its first two digits differ."""
    start, largest = (e[f"{name}_{when}"] for when in ("start", "largest"))
    if start is None or largest is None:
        return ""
    first, most = significant(start, 2), significant(largest, 2)
    return first if first == most else f"{first} (to {most})"


def effect_chart(name: str, timed: list[dict[str, Any]], matters: float) -> Panel | None:
    """Chart of the change of a quantity against the cost in time; None if there is nothing to draw.

    A point is filled if its change is resolved, else outlined at its bound with an arrow down. The names stand at the
    right, in the order of the changes.
    """
    points = [(e, c) for e in timed if (c := e["changes"].get(name)) and math.isfinite(c.share)]
    least = [c.share / (1.0 if c.resolved else ROOM) for _, c in points]
    up = decade_range([np.array([*least, *(c.share for _, c in points), matters])]) if points else None
    if up is None:
        return None
    title, unit = TITLES[name]
    reaches = [[ratio if end is None else end for end in ends] for e, _ in points for ratio, *ends in [e["time"]]]
    left = min(1.0 / NARROWEST, *(low for low, _ in reaches)) / MARGIN
    right = max(NARROWEST, *(high for _, high in reaches)) * MARGIN
    x, y = across(left, right, log=True), upwards(up.low, up.high, log=True)
    chart = Chart(Scale(left, right, x.start, x.end - NAMES, log=True), y)
    chart.axes("run time with the effect / without it", unit, ratio_ticks(left, right))
    chart.up_at(1.0, COLOURS["rule"])
    chart.across_at(matters, COLOURS["muted"], 0.9, "30 25")
    shown = sorted(zip(points, reaches, strict=True), key=lambda p: -p[0][1].share)
    heights = [float(chart.y(up.lift(np.array([change.share]))[0][0])) for (_, change), _ in shown]
    for ((e, change), reach), height, name_at in zip(shown, heights, spaced(heights), strict=True):
        at, pen = float(up.lift(np.array([change.share]))[0][0]), e["pen"]
        place = float(chart.x(e["time"][0])), height
        chart.line(np.array(reach), np.array([at, at]), pen.colour, 1.1)
        chart.marks(e["time"][0], at, pen.marker, pen.colour, 7.0, hollow=not change.resolved, edge=1.0)
        if not change.resolved:
            arrow = f"M{FINE * place[0]:.0f} {FINE * height + 40:.0f}v120m-30-40l30 40l30-40"
            chart.stroke(arrow, pen.colour, 0.9)
        chart.straight((chart.x.end + 2.0, name_at), place, pen.colour, 0.4)
        chart.text((chart.x.end + 5.0, name_at + 4.0), e["title"], "start", pen.colour.name)
    return Panel(title, chart.svg(title))


def spaced(heights: list[float]) -> list[float]:
    """Heights of names, px, from the top: as near to some rising heights as a line for each allows."""
    found = list(heights)
    for k in reversed(range(len(found) - 1)):
        found[k] = min(found[k], found[k + 1] - LINE)
    for k in range(len(found)):
        found[k] = max(found[k], found[k - 1] + LINE if k else TOP)
    return found


def ratio_ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Labelled ratios: 1, 2 and 5 of each decade, tenths of a narrow axis, powers of ten of a wide one."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    fine = [m * 10.0**k for k in decades for m in (1.0, 2.0, 5.0) if low <= m * 10.0**k <= high]
    if len(fine) < FEWEST_TICKS:
        fine = [k / 10.0 for k in range(5, 20) if low <= k / 10.0 <= high]
    return [(v, f"{v:.3g}") for v in fine] if len(fine) <= 7 else decade_ticks(low, high)
