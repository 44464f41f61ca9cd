"""From a result folder to its pages: each view is made once, and each page is written once."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from reports.chapters.crossval.report import write_report
from reports.chapters.registry import CHAPTERS
from reports.page import write_page, write_text

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.chapter import Chapter, View


class Rendered(NamedTuple):
    """Files of one study."""

    page: Path
    """The comparison's report, where the chapter is in it, or the study's own page"""
    text: Path | None
    """Markdown; None of a study without"""


def holds_comparison(folder: Path) -> bool:
    """Whether a result folder holds a comparison."""
    return (folder / "metrics.csv").is_file() and (folder / "run.json").is_file()


def views_in(folder: Path) -> dict[str, View]:
    """Views of all studies that a result folder holds, by their names."""
    return {chapter.name: chapter.view_of(folder) for chapter in CHAPTERS if chapter.is_in(folder)}


def reported(views: Mapping[str, View]) -> dict[str, View]:
    """Those of some views that a comparison's report takes in."""
    return {chapter.name: views[chapter.name] for chapter in CHAPTERS if chapter.in_report and chapter.name in views}


def render(folder: Path) -> tuple[Path, Path]:
    """Write the report of a comparison, with the chapters of studies in its folder, from stored tables alone.

    Returns
    -------
    tuple of Path
        The HTML file and the Markdown file.

    Raises
    ------
    FileNotFoundError
        If the folder holds no comparison.
    """
    return write_report(folder, reported(views_in(folder)))


def render_study(name: str, folder: Path) -> Rendered:
    """Write a study's text, and its page or the comparison's report that its chapter is in.

    Raises
    ------
    FileNotFoundError
        If the folder does not hold the study.
    """
    chapter = next(c for c in CHAPTERS if c.name == name)
    view = chapter.view_of(folder)
    text = write_text(folder, chapter, view) if chapter.text else None
    if chapter.in_report and holds_comparison(folder):
        return Rendered(render(folder)[0], text)
    return Rendered(write_page(folder, chapter, view), text)


def render_all(folder: Path) -> list[Path]:
    """Write all that a folder holds, and return the pages and texts.

    Raises
    ------
    FileNotFoundError
        If it holds neither a comparison nor a study.
    """
    views, compared = views_in(folder), holds_comparison(folder)
    own = [c for c in CHAPTERS if c.name in views and not (compared and c.in_report)]
    pages = [path for c in CHAPTERS if c.name in views for path in written(folder, c, views, page=c in own)]
    return pages if own and not compared else [*pages, *write_report(folder, reported(views))]


def written(folder: Path, chapter: Chapter, views: Mapping[str, View], *, page: bool) -> list[Path]:
    """Write a study's text and, where asked for, its own page; returns the page."""
    view = views[chapter.name]
    if chapter.text:
        write_text(folder, chapter, view)
    return [write_page(folder, chapter, view)] if page else []
