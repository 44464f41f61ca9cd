"""Chapters of all studies, in the order of the report: the tables of a study, and how they become a view."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from reports.chapters.campaign import view_campaign
from reports.chapters.cost import view_cost
from reports.chapters.effects import view_effects
from reports.chapters.ensemble import view_ensemble
from reports.chapters.releases import view_releases
from reports.chapters.roundoff.view import view_roundoff
from reports.chapters.scaling import view_scaling
from reports.chapters.selftest import view_selftest
from reports.chapters.stability import view_stability
from reports.page import fitting
from reports.tables.reading import DamagedResultsError, read_json
from reports.tables.schema import RECORD

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path


class ChapterView(Protocol):
    """Everything that a chapter's templates show: words, numbers and charts."""

    @property
    def record(self) -> Mapping[str, Any]:
        """Record of the study: its environment, its command."""


@dataclass(frozen=True)
class Chapter:
    """One study's chapter.

    Its template ``templates/<name>/chapter.html.j2`` sees the chapter as ``chapter``, the view under the study's name,
    and the page's ``glossary``.
    """

    name: str
    """Name of the study, of its folder of tables, of its page, and id of its heading"""
    title: str
    """Heading, entry in the report's navigation, and title of the study's own page"""
    tables: tuple[str, ...]
    """Required files in the study's folder"""
    view: Callable[[Path], ChapterView]
    """Makes the view of a result folder that holds these files"""
    command: str = ""
    """Command that writes the tables, if it is not called as the study is"""
    in_report: bool = True
    """Whether the report of a comparison in the same folder includes the chapter"""

    def is_in(self, folder: Path) -> bool:
        """Whether a result folder holds the study: its files, or a record that says that they are complete."""
        if not self.missing_from(folder):
            return True
        try:
            record = read_json(folder / self.name / RECORD)
        except (OSError, DamagedResultsError):
            return False
        return isinstance(record, dict) and record.get("complete") is True

    def missing_from(self, folder: Path) -> list[str]:
        """Required files that a result folder lacks, relative to it."""
        return [f"{self.name}/{table}" for table in self.tables if not os.path.lexists(folder / self.name / table)]

    def view_of(self, folder: Path) -> ChapterView:
        """View of a result folder.

        Raises
        ------
        FileNotFoundError
            If the folder does not hold the study.
        DamagedResultsError
            If its tables and record are damaged, or don't fit together.
        """
        missing = self.missing_from(folder)
        if missing:
            command = f"barchain {self.command or self.name}"
            raise FileNotFoundError(f"{folder}: no {missing[0]} there; give a folder that {command} wrote")
        return fitting(folder / self.name, lambda: self.view(folder))


CHAPTERS = (
    Chapter("cost", "Cost of accuracy", ("points.csv", RECORD), view_cost),
    Chapter("scaling", "Cost against the number of bars", ("points.csv", RECORD), view_scaling),
    Chapter("roundoff", "Round-off in absolute and relative coordinates", (RECORD,), view_roundoff),
    Chapter("effects", "Relevance of each effect", ("effects.csv", RECORD), view_effects),
    Chapter(
        "selftest",
        "Detection of inserted faults",
        ("selftest.csv", RECORD),
        view_selftest,
        in_report=False,
    ),
    Chapter(
        "campaign",
        "Random campaign",
        ("campaign.csv", "rates.csv", RECORD),
        view_campaign,
        command="selftest --random N",
        in_report=False,
    ),
    Chapter(
        "stability",
        "Numerical stability on hard scenes",
        ("outcomes.csv", "evidence.csv", RECORD),
        view_stability,
        in_report=False,
    ),
    Chapter(
        "releases",
        "Releases of an engine",
        ("releases.csv", RECORD),
        view_releases,
        in_report=False,
    ),
    Chapter("ensemble", "Ensemble of perturbed runs", ("quantiles.csv", RECORD), view_ensemble, in_report=False),
)
