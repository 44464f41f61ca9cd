"""Chapter of a report: the tables of a study, and how they become a view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

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

    The templates are ``templates/<name>/chapter.html.j2`` and, where `text` is given, ``chapter.md.j2``. They see the
    chapter as ``chapter``, the view under the study's name, and the page's ``glossary``.
    """

    name: str
    """Name of the study, of its folder of tables, of its page, and id of its heading"""
    title: str
    """Heading, entry in the report's navigation, and title of the study's own page"""
    tables: tuple[str, ...]
    """Required files in the study's folder"""
    view: Callable[[Path], ChapterView]
    """Makes the view of a result folder that holds these files"""
    text: str = ""
    """Markdown file beside the tables; empty: none"""
    in_report: bool = True
    """Whether the report of a comparison in the same folder includes the chapter"""

    def is_in(self, folder: Path) -> bool:
        """Whether a result folder holds the study."""
        return not self.missing_from(folder)

    def missing_from(self, folder: Path) -> list[str]:
        """Required files that a result folder lacks, relative to it."""
        return [f"{self.name}/{table}" for table in self.tables if not (folder / self.name / table).is_file()]

    def view_of(self, folder: Path) -> ChapterView:
        """View of a result folder.

        Raises
        ------
        FileNotFoundError
            If the folder does not hold the study.
        """
        missing = self.missing_from(folder)
        if missing:
            raise FileNotFoundError(f"{folder}: no {missing[0]} there; give a folder that barchain {self.name} wrote")
        return self.view(folder)
