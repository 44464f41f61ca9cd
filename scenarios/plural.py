"""Numbers with their nouns."""

from __future__ import annotations


def plural(count: int, noun: str, number: str = "") -> str:
    """``1 bar``, ``5 bars``; with a number in words ``five bars``."""
    return f"{number or count} {noun}{'' if count == 1 else 's'}"
