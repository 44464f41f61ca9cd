"""Text that people read: strings of Python files, templates, scenes' texts, documents."""

from __future__ import annotations

import ast
import io
import tokenize
from typing import TYPE_CHECKING

from tests.structure.product import PACKAGES, ROOT, tree

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

SUFFIXES = {".py", ".j2", ".toml", ".md"}
QUOTING = {"retired_words.toml", "test_words.py"}  # they name the retired words
DEEP = ("adapters", "barchain", "reference_impl", "reports", "docs")  # whose folders are checked one by one


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """Passages of a file, each with the line that it starts on.

    Of Python files these are strings (docstrings, messages and help) and comments. Of other files all is text.
    """
    if path.suffix != ".py":
        yield 1, path.read_text(encoding="utf-8")
        return
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value
    yield from comments(path)


def comments(path: Path) -> Iterator[tuple[int, str]]:
    """Comments of a Python file; lines that follow on each other are one passage."""
    source = io.StringIO(path.read_text(encoding="utf-8"))
    passages: list[tuple[int, list[str]]] = []
    for token in tokenize.generate_tokens(source.readline):
        if token.type != tokenize.COMMENT:
            continue
        line, text = token.start[0], token.string.lstrip("#")
        if passages and passages[-1][0] + len(passages[-1][1]) == line:
            passages[-1][1].append(text)
        else:
            passages.append((line, [text]))
    for first, lines in passages:
        yield first, "\n".join(lines)


def rooms() -> dict[str, list[Path]]:
    """Files with text for people by the folder that they are counted under; the changelog tells what was."""
    found: dict[str, list[Path]] = {"README.md": [ROOT / "README.md"], "CONTRIBUTING.md": [ROOT / "CONTRIBUTING.md"]}
    for top in (*PACKAGES, "benchmarks", "docs", "tests"):
        for path in sorted((ROOT / top).rglob("*")):
            if path.suffix in SUFFIXES and path.name not in QUOTING:
                found.setdefault(room(path), []).append(path)
    return found


def room(path: Path) -> str:
    """Folder that a file is counted under: no deeper than an engine, a study or a chapter."""
    parts = path.relative_to(ROOT).parent.parts
    depth = 3 if parts[1:2] in {("studies",), ("chapters",)} else 2
    return "/".join(parts[:depth] if parts[0] in DEEP else parts[:1])
