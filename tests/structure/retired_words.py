"""The table of retired words, and where in a text they stand."""

from __future__ import annotations

import fnmatch
import functools
import re
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tests.structure.product import relative
from tests.structure.prose import texts

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

TABLE = "retired_words.toml"


@dataclass(frozen=True)
class Retired:
    """A retired word, and what is said instead."""

    pattern: re.Pattern[str]
    instead: str


@dataclass(frozen=True)
class Allowance:
    """A passage in which a retired word may stand."""

    path: str
    text: re.Pattern[str]
    reason: str


@dataclass(frozen=True)
class Words:
    """The whole table."""

    retired: tuple[Retired, ...]
    allowances: tuple[Allowance, ...]

    def found(self, path: Path) -> Iterator[str]:
        """One line for each retired word in a file: place, passage, what to say."""
        for first, text in texts(path):
            allowed = list(self.allowed(relative(path), text))
            for word in self.retired:
                for hit in word.pattern.finditer(text):
                    if not any(begin <= hit.start() and hit.end() <= end for begin, end in allowed):
                        line = first + text.count("\n", 0, hit.start())
                        yield f"{relative(path)}:{line}: {' '.join(hit.group().split())!r}: say {word.instead}"

    def allowed(self, path: str, text: str) -> Iterator[tuple[int, int]]:
        """Begin and end of every passage of a text that is allowed as it stands."""
        for each in self.allowances:
            if fnmatch.fnmatch(path, each.path):
                yield from (hit.span() for hit in each.text.finditer(text))


@functools.cache
def table(path: Path) -> Words:
    """Table of retired words in a TOML file."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    retired = tuple(Retired(compiled(each["pattern"]), each["instead"]) for each in data["word"])
    given = data.get("allowance", [])
    return Words(retired, tuple(Allowance(a["path"], compiled(a["text"]), a["reason"]) for a in given))


def compiled(pattern: str) -> re.Pattern[str]:
    """Regular expression in which a space is any white space, a line's end included."""
    return re.compile(pattern.replace(" ", r"\s+"), re.IGNORECASE)
