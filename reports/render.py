"""Rendering of a result folder: the chapters of all studies; each view is made once, and each page is written once."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from reports.chapters.crossval.report import write_report
from reports.page import fitting, surroundings, templates
from reports.tables import cost, crossval, effects, ensemble, roundoff, scaling, stability
from reports.tables.crossval import read_results
from reports.tables.faults import campaign, selftest
from reports.tables.measured import no_results
from reports.tables.nights import releases
from reports.tables.writing import write_atomically
from reports.text.glossary import Glossary

if TYPE_CHECKING:
    from pathlib import Path

    from reports.tables.files import StudyFiles


@dataclass(frozen=True)
class Chapter:
    """One study's chapter.

    Its template ``templates/<name>/chapter.html.j2`` sees the chapter as ``chapter``, the view under the study's name,
    and the page's ``glossary``.
    """

    files: StudyFiles
    """Study whose rows it shows"""
    title: str
    """Heading, entry in the report's navigation, and title of the study's own page"""
    view: str
    """Function ``module:name`` that makes the view of a result folder; a view has the study's record"""
    in_report: bool = True
    """Whether the report of a comparison in the same folder includes the chapter"""
    command: str = ""
    """Command that writes the tables, if it is not called as the study is"""

    @property
    def name(self) -> str:
        """Name of the study, of its page, and id of its heading."""
        return self.files.study

    def view_of(self, folder: Path) -> Any:
        """View of a result folder: everything that the chapter's templates show.

        Raises
        ------
        FileNotFoundError
            If the folder does not hold the study.
        DamagedResultsError
            If its rows and record are damaged, or don't fit together.
        """
        if not self.files.has_record(folder):
            command = f"barchain {self.command or self.name}"
            raise FileNotFoundError(f"{folder}: no results of {self.name} there; give a folder that {command} wrote")
        module, _, name = self.view.partition(":")
        made = getattr(importlib.import_module(f"reports.chapters.{module}"), name)
        return fitting(self.files.record_path(folder), lambda: made(folder))


CHAPTERS = (
    Chapter(cost.FILES, "Cost of accuracy", "cost:view_cost"),
    Chapter(scaling.FILES, "Cost against the number of bars", "scaling:view_scaling"),
    Chapter(roundoff.FILES, "Round-off in absolute and relative coordinates", "roundoff.view:view_roundoff"),
    Chapter(effects.FILES, "Relevance of each effect", "effects:view_effects"),
    Chapter(selftest.FILES, "Detection of inserted faults", "selftest:view_selftest", in_report=False),
    Chapter(campaign.FILES, "Random campaign", "campaign:view_campaign", False, "selftest --random N"),
    Chapter(stability.FILES, "Numerical stability on hard scenes", "stability:view_stability", in_report=False),
    Chapter(releases.FILES, "Releases of an engine", "releases:view_releases", in_report=False),
    Chapter(ensemble.FILES, "Ensemble of perturbed runs", "ensemble:view_ensemble", in_report=False),
)


class Rendered(NamedTuple):
    """View and files of one study."""

    page: Path
    """Report of the comparison that includes the chapter, or else the study's own page"""
    view: Any


def views_in(folder: Path, *, but: str = "", in_report: bool = True) -> dict[Chapter, Any]:
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
    return {chapter: chapter.view_of(folder) for chapter in wanted if chapter.files.has_record(folder)}


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
        joins = any(c.name == name and c.in_report for c in CHAPTERS)
        if not (joins and crossval.FILES.has_record(folder)):
            return
        read_results(folder)
    views_in(folder, but=name)


def write_page(folder: Path, chapter: Chapter, view: Any) -> Path:
    """Write a study's own page, ``<study>.html``, and return it."""
    page, template = folder / f"{chapter.name}.html", templates().get_template("study_page.html.j2")
    shown = {"chapter": chapter, chapter.name: view, "glossary": Glossary()} | surroundings(view.record)
    write_atomically(page, fitting(chapter.files.record_path(folder), lambda: template.render(shown)))
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
    compared = chapter.in_report and crossval.FILES.has_record(folder)
    views = views_in(folder) if compared else {}
    view = views.get(chapter) or chapter.view_of(folder)
    return Rendered(write_report(folder, views)[0] if compared else write_page(folder, chapter, view), view)


def render_all(folder: Path) -> list[Path]:
    """Write every page of a folder, and return the pages and the report's summary.

    Raises
    ------
    FileNotFoundError
        If it holds neither a comparison nor a study.
    """
    views, compared = views_in(folder, in_report=False), crossval.FILES.has_record(folder)
    if not views and not compared:
        raise FileNotFoundError(no_results(folder))
    pages = [write_page(folder, c, view) for c, view in views.items() if not (compared and c.in_report)]
    report = write_report(folder, {c: v for c, v in views.items() if c.in_report}) if compared else ()
    return [*pages, *report]
