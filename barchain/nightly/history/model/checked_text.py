"""Texts of the data model: printable, on one line, and short."""

from __future__ import annotations

MOST_TEXT = 500
"""Characters of a text; names and reasons are far shorter"""


class FigureError(ValueError):
    """Raised for a figure, a part or a night that contradicts itself; the message is one line."""


def need_text(field: str, text: str, most: int = MOST_TEXT) -> None:
    """Check that a text is printable, on one line, and not too long.

    Raises
    ------
    FigureError
        If it is not.
    """
    if not text.isprintable() or len(text) > most:
        raise FigureError(f"{field}: {text[:60]!r} given, allowed: at most {most} printable characters")
