"""From a folder with a round-off study to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.roundoff.view import view_roundoff
from reports.page import write_chapter, write_text
from reports.tables.roundoff import FOLDER

if TYPE_CHECKING:
    from pathlib import Path


def render_roundoff(folder: Path) -> Path:
    """Write the chapter, from stored tables alone, and return its page.

    A folder that holds a comparison gets the chapter into its report; any other a page ``roundoff.html``. The same
    as text is ``roundoff/roundoff.md``.

    Raises
    ------
    FileNotFoundError
        If the folder holds no round-off study.
    """
    view = view_roundoff(folder)
    if view is None:
        raise FileNotFoundError(f"{folder}: no {FOLDER}/record.json there; give a folder that roundoff wrote")
    write_text(folder / FOLDER / "roundoff.md", "roundoff", {"roundoff": view})
    return write_chapter(folder, "roundoff", {"roundoff": view}, view.record)
