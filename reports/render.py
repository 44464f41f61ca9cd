"""Rendering of a result folder: each view is made once, and each page is written once."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from reports.chapters.crossval.report import write_report
from reports.chapters.registry import CHAPTERS
from reports.page import fitting, surroundings, templates
from reports.tables.crossval import METRICS, read_results
from reports.tables.schema import RECORD
from reports.tables.writing import write_atomically
from reports.text.glossary import Glossary

if TYPE_CHECKING:
    from pathlib import Path

    from reports.chapters.registry import Chapter, ChapterView

COMPARISON = "crossval"


class Rendered(NamedTuple):
    """View and files of one study."""

    page: Path
    """Report of the comparison that includes the chapter, or else the study's own page"""
    view: ChapterView


def holds_comparison(folder: Path) -> bool:
    """Whether a result folder holds a comparison."""
    return all(os.path.lexists(folder / name) for name in (METRICS, RECORD))


def views_in(folder: Path, *, but: str = "", in_report: bool = True) -> dict[Chapter, ChapterView]:
    """Views of the studies in a result folder, in the registry's order.

    Parameters
    ----------
    folder : Path
    but : str
        Study that is left out.
    in_report : bool
        Whether only those are wanted that a comparison's report includes.
    """
    wanted = (c for c in CHAPTERS if c.name != but and (c.in_report or not in_report))
    return {chapter: chapter.view_of(folder) for chapter in wanted if chapter.is_in(folder)}


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
    if name != COMPARISON:
        if not (holds_comparison(folder) and any(c.name == name and c.in_report for c in CHAPTERS)):
            return
        read_results(folder)
    views_in(folder, but=name)


def write_page(folder: Path, chapter: Chapter, view: ChapterView) -> Path:
    """Write a study's own page, ``<study>.html``, and return it."""
    page = folder / f"{chapter.name}.html"
    shown = {"chapter": chapter, chapter.name: view, "glossary": Glossary()} | surroundings(view.record)
    made = fitting(folder / chapter.name, lambda: templates().get_template("study_page.html.j2").render(shown))
    write_atomically(page, made)
    return page


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
    return write_report(folder, views_in(folder))


def render_study(name: str, folder: Path) -> Rendered:
    """Write a study's page, or the comparison's report that includes its chapter.

    Raises
    ------
    FileNotFoundError
        If the folder does not hold the study.
    """
    chapter = next(c for c in CHAPTERS if c.name == name)
    compared = chapter.in_report and holds_comparison(folder)
    views = views_in(folder) if compared else {}
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
    views, compared = views_in(folder, in_report=False), holds_comparison(folder)
    if not views and not any(os.path.lexists(folder / name) for name in (METRICS, RECORD)):
        sought = ", ".join(chapter.name for chapter in CHAPTERS)
        raise FileNotFoundError(f"{folder}: no {METRICS} of a comparison there, and no tables of a study ({sought})")
    own = [c for c in views if not (compared and c.in_report)]
    pages = [write_page(folder, chapter, views[chapter]) for chapter in own]
    return (
        pages
        if own and not compared
        else [*pages, *write_report(folder, {c: v for c, v in views.items() if c.in_report})]
    )
