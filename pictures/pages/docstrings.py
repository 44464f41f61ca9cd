"""Docstrings of the engines' packages as paragraphs with labels."""

from __future__ import annotations

import importlib
import inspect
import re
from dataclasses import dataclass

LABEL = re.compile(r"^(?P<label>[A-Z][A-Za-z ]{2,30}): (?P<text>.*)", re.DOTALL)


@dataclass(frozen=True)
class DocstringParagraph:
    """Paragraph of a docstring."""

    label: str
    """Empty for a paragraph without one"""
    text: str


def paragraphs(package: str) -> list[DocstringParagraph]:
    """Paragraphs of a package's docstring, in order; lines are joined."""
    text = inspect.getdoc(importlib.import_module(package)) or ""
    found: list[DocstringParagraph] = []
    for block in text.split("\n\n"):
        for line in sentences(block):
            match = LABEL.match(line)
            found.append(
                DocstringParagraph(match["label"], capital(match["text"])) if match else DocstringParagraph("", line)
            )
    return found


def sentences(block: str) -> list[str]:
    """Parts of a block that each begin with a label; a block without labels is one part."""
    parts: list[str] = []
    for line in block.splitlines():
        if LABEL.match(line) or not parts:
            parts.append(line)
        else:
            parts[-1] += f" {line}"
    return parts


def capital(text: str) -> str:
    """Text with a capital first letter; code stays as it is."""
    return text[:1].upper() + text[1:]
