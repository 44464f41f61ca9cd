"""What the documents name: links, paths, scenes and command lines, read from Markdown."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pictures.paths import GENERATED
from tests.structure.product import PACKAGES, ROOT, python_files

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

FOLDERS = (*PACKAGES, "tests", "docs", "benchmarks", ".ci")
SCENE_FOLDERS = tuple(p.name for p in sorted((ROOT / "scenarios").iterdir()) if any(p.glob("*.toml")))
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"`([^`\n]+)`")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)]*)?\)")
WORD = re.compile(r"[\w.<>*/\-]+")
COMMAND = re.compile(r"^(?:.*?&& )?(?:\.venv/bin/)?barchain( [a-z-].*)?$")
LONG_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
PLACEHOLDER = re.compile(r"[\[<|…]|\.\.\.|\b[A-Z]{2,}\b|\s{2}")


@dataclass(frozen=True)
class Mention:
    """A path or a command line in a document."""

    document: Path
    line: int
    text: str

    def __str__(self) -> str:
        """Place and text, for a message."""
        return f"{self.document.relative_to(ROOT)}:{self.line}: {self.text}"


def documents() -> list[Path]:
    """All Markdown documents that people write but the changelog, which tells what was."""
    below = (path for folder in ("docs", "benchmarks") for path in (ROOT / folder).rglob("*.md"))
    written = (path for path in below if GENERATED not in path.parents)
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(written)]


def links(document: Path) -> Iterator[tuple[Mention, Path]]:
    """Links to files, each with the path that it leads to."""
    text = document.read_text(encoding="utf-8")
    for found in LINK.finditer(text):
        if "://" not in found.group(1):
            yield mention(document, text, found.start(), found.group(1)), document.parent / found.group(1)


def paths(document: Path) -> Iterator[Mention]:
    """Paths in code that begin with one of the project's folders, or name a Python file; placeholders left out."""
    text = document.read_text(encoding="utf-8")
    for start, code in spans_and_fences(text):
        for word in WORD.finditer(code):
            path = word.group().rstrip(".")
            if "<" not in path and ((path.split("/")[0] in FOLDERS and "/" in path) or path.endswith(".py")):
                yield mention(document, text, start + word.start(), path)


def exists(path: str) -> bool:
    """Whether a path leads to something in the project; a file's bare name may lie anywhere in it."""
    if "/" in path:
        return any(ROOT.glob(path.rstrip("/")))
    return any(any((ROOT / folder).rglob(path)) for folder in FOLDERS)


def scenes(document: Path) -> Iterator[Mention]:
    """Names of scenes in code, such as ``paper/fig05``."""
    text = document.read_text(encoding="utf-8")
    for start, code in spans_and_fences(text):
        for word in WORD.finditer(code):
            folder, slash, rest = word.group().partition("/")
            if folder in SCENE_FOLDERS and slash and rest and not set(rest) & set("<*/."):
                yield mention(document, text, start + word.start(), word.group())


def command_lines(document: Path) -> Iterator[tuple[Mention, bool]]:
    """Command lines of barchain in code, and whether each is whole: one that can be typed as it stands."""
    text = document.read_text(encoding="utf-8")
    for start, code in spans_and_fences(text):
        joined = re.sub(r"\\?\n {4,}", lambda gap: " " * len(gap.group()), code)  # as long as before: places stay
        at, fenced = start, "\n" in code
        for line in joined.splitlines(keepends=True):
            command = COMMAND.match(re.split(r" #", line)[0].strip())
            if command:
                words = (command.group(1) or "").strip()
                yield mention(document, text, at, words), fenced and not PLACEHOLDER.search(words)
            at += len(line)


def options_in_prose(document: Path) -> Iterator[Mention]:
    """Long options that sentences and tables name; fenced command lines are parsed whole."""
    text = document.read_text(encoding="utf-8")
    for found in LONG_OPTION.finditer(without_fences(text)):
        yield mention(document, text, found.start(), found.group())


def without_fences(text: str) -> str:
    """Text with blanks for fenced blocks: places stay."""
    return FENCE.sub(lambda fence: re.sub(r"[^\n]", " ", fence.group()), text)


def spans_and_fences(text: str) -> Iterator[tuple[int, str]]:
    """Code in a document, each piece with the place where it starts."""
    for found in FENCE.finditer(text):
        first = text.index("\n", found.start()) + 1
        yield first, text[first : found.end() - 3]
    for found in SPAN.finditer(without_fences(text)):
        yield found.start(1), found.group(1)


def mention(document: Path, text: str, at: int, what: str) -> Mention:
    """What a document says at a place in its text."""
    return Mention(document, text.count("\n", 0, at) + 1, what)


def docstring_paths() -> Iterator[Mention]:
    """Documents that Python files of the product and its tests point to."""
    for file in python_files(*PACKAGES, "tests", "benchmarks"):
        text = file.read_text(encoding="utf-8")
        for found in re.finditer(r"\b(?:docs|design)/[\w/]+\.md\b", text):
            yield mention(file, text, found.start(), found.group())
