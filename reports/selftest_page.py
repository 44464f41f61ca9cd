"""From a folder with a self-test to its page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.palette import variables
from reports.record import mapping
from reports.render import templates
from reports.selftest_tables import FOLDER, Fate
from reports.selftest_view import view_selftest

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
    shown = {
        "selftest": view,
        "Fate": Fate,
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "environment": mapping(view.record.get("environment")),
        "packages": dict(sorted(mapping(view.record.get("packages")).items())),
    }
    made = templates()
    text = made.get_template("selftest.md.j2").render(shown)
    (folder / FOLDER / "selftest.md").write_text(text.strip() + "\n", encoding="utf-8")
    page = folder / "selftest.html"
    page.write_text(made.get_template("selftest_page.html.j2").render(shown), encoding="utf-8")
    return page
