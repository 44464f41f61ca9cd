"""Rendering of a result folder: the chapters of all studies; each view is made once, and each page is written once."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, NamedTuple

from reports.chapters.comparison.report import write_report
from reports.page import fitting, surroundings, templates
from reports.results import comparison
from reports.results.comparison import read_results
from reports.results.studies import STUDIES, no_results
from reports.results.writing import write_atomically
from reports.text.glossary import Glossary

if TYPE_CHECKING:
    from pathlib import Path

    from reports.results.files import StudyFiles


def view_of(files: StudyFiles, folder: Path) -> Any:
    """View of a study's results: everything that its chapter shows, with the study's record.

    The template ``templates/<study>/chapter.html.j2`` sees it under the study's name, the study as ``chapter``, and the
    page's ``glossary``.

    Raises
    ------
    FileNotFoundError
        If the folder does not hold the study.
    DamagedResultsError
        If its rows and record are damaged, or don't fit together.
    """
    if not files.has_record(folder):
        wanted = f"give a folder that barchain {files.study} wrote"
        raise FileNotFoundError(f"{folder}: no results of {files.study} there; {wanted}")
    module, _, name = files.view.partition(":")
    made = getattr(importlib.import_module(f"reports.chapters.{module}"), name)
    return fitting(files.record_path(folder), lambda: made(folder))


class Rendered(NamedTuple):
    """View and files of one study."""

    page: Path
    """Report of the comparison that includes the chapter, or else the study's own page"""
    view: Any


def views_in(folder: Path, *, but: str = "", in_report: bool = True) -> dict[StudyFiles, Any]:
    """Views of the studies in a result folder, in the registry's order.

    Parameters
    ----------
    folder : Path
    but : str
        Study that is left out.
    in_report : bool
        Whether only those are wanted that a comparison's report includes.
    """
    wanted = (s for s in STUDIES if s.view and s.study != but and (s.in_report or not in_report))
    return {files: view_of(files, folder) for files in wanted if files.has_record(folder)}


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
    if name != "crossval":
        joins = any(s.study == name and s.in_report for s in STUDIES)
        if not (joins and comparison.FILES.has_record(folder)):
            return
        read_results(folder)
    views_in(folder, but=name)


def write_page(folder: Path, chapter: StudyFiles, view: Any) -> Path:
    """Write a study's own page, ``<study>.html``, and return it."""
    page, template = folder / chapter.pages[0], templates().get_template("study_page.html.j2")
    shown = {"chapter": chapter, chapter.study: view, "glossary": Glossary()} | surroundings(view.record, folder)
    write_atomically(page, fitting(chapter.record_path(folder), lambda: template.render(shown)))
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
    chapter = next(s for s in STUDIES if s.study == name)
    compared = chapter.in_report and comparison.FILES.has_record(folder)
    views = views_in(folder) if compared else {}
    view = views.get(chapter) or view_of(chapter, folder)
    return Rendered(write_report(folder, views)[0] if compared else write_page(folder, chapter, view), view)


def render_all(folder: Path) -> list[Path]:
    """Write every page of a folder, and return the pages and the report's summary.

    Raises
    ------
    FileNotFoundError
        If it holds neither a comparison nor a study.
    """
    views, compared = views_in(folder, in_report=False), comparison.FILES.has_record(folder)
    if not views and not compared:
        raise FileNotFoundError(no_results(folder))
    pages = [write_page(folder, c, view) for c, view in views.items() if not (compared and c.in_report)]
    report = write_report(folder, {c: v for c, v in views.items() if c.in_report}) if compared else ()
    return [*pages, *report]
