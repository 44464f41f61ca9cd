"""The report of a comparison: matrix, scenes, and the chapters of studies in the same folder."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.chapters.comparison.charts import chart_groups
from reports.chapters.comparison.overview import (
    DIGIT_WORDS,
    SYMBOLS,
    agreement_panel,
    cell_text,
    digits,
    engine_groups,
    kind,
    shade,
    summary_verdict,
    why,
)
from reports.chapters.comparison.scene import SceneData, coverage_of, facts, judged_by
from reports.chapters.comparison.summary import SHORT_OF_THE_RUN, WORDS, RunCell, Summary, summarise
from reports.page import fitting, surroundings, templates
from reports.plotting.chain import DrawnMotion, Geometry, orbit_panels
from reports.plotting.palette import engine_pen
from reports.plotting.series import numbered
from reports.results.comparison import FILES, PARTED_RAD, read_results
from reports.results.outcome import Outcome
from reports.results.writing import write_atomically
from reports.text.glossary import Glossary
from reports.text.numerals import number, unpadded
from reports.text.words import run_anchor, written, written_row
from scenarios.channels import CHANNELS
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.plotting.panels import Panel
    from reports.results.files import StudyFiles, StudyTables
    from reports.text.record import SceneRecord

PAPER = "paper"
"""Tag of the paper's scenes, which its misprints concern"""
RUN_KEYS = ("scene", "engine", "role", "setting")
METRIC_HEADS = (
    "Largest", "First orbit", "RMS", "Final", "Bound", "Normalised error", "Detection limit", "Predictability limit, s"
)  # fmt: skip
"""Heads of the numbers in the table of metrics"""


def write_report(folder: Path, chapters: Mapping[StudyFiles, Any]) -> tuple[Path, Path]:
    """Write ``index.html`` and ``summary.md`` into a result folder, from its stored tables alone.

    Parameters
    ----------
    folder : Path
        As described in :mod:`reports.results.comparison`.
    chapters : mapping of StudyFiles to view
        Chapters of studies that the report includes, in this order.

    Returns
    -------
    tuple of Path
        The HTML file and the summary.

    Raises
    ------
    FileNotFoundError
        If the folder holds no comparison.
    """
    results = read_results(folder)
    page, text = folder / "index.html", folder / "summary.md"
    html, markdown = fitting(FILES.record_path(folder), lambda: rendered(results, chapters))
    write_atomically(page, html)
    write_atomically(text, markdown)
    return page, text


def rendered(results: StudyTables, chapters: Mapping[StudyFiles, Any]) -> tuple[str, str]:
    """HTML and Markdown of a comparison's report."""
    summary = summarise(results)
    shared = context(results, summary) | {"chapters": list(chapters)} | {c.study: v for c, v in chapters.items()}
    groups = engine_groups(summary)
    pictures = {
        "views": [scene_view(results, summary, s) for s in summary.scenes],
        "groups": groups,
        "agreement": agreement_panel(summary, groups),
    }
    environment = templates()
    environment.filters |= {"cell_text": cell_text, "digits": digits, "facts": facts, "shade": shade, "why": why}
    html, markdown = (environment.get_template(f"comparison/{name}.j2") for name in ("report.html", "summary.md"))
    return html.render(shared | pictures, glossary=Glossary()), markdown.render(shared, glossary=Glossary())


def scene_view(results: StudyTables, summary: Summary, scene: SceneRecord) -> dict[str, Any]:
    """Contents of a scene's section: its facts, drawings, charts and cells."""
    data = SceneData(results, summary, scene)
    return {
        "scene": scene,
        "anchor": data.id,
        "facts": facts(scene, of_track=summary.of_track(scene.name)),
        "orbits": orbits_of(data),
        "groups": chart_groups(data),
        "cells": summary.shown_in(scene.name),
        "coverage": coverage_of(summary, scene),
    }


def orbits_of(data: SceneData) -> list[Panel]:
    """Drawings of the chain along its orbit."""
    s, length, mass = data.scene, data.scene.values("length_m"), data.scene.values("mass_kg")
    angle = None if data.solution is None else numbered(data.solution, *CHANNELS["attitude"].columns)
    if data.solution is None or angle is None or not len(length) == len(mass) == angle.shape[1]:
        return []
    radius = 0.0 if s.text("gravity") == "none" else s.value("body_radius_m") or 0.0
    bodies = tuple(map(int, s.values("end_bodies")))
    share = tuple(s.values("com_share"))
    geometry = Geometry(np.array(length), np.array(mass), radius, s.period_s or 1.0, s.closed, bodies, share)
    t_s, com = data.solution["t_s"].to_numpy(float), data.solution[["com_x_m", "com_y_m"]].to_numpy(float)
    return orbit_panels(data.id, geometry, DrawnMotion(t_s, com, angle, data.solution_end_s))


def context(results: StudyTables, summary: Summary) -> dict[str, Any]:
    """Names that both templates see."""
    record = results.record
    return surroundings(record, results.folder) | {
        "summary": summary,
        "verdict": summary_verdict(summary),
        "judges": Counter(words for scene in summary.scenes if (words := judged_by(scene))),
        "parted_rad": PARTED_RAD,
        "digit_words": DIGIT_WORDS,
        "record": {k: str(record.get(k) or "") for k in ("barchain", "created", "command")},
        "seconds": number(record.get("seconds")),
        "engines": {e: (record.get("engines") or {}).get(e, {}) for e in summary.engines},
        "runs": sorted(record.get("runs") or (), key=lambda run: [run[k] for k in RUN_KEYS]),
        "has_paper_scenes": any(PAPER in scene.tags for scene in summary.scenes),
        "misprints": [written_row(r) for r in record.get("misprints") or ()],
        "tolerances": [written_row(r) for r in record.get("tolerances") or ()],
        "limitations": [written(str(t)) for t in record.get("limitations") or []],
        "Outcome": Outcome,
        "words": WORDS,
        "symbols": SYMBOLS,
        "kind": kind,
        "engine_pen": engine_pen,
        "compared_part": compared_part,
        "metric_heads": METRIC_HEADS,
        "run_anchor": run_anchor,
        "settings": compared_settings(summary),
        "coverage_of": coverage_of,
    }


def compared_settings(summary: Summary) -> dict[str, str]:
    """Settings of each engine's compared runs, with the number of scenes where they differ."""
    found: dict[str, Counter[str]] = {}
    for cell in summary.cells.values():
        if cell.setting:
            found.setdefault(cell.engine, Counter())[unpadded(cell.setting)] += 1
    return {
        engine: ", ".join(f"{s} ({plural(n, 'scene')})" if len(counted) > 1 else s for s, n in counted.most_common())
        for engine, counted in found.items()
    }


def compared_part(summary: Summary, cell: RunCell) -> str:
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
