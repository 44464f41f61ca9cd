"""Summary of a night as Markdown, e.g. for the step summary of a CI."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.nightly.words import by_cause, change_rows, seconds_words
from reports.page import templates
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from pathlib import Path

    from reports.tables.nights.facts import NightlyFile

FILE = "summary.md"
MOST_ROWS = 30
MOST_NAMED = 3
"""Figures of a message"""


def write_summary(folder: Path, facts: NightlyFile) -> Path:
    """Write the summary of a night into a folder, and return its path."""
    path = folder / FILE
    write_atomically(path, summary(facts))
    return path


def message(facts: NightlyFile, link: str = "") -> str:
    """Night in three lines for mail or a chat: the sentence, the worst figures with their suspects, a link."""
    worst = (*facts.changes, *facts.standing)[:MOST_NAMED]
    said = []
    for row in change_rows(worst):
        suspects = ", ".join(suspect.name for suspect in row.entry.suspects) or "no part that differs"
        said.append(f"{row.entry.words} ({suspects})")
    return "\n".join(line for line in (facts.sentence, "; ".join(said), link or facts.night.name) if line)


def summary(facts: NightlyFile) -> str:
    """Text of the summary."""
    rows = change_rows(facts.changes)
    text = (
        templates()
        .get_template("nightly/summary.md.j2")
        .render(
            facts=facts,
            rows=rows[:MOST_ROWS],
            causes=by_cause(rows),
            more=max(len(rows) - MOST_ROWS, 0),
            most=MOST_ROWS,
            seconds=seconds_words,
        )
    )
    return text.strip() + "\n"
