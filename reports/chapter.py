"""A chapter of the report: where a study's tables are, and how a view is made of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path


class View(Protocol):
    """All that a chapter's templates show, in words, numbers and charts."""

    @property
    def record(self) -> Mapping[str, Any]:
        """Record of the study: its environment, its command."""


@dataclass(frozen=True)
class Chapter:
    """One study's chapter.

    Its templates are ``templates/<name>/chapter.html.j2`` and, where `text` is given, ``chapter.md.j2``. They see the
    view under the study's name.
    """

    name: str
    """Of the study, of its folder of tables, and of its page"""
    title: str
    """Of its own page"""
    tables: tuple[str, ...]
    """Files in the study's folder that have to be there"""
    view: Callable[[Path], View]
    """View of a result folder that has these files"""
    text: str = ""
    """Markdown file beside the tables; empty: none"""
    in_report: bool = True
    """Whether a comparison in the same folder takes the chapter into its report"""

    def is_in(self, folder: Path) -> bool:
        """Whether a result folder holds the study."""
        return all((folder / self.name / table).is_file() for table in self.tables)

    def view_of(self, folder: Path) -> View:
        """View of a result folder.

        Raises
        ------
        FileNotFoundError
            If the folder does not hold the study.
        """
        if not self.is_in(folder):
            missing = next(t for t in self.tables if not (folder / self.name / t).is_file())
            raise FileNotFoundError(
                f"{folder}: no {self.name}/{missing} there; give a folder that barchain {self.name} wrote"
            )
        return self.view(folder)
