"""From a folder with a stability study to its page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.pages import write_page, write_text
from reports.stability_tables import FOLDER
from reports.stability_view import view_stability

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
