"""Tables that pages of the documentation include: their text, by the name of the file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pictures.pages import (
    cost_page,
    effect_tables,
    interface_tables,
    judge_tables,
    mistake_lists,
    reference_tables,
    releases,
)
from pictures.paths import TABLES

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

FRAGMENTS: dict[str, Callable[[], str]] = {
    **cost_page.TABLES,
    **effect_tables.TABLES,
    **interface_tables.TABLES,
    **judge_tables.TABLES,
    **mistake_lists.TABLES,
    **reference_tables.TABLES,
    **releases.TABLES,
}
"""Tables by their names"""


def fragments() -> dict[Path, str]:
    """Text of each table, by its file."""
    return {TABLES / f"{name}.md": f"{make().strip()}\n" for name, make in FRAGMENTS.items()}
