"""Summary of a night as Markdown, e.g. for the step summary of a CI, and the message for a chat."""

from __future__ import annotations

import textwrap
from itertools import zip_longest
from typing import TYPE_CHECKING

from reports.nightly.words import by_cause, seconds_words
from reports.page import templates
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from pathlib import Path

    from reports.tables.nights.facts import NightlyFile

FILE = "summary.md"
MOST_ROWS = 30
MOST_NAMED = 3
"""Figures of a message"""
MOST_CHARACTERS = 200
"""Characters of a line of a message, other than the link"""


def write_summary(folder: Path, facts: NightlyFile) -> None:
    """Write the summary of a night into a folder."""
    template = templates().get_template("nightly/summary.md.j2")
    text = template.render(facts=facts, causes=by_cause(facts.changes), most=MOST_ROWS, seconds=seconds_words)
    write_atomically(folder / FILE, text.strip() + "\n")


def message(facts: NightlyFile, link: str = "") -> str:
    """Night in a few lines for mail or a chat: the sentences, the worst figures with suspects and a reason, a link.

    Figures that follow each other and have the same suspects are followed by these once.
    """
    every, said = (*facts.standing, *facts.other_news), []
    for change, after in zip_longest(every[:MOST_NAMED], every[1:MOST_NAMED]):
        suspects = ", ".join(suspect.short for suspect in change.suspects) or "no part that differs"
        again = after is not None and after.suspects == change.suspects
        said.append(f"{change.dated(facts.night.name)}{'' if again else f' ({suspects})'}")
    if len(every) > MOST_NAMED:
        said.append(f"and {len(every) - MOST_NAMED} more")
    changed = {(change.scene, change.engine) for change in every}
    said += [rejected.words for rejected in facts.rejected if (rejected.scene, rejected.engine) in changed][:1]
    if not said:
        said = [rejected.words for rejected in facts.rejected[:MOST_NAMED]]
    sentences = textwrap.wrap(facts.sentence, MOST_CHARACTERS)
    return "\n".join([*sentences, *map(cut, said), link or facts.night.name])


def cut(line: str) -> str:
    """Line of at most the characters that a chat shows, cut between words."""
    if len(line) <= MOST_CHARACTERS:
        return line
    return f"{line[: MOST_CHARACTERS - 2].rpartition(' ')[0].rstrip(';,')} …"
