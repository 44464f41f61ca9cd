"""The report of a comparison: matrix, scenes, and the chapters of studies in the same folder."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING, Any

from reports.chapter import fitting
from reports.chapters.crossval.agreement import agreement_panel
from reports.chapters.crossval.external_coverage import coverage_words
from reports.chapters.crossval.facts import facts, judged_by
from reports.chapters.crossval.matrix import DIGIT_WORDS, cell_text, digits, engine_groups, shade
from reports.chapters.crossval.scene_view import view_scene
from reports.chapters.crossval.summary import SHORT_OF_THE_RUN, WORDS, QuantityRow, RunCell, Summary, summarise
from reports.chapters.crossval.verdict import failure_words, summary_verdict
from reports.page import surroundings, templates
from reports.plotting.palette import engine_pen
from reports.tables.crossval import PARTED_RAD, Results, read_results
from reports.tables.outcome import Outcome
from reports.tables.schema import RECORD
from reports.tables.writing import write_atomically
from reports.text.glossary import Glossary
from reports.text.mathematics import written, written_row
from reports.text.numerals import number, unpadded
from reports.text.record import mapping, rows
from reports.text.words import run_anchor
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from jinja2 import Environment

    from reports.chapter import Chapter, ChapterView

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

PAPER = "paper"
"""Tag of the paper's scenes, which its misprints concern"""


def write_report(folder: Path, chapters: Mapping[Chapter, ChapterView]) -> tuple[Path, Path]:
    """Write ``index.html`` and ``summary.md`` into a result folder, from its stored tables alone.

    Parameters
    ----------
    folder : Path
        As described in :mod:`reports.tables.crossval`.
    chapters : mapping of Chapter to ChapterView
        Chapters of studies that the report includes, in this order.

    Returns
    -------
    tuple of Path
        The HTML file and the summary.

    Raises
    ------
    FileNotFoundError
        If the folder holds no ``metrics.csv`` or no ``record.json``.
    """
    results = read_results(folder)
    page, text = folder / "index.html", folder / "summary.md"
    html, markdown = fitting(folder / RECORD, lambda: rendered(results, chapters))
    write_atomically(page, html)
    write_atomically(text, markdown)
    return page, text


def rendered(results: Results, chapters: Mapping[Chapter, ChapterView]) -> tuple[str, str]:
    """HTML and Markdown of a comparison's report."""
    summary = summarise(results)
    shared = (
        context(results, summary)
        | {"chapters": list(chapters), "parted_rad": PARTED_RAD}
        | {c.name: v for c, v in chapters.items()}
    )
    groups = engine_groups(summary)
    pictures = {
        "views": [view_scene(results, summary, s) for s in summary.scenes],
        "groups": groups,
        "agreement": agreement_panel(summary, groups),
    }
    environment = report_templates()
    html, markdown = (environment.get_template(f"crossval/{name}.j2") for name in ("report.html", "summary.md"))
    return html.render(shared | pictures, glossary=Glossary()), markdown.render(shared, glossary=Glossary())


def report_templates() -> Environment:
    """Jinja environment with the filters of the cross-validation's chapter."""
    made = templates()
    made.filters |= {"cell_text": cell_text, "digits": digits, "facts": facts, "shade": shade, "why": failure_words}
    return made


def context(results: Results, summary: Summary) -> dict[str, Any]:
    """Names that both templates see."""
    record = results.record
    return surroundings(record) | {
        "summary": summary,
        "verdict": summary_verdict(summary),
        "judges": Counter(words for scene in summary.scenes if (words := judged_by(scene))),
        "digit_words": DIGIT_WORDS,
        "hint": str(record.get("verdict_hint") or ""),
        "record": {k: str(record.get(k) or "") for k in ("barchain", "created", "command")},
        "seconds": number(record.get("seconds")),
        "engines": {e: mapping(mapping(record.get("engines")).get(e)) for e in summary.engines},
        "runs": in_order(rows(record.get("runs"))),
        "has_paper_scenes": any(PAPER in scene.tags for scene in summary.scenes),
        "misprints": [written_row(r) for r in rows(record.get("misprints"))],
        "tolerances": [written_row(r) for r in rows(record.get("tolerances"))],
        "limitations": [written(str(t)) for t in record.get("limitations") or []],
        "Outcome": Outcome,
        "words": WORDS,
        "symbols": SYMBOLS,
        "kind": kind,
        "mapping": mapping,
        "engine_pen": engine_pen,
        "orbits": orbits,
        "figures": figures,
        "metric_heads": METRIC_HEADS,
        "run_anchor": run_anchor,
        "settings": compared_settings(summary),
        "coverage_words": coverage_words,
    }


def compared_settings(summary: Summary) -> dict[str, str]:
    """Settings of each engine's compared runs, with the number of scenes where they differ."""
    found: dict[str, Counter[str]] = defaultdict(Counter)
    for cell in summary.cells.values():
        if cell.setting:
            found[cell.engine][unpadded(cell.setting)] += 1
    return {engine: setting_words(counted) for engine, counted in found.items()}


def setting_words(counted: Counter[str]) -> str:
    """One setting, or several with their numbers of scenes."""
    if len(counted) == 1:
        return next(iter(counted))
    return ", ".join(f"{setting} ({plural(count, 'scene')})" for setting, count in counted.most_common())


RUN_KEYS = ("scene", "engine", "role", "setting")


def in_order(runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Runs with every key that a table shows, in an order independent of their time of completion."""
    whole = [{**dict.fromkeys((*RUN_KEYS, "outcome"), ""), **r} for r in runs]
    return sorted(whole, key=lambda r: [str(r[k]) for k in RUN_KEYS])


def kind(outcome: Outcome) -> str:
    """Class of an outcome's colour."""
    if outcome is Outcome.PASS:
        return "pass"
    if outcome in (Outcome.REPORTED, Outcome.UNSUPPORTED, Outcome.ROUNDOFF_LIMITED, Outcome.TOO_COARSE):
        return "aside"
    if outcome in (Outcome.MISSING, Outcome.NOTHING_COMPARED, Outcome.TIMED_OUT, Outcome.INCOMPLETE):
        return "gone"
    return "fail"


METRIC_HEADS = (
    "Largest", "First orbit", "RMS", "Final", "Bound", "Normalised error", "Detection limit", "Predictability limit, s"
)  # fmt: skip
"""Heads of the numbers in the table of metrics"""


def figures(row: QuantityRow) -> tuple[float | None, ...]:
    """Numbers of a quantity, in the order of the heads."""
    limit_s = None if row.ratio is None else row.limit_s
    return (row.largest, row.first_orbit, row.rms, row.final, row.bound, row.ratio, row.detection_limit, limit_s)


def orbits(summary: Summary, cell: RunCell) -> str:
    """Part of the run that was compared point by point, and its continuation in restarts; empty for the whole run."""
    scene = next((s for s in summary.scenes if s.name == cell.scene), None)
    if scene is None:
        return ""
    if cell.limit_s is None:
        return "to the end" if cell.shows_first_orbit else ""
    until = f"to {cell.limit_s / scene.period_s:.2f} orbits" if scene.in_orbits else f"to {cell.limit_s:.4g} s"
    if cell.judged_share is None:
        return until
    whole = cell.judged_share >= SHORT_OF_THE_RUN
    return f"{until}, then restarted" if whole else f"{until}, with restarts {cell.judged_share:.0%}"
