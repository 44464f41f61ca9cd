"""Rendering of a result folder: each view is made once, and each page is written once."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from reports.chapters.crossval.report import write_report
from reports.chapters.registry import CHAPTERS
from reports.page import write_page
from reports.tables.crossval import METRICS, read_results
from reports.tables.schema import RECORD

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.chapter import Chapter, ChapterView


COMPARISON = "crossval"


class Rendered(NamedTuple):
    """View and files of one study."""

    page: Path
    """Report of the comparison that includes the chapter, or else the study's own page"""
    view: ChapterView


def holds_comparison(folder: Path) -> bool:
    """Whether a result folder holds a comparison."""
    return all(os.path.lexists(folder / name) for name in (METRICS, RECORD))


def views_in(folder: Path) -> dict[Chapter, ChapterView]:
    """Views of all studies that a result folder holds, in the registry's order."""
    return {chapter: chapter.view_of(folder) for chapter in CHAPTERS if chapter.is_in(folder)}


def reported_in(folder: Path) -> dict[Chapter, ChapterView]:
    """Views of the studies in a result folder that a comparison's report includes."""
    return {chapter: chapter.view_of(folder) for chapter in CHAPTERS if chapter.in_report and chapter.is_in(folder)}


def reported(views: Mapping[Chapter, ChapterView]) -> dict[Chapter, ChapterView]:
    """Views that a comparison's report includes."""
    return {chapter: view for chapter, view in views.items() if chapter.in_report}


def check_others(name: str, folder: Path) -> None:
    """Read all that the page of a comparison or a study will include besides its own results, before it is run.

    Parameters
    ----------
    name : str
        ``crossval``, or name of a study.
    folder : Path
        Result folder, which may be missing.

    Raises
    ------
    DamagedResultsError, SchemaVersionError
        If other results in the folder could not be rendered.
    """
    compares = name == COMPARISON
    if not compares:
        if not (holds_comparison(folder) and any(c.name == name and c.in_report for c in CHAPTERS)):
            return
        read_results(folder)
    for chapter in CHAPTERS:
        if chapter.in_report and chapter.name != name and chapter.is_in(folder):
            chapter.view_of(folder)


def render(folder: Path) -> tuple[Path, Path]:
    """Write the report of a comparison, with the chapters of studies in its folder, from stored tables alone.

    Returns
    -------
    tuple of Path
        The HTML file and the summary.

    Raises
    ------
    FileNotFoundError
        If the folder holds no comparison.
    """
    return write_report(folder, reported_in(folder))


def render_study(name: str, folder: Path) -> Rendered:
    """Write a study's page, or the comparison's report that includes its chapter.

    Raises
    ------
    FileNotFoundError
        If the folder does not hold the study.
    """
    chapter = next(c for c in CHAPTERS if c.name == name)
    compared = chapter.in_report and holds_comparison(folder)
    views = reported_in(folder) if compared else {}
    view = views.get(chapter) or chapter.view_of(folder)
    page = write_report(folder, views)[0] if compared else write_page(folder, chapter, view)
    return Rendered(page, view)


def render_all(folder: Path) -> list[Path]:
    """Write every page of a folder, and return the pages and the report's summary.

    Raises
    ------
    FileNotFoundError
        If it holds neither a comparison nor a study.
    """
    views, compared = views_in(folder), holds_comparison(folder)
    if not views and not any(os.path.lexists(folder / name) for name in (METRICS, RECORD)):
        raise FileNotFoundError(nothing_known(folder))
    own = [c for c in views if not (compared and c.in_report)]
    pages = [write_page(folder, chapter, views[chapter]) for chapter in own]
    return pages if own and not compared else [*pages, *write_report(folder, reported(views))]


def nothing_known(folder: Path) -> str:
    """Message on a folder without results: what was looked for there."""
    sought = ", ".join(chapter.name for chapter in CHAPTERS)
    return f"{folder}: no {METRICS} of a comparison there, and no tables of a study ({sought})"
