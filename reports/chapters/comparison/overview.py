"""First screen of a comparison: the verdict, the matrix of scenes and engines, and all normalised errors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reports.page import paragraphs
from reports.plotting.palette import COLOURS, Pen
from reports.plotting.panels import Legend, Panel
from reports.plotting.series import decade_range
from reports.plotting.svg import Chart, Scale
from reports.results.cost import INDEPENDENT, KINDS, OWN_EQUATIONS
from reports.results.outcome import Outcome
from reports.text.numerals import power_of_ten, significant

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.chapters.comparison.summary import RunCell, Summary
    from reports.text.record import SceneRecord

SYMBOLS = {
    Outcome.PASS: "✓",
    Outcome.REPORTED: "·",
    Outcome.UNSUPPORTED: "–",
    Outcome.ROUNDOFF_LIMITED: "≈",
    Outcome.INCONSISTENT: "≠",
    Outcome.EXCEEDS_BOUND: "▲",
    Outcome.TOO_COARSE: "◌",
    Outcome.NOTHING_COMPARED: "○",
    Outcome.MALFORMED: "#",
    Outcome.INCOMPLETE: "◐",
    Outcome.NOT_FINITE: "?",
    Outcome.JOINTS_IGNORED: "¦",
    Outcome.TIMED_OUT: "◷",
    Outcome.FAILED: "✗",
    Outcome.MISSING: "∅",
}
GONE = (Outcome.MISSING, Outcome.NOTHING_COMPARED, Outcome.TIMED_OUT, Outcome.INCOMPLETE)
DIGITS_A_SHADE = 2
DIGIT_WORDS = ("0–2", "2–4", "4–6", "6–8", "8–10", "10–12", "12+")
"""Digits of each shade"""
MOST_DIGITS = 16.0
"""Of double precision"""
FEW_COLUMNS = 12
"""Columns up to which a laptop's window shows all kinds of engines side by side"""


class Verdict(NamedTuple):
    """Verdict at the top of a report."""

    good: bool
    headline: str
    sentences: tuple[str, ...]
    failures: tuple[RunCell, ...]


def summary_verdict(summary: Summary) -> Verdict:
    """Verdict of a summary, from the numbers of the metrics table alone."""
    passed, failed = summary.with_outcome(Outcome.PASS), [c for c in summary.all if not c.outcome.ok]
    holes, unchecked = unchecked_scenes(summary)
    independent = [c for c in passed if summary.external(c.engine)]
    rated = [(c, r) for c in summary.all if (r := c.worst_ratio)]
    others = {
        "unsupported": len(summary.with_outcome(Outcome.UNSUPPORTED)),
        "too coarse to be judged": len(summary.with_outcome(Outcome.TOO_COARSE)),
        "reported without a criterion": len(summary.with_outcome(Outcome.REPORTED)),
        "not run": len(summary.scenes) * len(summary.engines) - len(summary.all),
    }
    headline, *sentences = paragraphs(
        "comparison/verdict.txt.j2",
        summary=summary,
        holes=holes,
        unchecked=unchecked,
        judged=[c for c in summary.all if c.outcome.judged],
        passed=passed,
        failed=failed,
        others=others,
        independent=independent,
        shared=sum(summary.shares_equations(c) for c in independent),
        worst=max(rated, key=lambda pair: pair[1].ratio or 0.0, default=None),
    )
    failures = (*summary.unsolved, *failed)
    gaps = failures or holes or unchecked or summary.idle
    return Verdict(summary.finished and bool(passed) and not gaps, headline, tuple(sentences), failures)


def unchecked_scenes(summary: Summary) -> tuple[list[str], list[str]]:
    """Solved scenes on which no engine was compared, and others that passed in no independent engine.

    None of an unfinished run, whose engines may not have run yet. Where the record does not tell which engines are
    independent, the second are those of which the table says so.
    """
    holes, unchecked = [], []
    unsolved = {c.scene for c in summary.unsolved}
    for name in (s.name for s in summary.scenes if summary.finished and s.name not in unsolved):
        cells = summary.of_scene(name)
        known = summary.outside_known or any(not c.outcome.ok for c in summary.of_several(name))
        if cells and all(c.outcome is Outcome.UNSUPPORTED for c in cells):
            holes.append(name)
        elif cells and known and not any(c.outcome is Outcome.PASS and summary.external(c.engine) for c in cells):
            unchecked.append(name)
    return holes, unchecked


def why(cell: RunCell) -> str:
    """Reason of a failed run from its rows: as stored, or the numbers."""
    row = next((r for r in cell.rows if r.outcome is cell.outcome), None)
    if not cell.reason and row and cell.outcome is Outcome.INCONSISTENT and row.ratio is not None:
        return f"{row.name}: normalised error {significant(row.ratio)}"
    if not cell.reason and row and cell.outcome is Outcome.EXCEEDS_BOUND and row.bound is not None:
        return f"{row.name}: {significant(row.largest)} {row.unit_words}, bound {significant(row.bound)}"
    return cell.reason or cell.outcome.advice


def kind(outcome: Outcome) -> str:
    """Class of an outcome's colour."""
    if outcome is Outcome.PASS:
        return "pass"
    return "aside" if outcome.ok else "gone" if outcome in GONE else "fail"


@dataclass(frozen=True)
class EngineGroup:
    """Columns of one kind of engine."""

    key: str
    """Name in ids and classes"""
    heading: str
    engines: tuple[str, ...]
    passed: int
    compared: int
    """Comparisons that passed or failed"""
    unfolded: bool = True
    """Whether the columns are shown at first"""


