"""From a folder with a round-off study to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.palette import variables
from reports.record import mapping
from reports.render import render, templates
from reports.roundoff_tables import FOLDER
from reports.roundoff_view import view_roundoff

if TYPE_CHECKING:
    from pathlib import Path

    from reports.roundoff_view import RoundoffView


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
    text = templates().get_template("roundoff.md.j2").render(roundoff=view)
    (folder / FOLDER / "roundoff.md").write_text(text.strip() + "\n", encoding="utf-8")
    if (folder / "metrics.csv").is_file() and (folder / "run.json").is_file():
        return render(folder)[0]
    return alone(folder / "roundoff.html", view)


def alone(page: Path, view: RoundoffView) -> Path:
    """Write the chapter as a page of its own."""
    shown = {
        "roundoff": view,
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "environment": mapping(view.record.get("environment")),
        "packages": dict(sorted(mapping(view.record.get("packages")).items())),
    }
    page.write_text(templates().get_template("roundoff_page.html.j2").render(shown), encoding="utf-8")
    return page
