"""From a folder with an effect budget to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.effects.view import view_effects
from reports.page import write_chapter, write_text
from reports.tables.effects import FOLDER

if TYPE_CHECKING:
    from pathlib import Path


def render_effects(folder: Path) -> Path:
    """Write the chapter, from stored tables alone, and return its page.

    A folder that holds a comparison gets the chapter into its report; any other a page ``effects.html``. The same
    as text is ``effects/effects.md``.

    Raises
    ------
    FileNotFoundError
        If the folder holds no effect budget.
    """
    view = view_effects(folder)
    if view is None:
        raise FileNotFoundError(f"{folder}: no {FOLDER}/effects.csv there; give a folder that effects wrote")
    write_text(folder / FOLDER / "effects.md", "effects", {"effects": view})
    return write_chapter(folder, "effects", {"effects": view}, view.record)
