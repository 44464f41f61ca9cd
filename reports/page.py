"""Templates with their filters, and a study's own page."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape

from reports.chapter import fitting
from reports.plotting.palette import variables
from reports.tables.writing import write_atomically
from reports.text.glossary import Glossary
from reports.text.markdown import escape_text, table_row
from reports.text.mathematics import effect
from reports.text.numerals import as_given, given_markup, number, powers_in, significant, span, typeset, typographic
from reports.text.ratios import decade, ratio_text, span_text
from reports.text.record import mapping
from reports.text.visible import written
from reports.text.words import anchor, breakable, engine_anchor

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from reports.chapter import Chapter, ChapterView


def templates() -> Environment:
    """Jinja environment of all templates: HTML is escaped, an undefined name is an error."""
    made = Environment(
        loader=PackageLoader("reports"),
        autoescape=select_autoescape(("html.j2",)),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
        finalize=written,
    )
    made.filters |= {
        "typeset": lambda v, digits=3: typeset(number(v), digits),
        "significant": lambda v: significant(number(v)),
        "md": escape_text,
        "row": table_row,
        "number": number,
        "effect": effect,
        "effect_markup": effect_markup,
        "value": lambda v: typographic(as_given(v)) if number(v) is not None else as_given(v),
        "nice": given_markup,
        "typed": as_given,
        "number_words": powers_in,
        "span": span,
        "anchor": anchor,
        "engine_anchor": engine_anchor,
        "breakable": breakable,
        "span_text": span_text,
        "ratio_text": ratio_text,
        "decade": decade,
    }
    return made


def effect_markup(value: object) -> Markup:
    """Relative effect of a misprint, as HTML."""
    found = effect(value)
    return escape(found) if isinstance(found, str) else typeset(found)


def surroundings(record: Mapping[str, Any]) -> dict[str, Any]:
    """Names of the parts around a page's subject: colours of both themes, and the environment of the run."""
    return {
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "created": str(record.get("created") or ""),
        "environment": mapping(record.get("environment")),
        "packages": dict(sorted(mapping(record.get("packages")).items())),
    }


def write_page(folder: Path, chapter: Chapter, view: ChapterView) -> Path:
    """Write a study's own page, ``<study>.html``, and return it."""
    page = folder / f"{chapter.name}.html"
    shown = {"chapter": chapter, chapter.name: view, "glossary": Glossary()} | surroundings(view.record)
    made = fitting(folder / chapter.name, lambda: templates().get_template("study_page.html.j2").render(shown))
    write_atomically(page, made)
    return page
