"""From a folder with a scaling study to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.scaling.view import view_scaling
from reports.page import write_chapter, write_text
from reports.tables.scaling import FOLDER

if TYPE_CHECKING:
    from pathlib import Path


def render_scaling(folder: Path) -> Path:
    """Write the chapter, from stored tables alone, and return its page.

    A folder that holds a comparison gets the chapter into its report; any other a page ``scaling.html``. The same
    as text is ``scaling/scaling.md``.

    Raises
    ------
    FileNotFoundError
        If the folder holds no scaling study.
    """
    view = view_scaling(folder)
    if view is None:
        raise FileNotFoundError(f"{folder}: no {FOLDER}/points.csv there; give a folder that scaling wrote")
    write_text(folder / FOLDER / "scaling.md", "scaling", {"scaling": view})
    return write_chapter(folder, "scaling", {"scaling": view}, view.record)
