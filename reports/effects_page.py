"""From a folder with an effect budget to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.effects_tables import FOLDER
from reports.effects_view import view_effects
from reports.palette import variables
from reports.record import mapping
from reports.render import render, templates

if TYPE_CHECKING:
    from pathlib import Path

    from reports.effects_view import EffectsView


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
    text = templates().get_template("effects.md.j2").render(effects=view)
    (folder / FOLDER / "effects.md").write_text(text.strip() + "\n", encoding="utf-8")
    if (folder / "metrics.csv").is_file() and (folder / "run.json").is_file():
        return render(folder)[0]
    return alone(folder / "effects.html", view)


def alone(page: Path, view: EffectsView) -> Path:
    """Write the chapter as a page of its own."""
    record = view.record
    shown = {
        "effects": view,
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "environment": mapping(record.get("environment")),
        "packages": dict(sorted(mapping(record.get("packages")).items())),
    }
    page.write_text(templates().get_template("effects_page.html.j2").render(shown), encoding="utf-8")
    return page
