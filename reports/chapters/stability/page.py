"""From a folder with a stability study to its page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.stability.view import view_stability
from reports.page import write_page, write_text
from reports.tables.stability import FOLDER

if TYPE_CHECKING:
    from pathlib import Path


def render_stability(folder: Path) -> Path:
    """Write ``stability.html`` and ``stability/stability.md``, from stored tables alone, and return the page.

    Raises
    ------
    FileNotFoundError
        If the folder holds no stability study.
    """
    view = view_stability(folder)
    if view is None:
        raise FileNotFoundError(f"{folder}: no {FOLDER}/outcomes.csv there; give a folder that stability wrote")
    shown = {"stability": view}
    write_text(folder / FOLDER / "stability.md", "stability", shown)
    return write_page(folder, "stability", shown, view.record)
