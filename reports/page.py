"""From a study's view to its pages: a chapter of the comparison's report, or a page of its own, and text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from reports.plotting.palette import variables
from reports.render import render, templates
from reports.text.record import mapping

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


def frame(record: Mapping[str, Any]) -> dict[str, Any]:
    """What every page shows around its subject: colours of both themes, and what the run happened on."""
    return {
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "environment": mapping(record.get("environment")),
        "packages": dict(sorted(mapping(record.get("packages")).items())),
    }


def write_text(text: Path, name: str, shown: Mapping[str, Any]) -> Path:
    """Write a study as Markdown by the template of its name, and return the file."""
    text.write_text(templates().get_template(f"{name}.md.j2").render(shown).strip() + "\n", encoding="utf-8")
    return text


def write_page(folder: Path, name: str, shown: Mapping[str, Any], record: Mapping[str, Any]) -> Path:
    """Write a study's own page, ``<name>.html``, and return it."""
    page = folder / f"{name}.html"
    made = templates().get_template(f"{name}_page.html.j2").render(dict(shown) | frame(record))
    page.write_text(made, encoding="utf-8")
    return page


def write_chapter(folder: Path, name: str, shown: Mapping[str, Any], record: Mapping[str, Any]) -> Path:
    """Write a study as a chapter of the comparison's report where the folder holds one, else as a page of its own."""
    if (folder / "metrics.csv").is_file() and (folder / "run.json").is_file():
        return render(folder)[0]
    return write_page(folder, name, shown, record)
