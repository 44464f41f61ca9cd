"""Chapter of an effect budget: what each effect changes, by how much, and at what cost in time.

An effect is relevant if it changes, over the compared time, the attitude by more than M radians, the reactions by more
than M of the largest, or the position of the centre of mass by more than M of its initial distance from the centre of
the body. The last threshold rotates the local horizontal by M radians. An unresolved change counts by its bound: above
M the effect is undecided.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from itertools import product
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from reports.page import paragraphs
from reports.plotting.palette import COLOURS, Pen, engine_pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import BOTTOM, FINE, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Chart, across, upwards
from reports.tables.effects import QUANTITIES, SIZES, UNITS, EffectKind, read_effects
from reports.text.numerals import number, prefixed, short, significant
from reports.text.record import is_complete, mapping

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from reports.plotting.series import DecadeRange

    Spread = tuple[float | None, float | None, float | None]

MODELS = ("none", "point", "gradient", "quadrupole", "slender")
"""Gravity models, each richer than the model before"""
FEWEST_ROUNDS = 3  # with an interval: the range of n times holds the median with 1 - 2^(1-n), of three 75 %
LEAST_PERCENT = 1e-4  # of the largest reaction: smaller shares read better as powers of ten
WHOLE_RUN = 1e-9  # of the run: a comparison that ends closer to its end covers the run
WORDY = 3  # columns of words, at the left of the changes; one elsewhere

TITLES = {
    "reaction": ("Change of the reactions", "relative to the largest reaction"),
    "attitude": ("Change of the attitude", "rad"),
    "com": ("Displacement of the centre of mass", "relative to its initial distance"),
}
X_LABEL = "run time with the effect / without it"
MARKER_SIZE = 7.0
ROOM = 10.0  # times, below a bound, for its arrow
MARGIN = 1.08  # of the horizontal axis beyond the least and the largest ratio
MOST_TICKS = 7
CLOSE = 2.0  # times the least ratio: an axis that spans less has tenths
TENTHS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7)
NARROWEST = 1.15  # ratio that the axis reaches at least, either way
LETTER, LINE = 5.4, 11.0  # width of a letter and height of a line, px
CLEAR = 5.5  # px from a point's middle that a name keeps off
SHIFTS = (0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0, 5.0, -5.0)  # lines up


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
    scale: float
    """Initial distance, one radian, largest reaction; 0 if unknown"""

    @property
    def share(self) -> float:
        """Bound relative to the scale."""
        return self.bound / self.scale if self.scale else math.inf


class Box(NamedTuple):
    """Rectangle, px."""

    left: float
    low: float
    right: float
    high: float

    def meets(self, other: Box) -> bool:
        """Whether two boxes overlap."""
        return self.left < other.right and other.left < self.right and self.low < other.high and other.low < self.high


@dataclass(frozen=True)
class BudgetTable:
    """One of the chapter's tables: a row for each effect."""

    title: str
    headings: tuple[str, ...]
    rows: list[tuple[str, ...]]
    wordy: int = 1
    """Number of text columns at the left"""


