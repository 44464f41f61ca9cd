"""Summary of a night as Markdown, e.g. for the step summary of a CI; the message for a chat; changes by their cause."""

from __future__ import annotations

import textwrap
from collections import Counter
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING

from reports.page import templates
from reports.results.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from reports.results.nights.document import ChangeEntry, NightlyFile

FILE = "summary.md"
MOST_ROWS = 30
MOST_NAMED = 3
"""Figures of a message"""
MOST_CHARACTERS = 200
"""Characters of a line of a message, other than the link"""
NOT_REPRODUCIBLE = "not reproducible: the parts are the same, the bits are others"


def write_summary(folder: Path, facts: NightlyFile) -> None:
    """Write the summary of a night into a folder."""
    template = templates().get_template("nightly/summary.md.j2")
    text = template.render(facts=facts, causes=by_cause(facts.changes), most=MOST_ROWS, seconds=seconds_words)
    write_atomically(folder / FILE, text.strip() + "\n")


def message(facts: NightlyFile, link: str = "", before: str = "") -> str:
    """Night in a few lines for mail or a chat: the sentences, the worst figures with suspects and a reason, a link.

    Figures that follow each other and have the same suspects are followed by these once. `before` are sentences on a
    later night that has no figures.
    """
    every, said = facts.listed, list[str]()
    for change, after in zip_longest(every[:MOST_NAMED], every[1:MOST_NAMED]):
        own = dict.fromkeys(suspect.short for suspect in (*change.suspects, *change.newest))
        suspects = ", ".join(own) or "no part that differs"
        again = after is not None and (after.suspects, after.newest) == (change.suspects, change.newest)
        said.append(f"{change.dated(facts.night.name)}{'' if again else f' ({suspects})'}")
    if len(every) > MOST_NAMED:
        said.append(f"and {len(every) - MOST_NAMED} more")
    changed = {(change.scene, change.engine) for change in every}
    said += [rejected.words for rejected in facts.rejected if (rejected.scene, rejected.engine) in changed][:1]
    if not said:
        said = [rejected.words for rejected in facts.rejected[:MOST_NAMED]]
    sentences = [line for text in (before, facts.sentence) for line in textwrap.wrap(text, MOST_CHARACTERS)]
    left_out = [facts.left_out_words] if facts.left_out else []
    return "\n".join([*sentences, *map(cut, (*said, *left_out)), link or facts.night.name])


def cut(line: str) -> str:
    """Line of at most the characters that a chat shows, cut between words."""
    if len(line) <= MOST_CHARACTERS:
        return line
    return f"{line[: MOST_CHARACTERS - 2].rpartition(' ')[0].rstrip(';,')} …"


@dataclass(frozen=True)
class CauseGroup:
    """Changes of one cause."""

    cause: str
    """Suspects with what they were and are"""
    confirmed: str
    accepted: str
    changes: tuple[ChangeEntry, ...]

    @property
    def amounts(self) -> str:
        """``12 worse, 2 changed``."""
        found = Counter(change.direction for change in self.changes)
        return ", ".join(f"{count} {direction}" for direction, count in found.most_common())

    @property
    def where(self) -> str:
        """Engines, and the number of scenes: ``mujoco in 3 scenes``."""
        engines = sorted({change.engine for change in self.changes if change.engine})
        scenes = len({change.scene for change in self.changes if change.scene})
        place = f"{scenes} {'scene' if scenes == 1 else 'scenes'}" if scenes else ""
        return " in ".join(part for part in (", ".join(engines), place) if part)


def by_cause(changes: Iterable[ChangeEntry]) -> list[CauseGroup]:
    """Changes by cause, in the order in which the causes come first."""
    found: dict[tuple[str, str, str], list[ChangeEntry]] = {}
    for change in changes:
        cause = NOT_REPRODUCIBLE if change.irreproducible else change.suspect_words
        accepted = change.accepted.sentence if change.accepted else ""
        found.setdefault((cause, change.confirmed_words, accepted), []).append(change)
    return [CauseGroup(*key, tuple(own)) for key, own in found.items()]


def seconds_words(duration_s: float) -> str:
    """``12 min 5 s``."""
    minutes, seconds = divmod(round(duration_s), 60)
    return f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
