"""From a result folder to its two reports."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape

from reports.chapters.cost.text import decade, ratio_text, span_text
from reports.chapters.cost.view import view_cost
from reports.chapters.crossval.external_coverage import carrier_words
from reports.chapters.crossval.scene_data import anchor
from reports.chapters.crossval.scene_view import view_scene
from reports.chapters.crossval.summary import SHORT_OF_THE_RUN, WORDS, Cell, Summary, summarise
from reports.chapters.crossval.verdict import failure_words, judge
from reports.chapters.effects.view import view_effects
from reports.chapters.roundoff.view import view_roundoff
from reports.chapters.scaling.view import view_scaling
from reports.plotting.palette import PAPER, engine_pen, variables
from reports.tables.crossval import Results, read_results
from reports.tables.outcome import Outcome
from reports.text.facts import facts
from reports.text.markdown import cell_text, escape_text, table_row
from reports.text.mathematics import effect, written, written_row
from reports.text.numerals import as_given, given_markup, number, powers_in, significant, span, typeset
from reports.text.record import mapping, rows

if TYPE_CHECKING:
    from pathlib import Path

SYMBOLS = {
    Outcome.PASS: "✓",
    Outcome.REPORTED: "·",
    Outcome.UNSUPPORTED: "–",
    Outcome.ROUNDOFF_LIMITED: "≈",
    Outcome.INCONSISTENT: "≠",
    Outcome.OUT_OF_BAND: "▲",
    Outcome.NOTHING_COMPARED: "○",
    Outcome.MALFORMED: "#",
    Outcome.INCOMPLETE: "◐",
    Outcome.NOT_FINITE: "?",
    Outcome.JOINTS_IGNORED: "¦",
    Outcome.TIMED_OUT: "◷",
    Outcome.FAILED: "✗",
    Outcome.MISSING: "∅",
}


def render(folder: Path) -> tuple[Path, Path]:
    """Write ``index.html`` and ``report.md`` into a result folder, from its stored tables alone.

    Parameters
    ----------
    folder : Path
        As described in :mod:`reports.tables.crossval`.

    Returns
    -------
    tuple of Path
        The HTML file and the Markdown file.

    Raises
    ------
    FileNotFoundError
        If the folder holds no ``metrics.csv`` or no ``run.json``.
    """
    results = read_results(folder)
    summary = summarise(results)
    chapters = {
        "cost": view_cost(folder),
        "scaling": view_scaling(folder),
        "roundoff": view_roundoff(folder),
        "effects": view_effects(folder),
    }
    shared = context(results, summary) | chapters
    views = [view_scene(results, summary, s) for s in summary.scenes]
    environment = templates()
    page, text = folder / "index.html", folder / "report.md"
    page.write_text(environment.get_template("index.html.j2").render(shared, views=views), encoding="utf-8")
    text.write_text(environment.get_template("report.md.j2").render(shared), encoding="utf-8")
    return page, text


def templates() -> Environment:
    """Templates with escaping on for HTML, and the filters they use."""
    made = Environment(
        loader=PackageLoader("reports"),
        autoescape=select_autoescape(("html.j2",)),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    made.filters |= {
        "typeset": lambda v, digits=3: typeset(number(v), digits),
        "significant": lambda v: significant(number(v)),
        "md": escape_text,
        "row": table_row,
        "number": number,
        "effect": effect,
        "effect_markup": effect_markup,
        "value": as_given,
        "nice": given_markup,
        "number_words": powers_in,
        "span": span,
        "cell_text": cell_text,
        "anchor": anchor,
        "breakable": breakable,
        "why": failure_words,
        "facts": facts,
        "span_text": span_text,
        "ratio_text": ratio_text,
        "decade": decade,
    }
    return made


def effect_markup(value: object) -> Markup:
    """Effect of a misprint for HTML."""
    found = effect(value)
    return escape(found) if isinstance(found, str) else typeset(found)


def context(results: Results, summary: Summary) -> dict[str, Any]:
    """Gather what both templates see."""
    record = results.record
    return {
        "summary": summary,
        "verdict": judge(summary),
        "hint": str(record.get("verdict_hint") or ""),
        "record": {k: str(record.get(k) or "") for k in ("barchain", "created", "command")},
        "seconds": number(record.get("seconds")),
        "environment": mapping(record.get("environment")),
        "packages": dict(sorted(mapping(record.get("packages")).items())),
        "engines": {e: mapping(mapping(record.get("engines")).get(e)) for e in summary.engines},
        "runs": in_order(rows(record.get("runs"))),
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
        "carrier_words": carrier_words,
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "paper": PAPER,
    }


RUN_KEYS = ("scene", "engine", "role", "setting")


def in_order(runs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the runs with every key that a table shows, in an order that does not tell when they came."""
    whole = [{**dict.fromkeys((*RUN_KEYS, "outcome"), ""), **r} for r in runs]
    return sorted(whole, key=lambda r: [str(r[k]) for k in RUN_KEYS])


def kind(outcome: Outcome) -> str:
    """Class of an outcome's colour."""
    if outcome is Outcome.PASS:
        return "pass"
    if outcome in (Outcome.REPORTED, Outcome.UNSUPPORTED, Outcome.ROUNDOFF_LIMITED):
        return "aside"
    if outcome in (Outcome.MISSING, Outcome.NOTHING_COMPARED, Outcome.TIMED_OUT, Outcome.INCOMPLETE):
        return "gone"
    return "fail"


def breakable(name: str) -> Markup:
    """Name that a narrow column breaks after a slash or an underscore rather than anywhere."""
    return Markup("").join(Markup("{}<wbr>").format(part) for part in re.findall(r"[^/_]*[/_]|[^/_]+", name))


def orbits(summary: Summary, cell: Cell) -> str:
    """What a cell's errors are of, in words; empty where it is the whole run."""
    scene = next((s for s in summary.scenes if s.name == cell.scene), None)
    if scene is None:
        return ""
    end_s = cell.horizon_s or cell.duration_s
    if cell.judged_share is not None and cell.judged_share < SHORT_OF_THE_RUN:
        return f"{cell.judged_share:.0%} of the run judged"
    if cell.shows_first_orbit and scene.closed and end_s:
        return f"first of {orbit_count(end_s / scene.period_s)} orbits"
    if cell.horizon_s is None:
        return ""
    then = "" if cell.judged_share is None else ", then restarted"
    if not scene.closed:
        return f"to {cell.horizon_s:.3g} s{then}"
    return f"to {cell.horizon_s / scene.period_s:.2f} orbits{then}"


def orbit_count(orbits: float) -> str:
    """``2.76``, but ``5`` for a whole number."""
    return f"{orbits:.2f}".removesuffix(".00")
