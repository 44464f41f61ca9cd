"""From a folder with a stability study to its page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.palette import variables
from reports.record import mapping
from reports.render import templates
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
    shown = {
        "stability": view,
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "environment": mapping(view.record.get("environment")),
        "packages": dict(sorted(mapping(view.record.get("packages")).items())),
    }
    made = templates()
    text = made.get_template("stability.md.j2").render(shown)
    (folder / FOLDER / "stability.md").write_text(text.strip() + "\n", encoding="utf-8")
    page = folder / "stability.html"
    page.write_text(made.get_template("stability_page.html.j2").render(shown), encoding="utf-8")
    return page
