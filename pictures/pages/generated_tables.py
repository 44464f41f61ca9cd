"""Generated tables of committed pages, between markers in the page: what a reader sees in the repository is whole.

A page holds two comments, ``generated: NAME`` and ``end: NAME``; the text between them is the table of that name.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from pictures.pages import (
    check_values,
    cost_page,
    effect_tables,
    interface_tables,
    judge_tables,
    mistake_lists,
    reference_tables,
    releases,
)
from pictures.paths import DOCS, GENERATED

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

FRAGMENTS: dict[str, Callable[[], str]] = {
    **check_values.TABLES,
    **cost_page.TABLES,
    **effect_tables.TABLES,
    **interface_tables.TABLES,
    **judge_tables.TABLES,
    **mistake_lists.TABLES,
    **reference_tables.TABLES,
    **releases.TABLES,
}
"""Tables by their names"""
BLOCK = re.compile(
    r"(?P<begin><!-- generated: (?P<name>[\w-]+) -->\n)(?P<text>.*?)(?P<end><!-- end: (?P=name) -->)", re.S
)


def pages_with_tables() -> dict[Path, str]:
    """Committed pages that hold generated tables, with the tables as they must be.

    Raises
    ------
    KeyError
        If a page names a table that is not made.
    """
    texts = {path: path.read_text(encoding="utf-8") for path in DOCS.rglob("*.md") if GENERATED not in path.parents}
    return {path: filled(text) for path, text in texts.items() if BLOCK.search(text)}


def filled(text: str) -> str:
    """Text of a page with its generated tables made anew."""
    return BLOCK.sub(lambda found: f"{found['begin']}\n{FRAGMENTS[found['name']]().strip()}\n\n{found['end']}", text)
