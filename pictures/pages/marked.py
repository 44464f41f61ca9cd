"""Pages that are written by hand, but for tables between two comments."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from pictures.pages import interface_tables, judge_tables, mistake_lists, reference_tables
from pictures.paths import DOCS

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

TABLES: dict[str, Callable[[], str]] = {
    **interface_tables.TABLES,
    **judge_tables.TABLES,
    **mistake_lists.TABLES,
    **reference_tables.TABLES,
}
"""Tables by the name in their comments"""
PAGES = (
    "explanation/certified_solutions.md",
    "explanation/design/comparison.md",
    "explanation/theory/misprints.md",
    "explanation/verdicts.md",
    "reference/engine_interface.md",
    "reference/glossary.md",
    "reference/known_mistakes.md",
    "reference/outcomes.md",
    "reference/result_tables.md",
    "reference/scene_keys.md",
)
"""Pages with such tables, below the documentation's folder"""
START = re.compile(r"<!-- (?P<name>[\w-]+): generated -->")


def marked_pages() -> dict[Path, str]:
    """Text of each page with all its tables written anew."""
    return {DOCS / page: with_tables((DOCS / page).read_text(encoding="utf-8")) for page in PAGES}


def with_tables(text: str) -> str:
    """Text with each table written anew.

    Raises
    ------
    KeyError
        If no table has the name in a comment.
    """
    for name in START.findall(text):
        text = with_part(text, name, TABLES[name]())
    return text


def with_part(text: str, name: str, part: str) -> str:
    """Text with a part written anew, from ``<!-- NAME: generated -->`` to ``<!-- end of NAME -->``.

    Raises
    ------
    ValueError
        If the text lacks one of both comments.
    """
    start, end = f"<!-- {name}: generated -->", f"<!-- end of {name} -->"
    before, _, rest = text.partition(start)
    if not text.count(start) == rest.count(end) == 1:
        raise ValueError(f"{name}: one comment before the part and one after it are needed: {start} … {end}")
    return f"{before}{start}\n\n{part.strip()}\n\n{end}{rest.partition(end)[2]}"
