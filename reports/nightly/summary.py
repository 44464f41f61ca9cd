"""Markdown: the summary of a night, e.g. for a step of a CI, and the comment of a gate; the message for a chat."""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.page import templates
from reports.results.writing import write_atomically
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from reports.results.nights.document import ChangeEntry, NightlyFile
    from reports.results.nights.gate import GateResult

FILE = "summary.md"
MOST_ROWS = 30
MOST_NAMED = 3
"""Lines of a message on figures"""
MOST_CHARACTERS = 200
"""Characters of a line of a message, other than the link"""
SENTENCE_END = re.compile(r"(?<=[.…]) (?=[A-Z0-9])")
NOT_REPRODUCIBLE = "not reproducible: the parts are the same, the bits are others"


def write_summary(folder: Path, facts: NightlyFile) -> None:
    """Write the summary of a night into a folder."""
    template = templates().get_template("nightly/summary.md.j2")
    text = template.render(facts=facts, causes=by_cause(facts.changes), most=MOST_ROWS)
    write_atomically(folder / FILE, text.strip() + "\n")


def gate_comment(result: GateResult) -> str:
    """Comment of a gate for a pull request; its first line is the answer."""
    text = templates().get_template("nightly/gate.md.j2").render(result=result, most=MOST_ROWS)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def message(facts: NightlyFile, link: str = "", before: str = "") -> str:
    """Night in a few lines for mail or a chat: the sentences, the worst figures with suspects and a reason, a link.

    Figures of one scene and engine that are worse, or not, since one night are one line, with the gravest of them.
    `before` are sentences on a later night that has no figures.
    """
    every, said = facts.listed, list[str]()
    groups: dict[tuple[object, ...], list[ChangeEntry]] = {}
    for change in every:
        key = change.scene, change.engine, change.since, change.direction, change.accepted is None, change.suspects
        groups.setdefault(key, []).append(change)
    for change, *others in list(groups.values())[:MOST_NAMED]:
        own = dict.fromkeys(suspect.short for suspect in (*change.suspects, *change.newest))
        suspects = ", ".join(own) or ("unknown parts" if change.unknown else "no part that differs")
        names = "" if change.never_words else f" ({suspects})"
        more = f", and {plural(len(others), 'more figure')} there" if others else ""
        room = MOST_CHARACTERS - len(more) - len(names)
        said.append(f"{textwrap.shorten(change.dated(facts.night.name), room, placeholder=' …')}{more}{names}")
    left = sum(map(len, list(groups.values())[MOST_NAMED:]))
    said += [f"and {plural(left, 'more figure')}"] if left else []
    changed = {(change.scene, change.engine) for change in every}
    failed = [rejected.words for rejected in facts.rejected if (rejected.scene, rejected.engine) in changed]
    said += [words for words in failed[:1] if words not in facts.sentence]
    if not said:
        said = [rejected.words for rejected in facts.rejected[:MOST_NAMED]]
    sentences = [line for text in (before, facts.sentence) for line in lines_of(text)]
    left_out = [facts.left_out_words] if facts.left_out else []
    lines = [textwrap.shorten(line, MOST_CHARACTERS, placeholder=" …") for line in (*said, *left_out)]
    return "\n".join([*sentences, *lines, link or facts.night.name])


def lines_of(text: str) -> list[str]:
    """Sentences in lines of at most :data:`MOST_CHARACTERS`: as many whole ones as fit into each."""
    found: list[str] = []
    for sentence in SENTENCE_END.split(text):
        together = f"{found[-1]} {sentence}" if found else sentence
        fits = len(together) <= MOST_CHARACTERS
        found[-1:] = [together] if fits else [*found[-1:], *textwrap.wrap(sentence, MOST_CHARACTERS)]
    return list(filter(None, found))


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
