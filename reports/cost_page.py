"""From a folder with a cost study to its chapter: in the comparison's report, or as a page of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from markupsafe import Markup

from reports.cost_tables import FOLDER
from reports.cost_view import view_cost
from reports.palette import variables
from reports.record import mapping
from reports.render import render, templates

if TYPE_CHECKING:
    from pathlib import Path

    from reports.cost_view import CostView


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
    ratios = folder / FOLDER / "ratios.md"
    text = templates().get_template("cost.md.j2").render(cost=view)
    ratios.write_text(text.strip() + "\n", encoding="utf-8")
    if (folder / "metrics.csv").is_file() and (folder / "run.json").is_file():
        return render(folder)[0], ratios
    return alone(folder / "cost.html", view), ratios


def alone(page: Path, view: CostView) -> Path:
    """Write the chapter as a page of its own."""
    record = view.record
    shown = {
        "cost": view,
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "environment": mapping(record.get("environment")),
        "packages": dict(sorted(mapping(record.get("packages")).items())),
    }
    page.write_text(templates().get_template("cost_page.html.j2").render(shown), encoding="utf-8")
    return page
