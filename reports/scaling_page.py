"""From a folder with a scaling study to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.palette import variables
from reports.record import mapping
from reports.render import render, templates
from reports.scaling_tables import FOLDER
from reports.scaling_view import view_scaling

if TYPE_CHECKING:
    from pathlib import Path

    from reports.scaling_view import ScalingView


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
    text = templates().get_template("scaling.md.j2").render(scaling=view)
    (folder / FOLDER / "scaling.md").write_text(text.strip() + "\n", encoding="utf-8")
    if (folder / "metrics.csv").is_file() and (folder / "run.json").is_file():
        return render(folder)[0]
    return alone(folder / "scaling.html", view)


def alone(page: Path, view: ScalingView) -> Path:
    """Write the chapter as a page of its own."""
    record = view.record
    shown = {
        "scaling": view,
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "environment": mapping(record.get("environment")),
        "packages": dict(sorted(mapping(record.get("packages")).items())),
    }
    page.write_text(templates().get_template("scaling_page.html.j2").render(shown), encoding="utf-8")
    return page
