"""Lists of the mistakes that the diagnosis knows, by the convention that they break."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.cli.common.meanings import MISTAKES

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.mistake import Mistake

CONVENTIONS = "../explanation/engine_conventions.md"
TITLES = {"masses-lengths-and-inertia": "Masses, lengths and inertia"}
"""Headings that an anchor does not give back"""


def known_mistakes() -> str:
    """All known mistakes, a list for each section of the conventions."""
    sections: dict[str, list[Mistake]] = {}
    for mistake in MISTAKES:
        sections.setdefault(mistake.section, []).append(mistake)
    count = sum(map(len, sections.values()))
    return "\n\n".join([f"These are {count} mistakes.", *(listed(name, of) for name, of in sections.items())])


def listed(section: str, mistakes: list[Mistake]) -> str:
    """Heading of a section with a link to its convention, and its mistakes."""
    title = TITLES.get(section, section.replace("-", " ").capitalize())
    items = "\n".join(f"- {mistake.sentence}" for mistake in mistakes)
    return f"## {title}\n\n[Convention]({CONVENTIONS}#{section}).\n\n{items}"


TABLES: dict[str, Callable[[], str]] = {"known-mistakes": known_mistakes}
"""Tables by their names"""
