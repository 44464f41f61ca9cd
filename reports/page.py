"""Templates with their filters, and what every page shows around its subject."""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from reports.plotting.palette import variables
from reports.results.nights import PAGE, STATE
from reports.results.reading import DamagedResultsError, brief, damaged
from reports.results.schema import SchemaVersionError
from reports.text.numerals import (
    as_given,
    decade,
    each,
    given_markup,
    number,
    powers_in,
    ratio_text,
    significant,
    span,
    span_text,
    typeset,
    typographic,
)
from reports.text.record import is_complete
from reports.text.words import anchor, breakable, effect, engine_anchor, escape_text, shown, table_row
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

T = TypeVar("T")


def fitting(place: Path, shown: Callable[[], T]) -> T:
    """Contents of stored results whose files are sound each, and should fit together.

    Raises
    ------
    DamagedResultsError
        If they don't: a value that one of them names is missing in another, or can't be drawn.
    """
    try:
        return shown()
    except (DamagedResultsError, SchemaVersionError, OSError, MemoryError):
        raise
    except Exception as error:
        said = f"its tables and record don't fit together ({type(error).__name__}: {brief(error)})"
        raise damaged(place, said) from error


@cache
def templates() -> Environment:
    """Jinja environment of all templates: HTML is escaped, an undefined name is an error."""
    made = Environment(
        loader=PackageLoader("reports"),
        autoescape=select_autoescape(("html.j2",)),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
        finalize=shown,
    )
    made.filters |= {
        "typeset": lambda v, digits=3: typeset(number(v), digits),
        "significant": lambda v: significant(number(v)),
        "md": escape_text,
        "row": table_row,
        "number": number,
        "relative_effect": effect,
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
        "exponent": lambda v: f"{v:z.2f}".replace("-", "\N{MINUS SIGN}"),
        "complete": is_complete,
        "each": each,
        "plural": plural,
    }
    return made


def paragraphs(name: str, **shown: Any) -> list[str]:
    """Paragraphs of a template of plain text, each on one line."""
    parts = templates().get_template(name).render(shown).split("\n\n")
    return [" ".join(re.split("[ \n]+", part.strip(" \n"))) for part in parts if part.strip(" \n")]


def surroundings(record: Mapping[str, Any], folder: Path | None = None) -> dict[str, Any]:
    """Names of the parts around a page's subject: colours of both themes, and the environment of the run.

    A page of a result folder leads back to that of the night which the folder is a part of.
    """
    of_night = folder is not None and (folder.parent / STATE).is_file()
    return {
        "night": f"../{PAGE}" if of_night else "",
        "light": Markup(variables(0)),
        "dark": Markup(variables(1)),
        "created": str(record.get("created") or ""),
        "environment": record.get("environment") or {},
        "packages": dict(sorted((record.get("packages") or {}).items())),
    }
