"""Meanings of the words that barchain prints and reads: outcomes, terms, keys of a scene, mistakes, exit codes.

The documentation's tables are made of the same dictionaries, so that a word has one meaning.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.cli.common.exit_codes import MEANINGS
from barchain.judge.diagnosis.mistake import addressed
from barchain.judge.diagnosis.readings import READINGS, TIMINGS
from barchain.judge.diagnosis.starts import STARTS
from reports.results.outcome import SEVERITY
from reports.results.selftest import FaultOutcome
from reports.results.stability import Stability
from reports.text.glossary import FIELD, TERMS
from scenarios.channels import STORED
from scenarios.derived_channels import DERIVED
from scenarios.nearest import nearest
from scenarios.toml.key_tables import HEAD, NONE, key_tables

if TYPE_CHECKING:
    from collections.abc import Iterator

MISTAKES = (*READINGS, *TIMINGS, *STARTS)
"""Known mistakes of reading and of the start"""
FILLERS = re.compile(r"[`'\"\[\].,]|\b(?:a|an|the|your|is|are|have|has|of|in)\b|[\s_-]+")
"""Signs, and words that tell nothing apart"""


@dataclass(frozen=True)
class Meaning:
    """A word with its meaning."""

    kind: str
    """Plural, e.g. ``outcomes``"""
    word: str
    text: str
    page: str
    """Page of the documentation, with the section"""

    @property
    def names(self) -> frozenset[str]:
        """Forms of the word that name it; of a key also with its table."""
        last = self.word.rpartition(".")[2]
        return frozenset({reduced(self.word), reduced(last)})

    def mentions(self, words: set[str]) -> bool:
        """Whether word and meaning hold all of some reduced words."""
        said = f" {reduced(self.word)} {reduced(self.text)} "
        return all(f" {word} " in said for word in words)


class UnknownWordError(LookupError):
    """No meaning is known for a word."""


def reduced(text: str) -> str:
    """Text in lower case without fillers and signs: ``joints_ignored`` and ``Joints ignored`` are one word."""
    return " ".join(FILLERS.sub(" ", text.casefold()).split())


def meanings() -> Iterator[Meaning]:
    """All words, kind by kind."""
    for outcome in SEVERITY:
        code = "exit code 0" if outcome.ok else "exit code 1"
        yield Meaning("outcomes", outcome, f"{outcome.advice} ({code})", "docs/explanation/verdicts.md#outcomes")
    for stability in Stability:
        yield Meaning("outcomes of stability", stability, stability.advice, "docs/studies/stability.md")
    for fault in FaultOutcome:
        yield Meaning("outcomes of selftest", fault, fault.advice, "docs/studies/selftest.md")
    for term, text in sorted((TERMS | FIELD).items(), key=lambda item: item[0].casefold()):
        yield Meaning("terms", term, text, "docs/reference/glossary.md")
    yield from keys()
    for channel in (*STORED, *DERIVED):
        unit = "" if channel.unit == "1" else f", {channel.unit}"
        columns = ", ".join(channel.columns).replace("{}", "j")
        text = f"{channel.words}{unit}. {channel.meaning} Columns: {columns}."
        yield Meaning("channels", channel.name, text, "docs/reference/channels.md")
    for mistake in MISTAKES:
        yield Meaning("mistakes", mistake.name, f"{addressed(mistake.sentence)}.", mistake.anchor)
    for number, text in MEANINGS.items():
        yield Meaning("exit codes", str(int(number)), text, "docs/reference/command_line.md#exit-codes")


def keys() -> Iterator[Meaning]:
    """Tables and keys of a scene file; a key's word has its table before it."""
    page = "docs/reference/scene_keys.md"
    for title, text, rows in key_tables():
        table = title.strip("`[]") if title.startswith("`") else ""
        names = ", ".join(row[0].strip("`") for row in rows)
        if table:
            yield Meaning("keys", table, f"{text} Keys: {names}.".strip(), page)
        for cells in (dict(zip(HEAD, row, strict=True)) for row in rows):
            if "table" in cells["type"]:
                continue  # has a meaning of its own, with its keys
            details = (f"{name} {cells[name]}" for name in ("type", "default", "allowed") if cells[name] != NONE)
            key = cells["key"].strip("`")
            yield Meaning("keys", f"{table}.{key}".strip("."), f"{cells['meaning']}; {'; '.join(details)}", page)


def kinds() -> dict[str, list[Meaning]]:
    """Words by their kind."""
    found: dict[str, list[Meaning]] = {}
    for meaning in meanings():
        found.setdefault(meaning.kind, []).append(meaning)
    return found


def explain(word: str) -> list[Meaning]:
    """Meanings of a word: of that name, else those that mention all words that are given.

    Parameters
    ----------
    word : str
        E.g. ``inconsistent``, ``predictability limit``, ``drag.width_m``, or a part of a diagnosis such as
        ``opposite sign``.

    Returns
    -------
    list of Meaning
        Several where a word has several, e.g. the key ``width_m`` of two effects.

    Raises
    ------
    UnknownWordError
        If there is none; the message has the nearest word.
    """
    every, wanted = list(meanings()), reduced(word)
    found = [m for m in every if wanted in m.names]
    found = found or [m for m in every if m.word.endswith(f".{word}")]
    parts = {reduced(part) for part in word.split()} - {""}
    found = found or [m for m in every if parts and m.mentions(parts)]
    if found:
        return found
    words = {name for m in every for name in (m.word, m.word.rpartition(".")[2])}
    raise UnknownWordError(f"{word}: no word of barchain{nearest(word, words)}; `barchain explain` lists the kinds")
