"""From a folder with a self-test to its page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.selftest.view import view_selftest
from reports.page import write_page, write_text
from reports.tables.selftest import FOLDER, Fate

if TYPE_CHECKING:
    from pathlib import Path


def render_selftest(folder: Path) -> Path:
    """Write ``selftest.html`` and ``selftest/selftest.md``, from stored tables alone, and return the page.

    Raises
    ------
    FileNotFoundError
        If the folder holds no self-test.
    """
    view = view_selftest(folder)
    if view is None:
        raise FileNotFoundError(f"{folder}: no {FOLDER}/selftest.csv there; give a folder that selftest wrote")
    shown = {"selftest": view, "Fate": Fate}
    write_text(folder / FOLDER / "selftest.md", "selftest", shown)
    return write_page(folder, "selftest", shown, view.record)
