"""Chapter of a report: the tables of a study, and how they become a view."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from reports.tables.reading import DamagedResultsError, brief, damaged, read_json
from reports.tables.schema import RECORD, SchemaVersionError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path


T = TypeVar("T")


def fitting(place: Path, shown: Callable[[], T]) -> T:
    """Contents of stored results whose files are sound each, and should fit together.

    Raises
    ------
    DamagedResultsError
        If they don't: a value that one of them names is missing in another, or can't be drawn.
    """
    try:
        return shown()
    except (DamagedResultsError, SchemaVersionError, OSError):
        raise
    except Exception as error:
        said = f"its tables and record don't fit together ({type(error).__name__}: {brief(error)})"
        raise damaged(place, said) from error


class ChapterView(Protocol):
    """Everything that a chapter's templates show: words, numbers and charts."""

    @property
    def record(self) -> Mapping[str, Any]:
        """Record of the study: its environment, its command."""


def says_complete(path: Path) -> bool:
    """Whether a record can be read and says that every result is there."""
    try:
        record = read_json(path)
    except (OSError, DamagedResultsError):
        return False
    return isinstance(record, dict) and record.get("complete") is True


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
        return not self.missing_from(folder) or says_complete(folder / self.name / RECORD)

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