def view_effects(folder: Path) -> SimpleNamespace:
    """Contents of the chapter, from the budget in a result folder."""
    tables = read_effects(folder)
    record, scene = tables.record, mapping(tables.record.get("scene"))
    effects = [effect(row, record, scene) for row in tables.effects.to_dict("records")]
    switched = [e for e in effects if e["relevance"] is not Relevance.NOT_SWITCHED]
    limit_s, end_s, duration_s = (number(scene.get(key)) or 0.0 for key in ("limit_s", "end_s", "duration_s"))
    timed_s, duration = number(record.get("timed_s")) or duration_s, times(duration_s, scene)
    return SimpleNamespace(
        record=record,
        finished=is_complete(record),
        scene=scene,
        effects=effects,
        remarks=paragraphs(
            "effects/remarks.txt.j2", effects=effects, duration=duration, ended=str(scene.get("ended") or "")
        ),
        groups=groups(effects, str(scene.get("gravity") or "")),
        tables=(
            BudgetTable(
                "Changes by each effect",
                ("effect", "in the scene", "relevance", "CM moves by", "bars rotate by", "reactions change by"),
                [change_cells(e) for e in effects],
                WORDY,
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
        rounds=int(number(record.get("rounds")) or 0),
        timed=times(timed_s, scene) if timed_s < duration_s else "",
        charts=[p for name in TITLES if (p := effect_chart(name, effects, number(record.get("matters")) or 0.0))],
        legend=[Legend(e["title"] if e["model"] else f"{e['title']} ({e['state']})", e["pen"]) for e in timed(effects)],
    )


def effect(row: dict[Any, Any], record: dict[str, Any], scene: dict[str, Any]) -> dict[str, Any]:
    """Row of the table `effects` with what it means: its changes, its relevance, its ratios of time."""
    duration_s, compared_s = number(scene.get("duration_s")) or 0.0, finite(row["compared_s"])
    cut = compared_s is not None and compared_s < (1.0 - WHOLE_RUN) * duration_s
    at_end = cut and (compared_s or 0.0) >= (1.0 - WHOLE_RUN) * (number(scene.get("end_s")) or 0.0)
    widths = [length_text(w) for k in ("least", "largest") if (w := finite(row[f"width_{k}_m"])) is not None]
    gravity, changes = row["kind"] == EffectKind.GRAVITY, changes_of(row, scene)
    relevance = Relevance.NOT_SWITCHED if row["reason"] else classify(changes, number(record.get("matters")) or 0.0)
    found = {str(k): v for k, v in row.items()} | {
        "model": row["effect"].removeprefix("gravity.") if gravity else "",
        "state": row["said"] if gravity else "on" if row["on"] else "off",
        "widths": list(dict.fromkeys(widths)) if len(widths) == 2 else [],
        "changes": changes,
        "relevance": relevance,
        "time": ratio(row, "time_ratio", (finite(row["rounds"]) or 0.0) >= FEWEST_ROUNDS),
        "evaluation": ratio(row, "evaluation_ratio"),
        "evaluations": finite(row["evaluations_ratio"]),
        "compared": times(compared_s or 0.0, scene) if cut else "",
        "at_end": at_end,
    }
    return found | {"advice": advice(found, str(scene.get("gravity") or ""))}


def finite(value: object) -> float | None:
    """Number of a cell; None where it is empty or infinite."""
    found = number(value)
    return found if found is not None and math.isfinite(found) else None


def changes_of(row: dict[Any, Any], scene: dict[str, Any]) -> dict[str, Change]:
    """Measured changes of a row."""
    scales = {"com": scene.get("radius0_m"), "attitude": 1.0, "reaction": scene.get("largest_reaction_N")}
    found = {}
    for q in QUANTITIES:
        value, noise = finite(row[f"{q}_{UNITS[q]}"]), finite(row[f"{q}_noise_{UNITS[q]}"])
        if value is not None and noise is not None:
            found[q] = Change(max(value, noise), value > noise, number(scales[q]) or 0.0)
    return found


def classify(changes: dict[str, Change], matters: float) -> Relevance:
    """Classify an effect by its changes and the threshold `matters`."""
    if not changes:
        return Relevance.NOT_SWITCHED
    large = [c for c in changes.values() if c.share > matters]
    if any(c.resolved for c in large):
        return Relevance.RELEVANT
    if large:
        return Relevance.UNDECIDED
    return Relevance.NEGLIGIBLE if any(c.resolved for c in changes.values()) else Relevance.UNRESOLVED


def ratio(row: dict[Any, Any], name: str, enough: bool = True) -> Spread:
    """Time with an effect relative to the time without it, and its interval; none of too few rounds."""
    value, low, high = (finite(row[key]) for key in (name, f"{name}_low", f"{name}_high"))
    return (value, low, high) if enough else (value, None, None)


def advice(e: dict[str, Any], own: str) -> str:
    """What to do; empty on a relevant effect of the design, which nobody would leave out.

    Parameters
    ----------
    own : str
        The scene's gravity model.
    """
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
    others = [e for e in effects if not e["model"]]
    models = [e for e in effects if e["model"]]
    found = {
        "Relevant": [e["title"] for e in others if e["relevance"] is Relevance.RELEVANT],
        "Negligible": [e["title"] for e in others if e["relevance"] in OMISSIBLE],
        "Undecided": [e["title"] for e in others if e["relevance"] is Relevance.UNDECIDED],
        "No conclusion": [e["title"] for e in others if e["relevance"] is Relevance.NOT_SWITCHED],
        f"Gravity models that differ from {own}": [e["model"] for e in models if e["relevance"] is Relevance.RELEVANT],
        f"Gravity models that agree with {own}": [e["model"] for e in models if e["relevance"] in OMISSIBLE],
    }
    return {name: titles or ["none"] for name, titles in found.items() if titles or name == "Relevant"}


def change_cells(e: dict[str, Any]) -> tuple[str, ...]:
    """Cells of an effect's changes."""
    said = f"{e['relevance']}: {e['advice']}" if e["advice"] else str(e["relevance"])
    known = {} if e["relevance"] is Relevance.NOT_SWITCHED else e["changes"]
    return (e["title"], e["state"], said, *(change_text(q, known[q]) if q in known else "" for q in QUANTITIES))


def change_text(quantity: str, change: Change) -> str:
    """``612 km``, or ``unresolved, < 70 mm``: never zero; reactions relative to the largest."""
    if quantity == "com":
        text = length_text(change.bound)
    elif quantity == "attitude" or not change.scale:
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
    period_s = number(scene.get("period_s"))
    if scene.get("bound") and period_s:
        count = f"{seconds / period_s:.3g}"
        return f"{count} orbit{'s' * (count != '1')}"
    return f"{seconds:.4g} s"


def price_cells(e: dict[str, Any]) -> tuple[str, ...]:
    """Cells of an effect's cost."""
    return (e["title"], *(ratio_text(*r) for r in (e["time"], e["evaluation"], (e["evaluations"],), (remainder(e),))))


def remainder(e: dict[str, Any]) -> float | None:
    """Factor of the run time due to work between evaluations: event search and restarted steps.

    None if the run's ratio is not resolved.
    """
    (run, low, high), (one, *_), number_of = e["time"], e["evaluation"], e["evaluations"]
    resolved = low is not None and high is not None and not low <= 1.0 <= high
    return run / (one * number_of) if resolved and run is not None and one and number_of else None


def ratio_text(value: float | None, low: float | None = None, high: float | None = None) -> str:
    """``1.62 (1.58-1.70)``, with an en dash; ``23.4``."""
    if value is None:
        return ""
    text = f"{value:.2f}" if value < 10.0 else significant(value)
    return text if low is None or high is None else f"{text} ({ratio_text(low)}\N{EN DASH}{ratio_text(high)})"


def size_text(e: dict[str, Any], name: str) -> str:
    """Size at the start, and the largest over the run if its first two digits differ."""
    start, largest = (finite(e[f"{name}_{when}"]) for when in ("start", "largest"))
    if start is None or largest is None:
        return ""
    first, most = significant(start, 2), significant(largest, 2)
    return first if first == most else f"{first} (to {most})"


def timed(effects: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Effects that were switched and timed, each with its pen in all charts."""
    found = [e for e in effects if e["changes"] and e["time"][0]]
    return [e | {"pen": engine_pen(k + 2)} for k, e in enumerate(found)]


class Point(NamedTuple):
    """One effect in one chart."""

    title: str
    pen: Pen
    share: float
    resolved: bool
    ratio: float
    reach: tuple[float, float]
    """Interval of the ratio"""


def effect_chart(name: str, effects: list[dict[str, Any]], matters: float) -> Panel | None:
    """Chart of the change of a quantity against the cost in time; None if there is nothing to draw.

    A point is filled if its change is resolved, else outlined at its bound with an arrow down.
    """
    points = []
    for e in timed(effects):
        change, (value, low, high) = e["changes"].get(name), e["time"]
        if change and change.scale:
            reach = (value if low is None else low, value if high is None else high)
            points.append(Point(e["title"], e["pen"], change.share, change.resolved, value, reach))
    least = [p.share / (1.0 if p.resolved else ROOM) for p in points]
    up = decade_range([np.array([*least, *(p.share for p in points), matters])]) if points else None
    if up is None:
        return None
    title, unit = TITLES[name]
    left = min(1.0 / NARROWEST, *(p.reach[0] for p in points)) / MARGIN
    right = max(NARROWEST, *(p.reach[1] for p in points)) * MARGIN
    chart = Chart(across(left, right, log=True), upwards(up.low, up.high, log=True))
    chart.axes(X_LABEL, unit, [(v, f"{v:.3g}") for v in ticks(left, right)])
    chart.up_at(1.0, COLOURS["rule"])
    chart.across_at(matters, COLOURS["muted"], 0.9, "30 25")
    for p in points:
        y = lifted(up, p.share)
        chart.line(np.array(p.reach), np.array([y, y]), p.pen.colour, 1.1)
        chart.marks(p.ratio, y, p.pen.marker, p.pen.colour, MARKER_SIZE, hollow=not p.resolved, edge=1.0)
        if not p.resolved:
            at, top = FINE * float(chart.x(p.ratio)), FINE * float(chart.y(y))
            chart.stroke(f"M{at:.0f} {top + 40:.0f}v120m-30-40l30 40l30-40", p.pen.colour, 0.9)
    name_points(chart, points, up)
    return Panel(title, chart.svg(title))


def lifted(up: DecadeRange, share: float) -> float:
    """A share, or the lower edge of the axis where it is below."""
    return float(up.lift(np.array([share]))[0][0])


def ticks(low: float, high: float) -> list[float]:
    """Labelled ratios: 1, 2 and 5 of each decade, or 1 alone if there are too many."""
    if high / low < CLOSE:
        return [v for v in TENTHS if low <= v <= high]
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    fine = [m * 10.0**k for k in decades for m in (1.0, 2.0, 5.0) if low <= m * 10.0**k <= high]
    return fine if len(fine) <= MOST_TICKS else [10.0**k for k in decades]


def name_points(chart: Chart, points: list[Point], up: DecadeRange) -> None:
    """Write the name of each effect beside its point, with a line to a name that is farther away."""
    at = [(float(chart.x(p.ratio)) - LEFT, chart.y.start - float(chart.y(lifted(up, p.share)))) for p in points]
    taken = []
    for (x, y), p in zip(at, points, strict=True):
        low, high = (float(chart.x(r)) - LEFT for r in p.reach)
        taken.append(Box(min(low, x - CLEAR), y - 3.0, max(high, x + CLEAR), y + 3.0))
    names = placed([p.title for p in points], taken, (WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM))
    for p, (x, y), box in zip(points, at, names, strict=True):
        if box is None:  # the legend has it
            continue
        right, middle = box.left > x, 0.5 * (box.low + box.high)
        near = (LEFT + (box.left if right else box.right), chart.y.start - middle)
        if abs(middle - y) > LINE:
            chart.straight((LEFT + x, chart.y.start - y), near, p.pen.colour, 0.5)
        chart.text((near[0], near[1] + 4.0), p.title, "start" if right else "end", p.pen.colour.name)


def placed(names: Sequence[str], points: list[Box], size: tuple[float, float]) -> list[Box | None]:
    """Boxes of names beside points in a plot of this size, none on another; None for a name that fits nowhere.

    A name stands right or left of its point, or lines above or below, as near as it can.
    """
    taken, found = list(points), dict[int, Box | None]()
    for k in sorted(range(len(names)), key=lambda k: -(points[k].low + points[k].high)):
        point, wide = points[k], LETTER * len(names[k])
        found[k] = None
        for shift, right in product(SHIFTS, (True, False)):
            left, middle = (point.right + 2.0 if right else point.left - 2.0 - wide), 0.5 * (point.low + point.high)
            low = middle - 0.5 * LINE + shift * LINE
            box = Box(left, low, left + wide, low + LINE)
            inside = left >= 0.0 and box.right <= size[0] and low >= 0.0 and box.high <= size[1]
            if inside and not any(box.meets(t) for t in taken):
                found[k] = box
                taken.append(box)
                break
    return [found[k] for k in range(len(names))]
