"""From a folder with a cost study to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.cost.view import view_cost
from reports.page import write_chapter, write_text
from reports.tables.cost import FOLDER

if TYPE_CHECKING:
    from pathlib import Path


def render_cost(folder: Path) -> tuple[Path, Path]:
    """Write the chapter and the table of speed ratios, from stored tables alone.

    A folder that holds a comparison gets the chapter into its report; any other a page ``cost.html``.

    Returns
    -------
    tuple of Path
        The page and ``cost/ratios.md``.

    Raises
    ------
    FileNotFoundError
        If the folder holds no cost study.
    """
    view = view_cost(folder)
    if view is None:
        raise FileNotFoundError(f"{folder}: no {FOLDER}/points.csv there; give a folder that cost wrote")
    ratios = write_text(folder / FOLDER / "ratios.md", "cost", {"cost": view})
    return write_chapter(folder, "cost", {"cost": view}, view.record), ratios
