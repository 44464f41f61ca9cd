"""Fenced blocks of README and documents outside the tutorials, and how a test carries out each."""

from __future__ import annotations

import itertools
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.documents.mentions import documents
from tests.documents.running import blocks
from tests.structure.product import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterator

TUTORIALS = ROOT / "docs" / "tutorials"
PUBLISHED = ROOT / "docs" / "explanation" / "external_checks.md"
FRAGMENT = "[effects"
"""Beginning of a block that belongs into a scene"""


@dataclass(frozen=True)
class Snippet:
    """A command, or a block of another language."""

    document: Path
    language: str
    text: str

    def __str__(self) -> str:
        """Place and first line."""
        return f"{self.document.relative_to(ROOT)}: {self.text.splitlines()[0][:70]}"


@cache
def ways() -> dict[str, Any]:
    """Table of ways."""
    return tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))


@cache
def snippets() -> tuple[Snippet, ...]:
    """Every snippet of README and documents but those of pages with tests of their own."""
    left_out = {ROOT / "README.md", PUBLISHED, *TUTORIALS.glob("*.md")}
    pages = [d for d in documents() if d not in left_out]
    return tuple(itertools.chain.from_iterable(map(of_page, pages)))


def of_page(page: Path) -> Iterator[Snippet]:
    """Snippets of a page: a command for each line of a shell's block."""
    for block in blocks(page):
        if block.language == "sh":
            for line in block.text.splitlines():
                yield Snippet(page, "sh", line.split(" #")[0].strip())
        else:
            yield Snippet(page, block.language, block.text)


def reason_not_run(snippet: Snippet) -> str | None:
    """Reason why no test carries out a snippet; None if one does."""
    found = [why for start, why in ways()["not_run"].items() if snippet.text.startswith(start)]
    return found[0] if found and snippet.text not in ways()["with_less"] else None


def kind(snippet: Snippet) -> str:
    """Kind of what is carried out here; empty of a snippet that no test carries out."""
    if snippet.language == "toml":
        parts = {"plan": "[[comparison]]" in snippet.text, "scene": "[orbit]" in snippet.text}
        parts["effect"] = snippet.text.startswith((FRAGMENT, f"[{FRAGMENT}"))
        return next((name for name, there in parts.items() if there), "")
    return snippet.language if snippet.language in ("python", "sh") and reason_not_run(snippet) is None else ""


def of_kind(wanted: str) -> list[Snippet]:
    """Snippets of a kind: an effect, scene or plan, a script in Python, a command of a shell."""
    return [s for s in snippets() if kind(s) == wanted]