def engine_groups(summary: Summary) -> list[EngineGroup]:
    """Engines by kind, independent physics first; one group where the record does not tell the kinds apart.

    Many columns of engines on barchain's equations are folded at first, unless one of them failed.
    """
    outside = tuple(e for e in summary.engines if summary.external(e))
    own = tuple(e for e in summary.engines if not summary.external(e))
    kinds = [("independent", KINDS[INDEPENDENT], outside), ("own", KINDS[OWN_EQUATIONS], own)]
    found = []
    for key, heading, engines in kinds if summary.outside_known else [("engines", "Engines", summary.engines)]:
        judged = [c for c in summary.all if c.engine in engines and c.outcome.judged]
        passed = sum(c.outcome.ok for c in judged)
        many = key == "own" and bool(outside) and len(summary.engines) > FEW_COLUMNS
        found.append(EngineGroup(key, heading, engines, passed, len(judged), passed < len(judged) or not many))
    return [g for g in found if g.engines or not summary.outside_known]


def digits(cell: RunCell, scene: SceneRecord) -> float | None:
    """Digits of accuracy of a comparison that may stand: of the attitude in rad, of a track relative to its radius."""
    row = next(iter(cell.shown), None)
    size = {"attitude": 1.0, "com": scene.value("radius0_m")}.get(row.quantity) if row else None
    error = None if row is None else cell.shown_value(row)
    if not cell.outcome.ok or not size or error is None or not math.isfinite(error):
        return None
    return min(max(0.0, -math.log10(error / size)), MOST_DIGITS) if error > 0.0 else MOST_DIGITS


def shade(count: float) -> int:
    """Index of the shade of a number of digits."""
    return min(int(count / DIGITS_A_SHADE), len(DIGIT_WORDS) - 1)


def cell_text(cell: RunCell | None, predictability_limit: str = "") -> str:
    """Text of one cell: outcome, errors, detection limit, compared duration."""
    if cell is None:
        return "not run"
    errors = [f"{'CM ' * (r.quantity == 'com')}{significant(cell.shown_value(r))} {r.unit}" for r in cell.shown]
    limit = cell.detection_limit
    detects = [] if limit is None else [f"detects {significant(limit)}"]
    return "; ".join(filter(None, [cell.word, *errors, *detects, predictability_limit]))


WIDTH, ROW, HEADING, TOP, BOTTOM = 400.0, 16.0, 22.0, 6.0, 34.0
LEFT, RIGHT = 142.0, 62.0
"""Room for the names of engines, and for the counts"""
MOST_TICKS = 5
PENS = {
    "independent": Pen(COLOURS["s2"], "o", hollow=True),
    "own": Pen(COLOURS["s1"], "s", hollow=True),
    "engines": Pen(COLOURS["s2"], "o", hollow=True),
}
FAILED = Pen(COLOURS["s8"], "X", hollow=True)
TITLE = "Normalised error of every comparison"
NOTE = (
    "One mark for each scene, and the number of comparisons that passed. Left of the line at 1, the error estimates "
    "explain the difference."
)


def agreement_panel(summary: Summary, groups: Sequence[EngineGroup]) -> Panel | None:
    """Chart of all normalised errors, a line for each engine under the heading of its kind; None without any."""
    judged = {
        e: [c for c in summary.all if c.engine == e and c.outcome.judged] for group in groups for e in group.engines
    }
    errors = {
        (e, ok): [r.ratio for c in cells if c.outcome.ok is ok and (r := c.worst_ratio) and r.ratio]
        for e, cells in judged.items()
        for ok in (True, False)
    }
    marks = {key: np.array(ratios, float) for key, ratios in errors.items()}
    span = decade_range([*marks.values(), np.array([1.0])])
    if span is None or not any((np.isfinite(m) & (m > 0.0)).any() for m in marks.values()):
        return None
    heading = HEADING if len(groups) > 1 else 0.0
    height = len(groups) * heading + len(judged) * ROW
    chart = Chart(
        Scale(span.low, max(span.high, 10.0), LEFT, WIDTH - RIGHT, log=True),
        Scale(0.0, height, TOP, TOP + height),
        (WIDTH, TOP + height + BOTTOM),
    )
    first, last = round(np.log10(chart.x.low)), round(np.log10(chart.x.high))
    step = max(1, int(np.ceil((last - first) / MOST_TICKS)))
    ticks = (*range(0, first - 1, -step), *range(step, last + 1, step))
    chart.ticks_across([(10.0**k, power_of_ten(k) if k else "1") for k in ticks], "normalised error")
    at, scores = 0.0, {e: f"{sum(c.outcome.ok for c in own)} of {len(own)}" for e, own in judged.items() if own}
    for group in groups:
        if heading:
            chart.text((2.0, TOP + at + 0.5 * heading + 4.0), group.heading, colour="ink", more="font-weight:bold")
        at += heading
        chart.line(np.ones(2), np.array([at, at + len(group.engines) * ROW]), COLOURS["muted"], 0.9)
        for engine in group.engines:
            line = at + 0.5 * ROW
            chart.across_at(line, COLOURS["grid"])
            for ok, pen in ((True, PENS[group.key]), (False, FAILED)):
                found = marks[engine, ok]
                chart.marks(found, np.full(len(found), line), pen.marker, pen.colour, 5.4, hollow=True)
            chart.text((2.0, TOP + line + 4.0), engine, colour="ink")
            chart.text((WIDTH - 2.0, TOP + line + 4.0), scores.get(engine, ""), "end")
            at += ROW
    legend = (Legend("failed", FAILED),) if any(len(m) for (_, ok), m in marks.items() if not ok) else ()
    engines = "; ".join(f"{engine}: {score} passed" for engine, score in scores.items())
    label = f"{TITLE}, a line for each engine; horizontal axis: normalised error. {engines}"
    return Panel(TITLE, chart.svg(label), NOTE, legend)
