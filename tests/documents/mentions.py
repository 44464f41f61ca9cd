"""What the documents name: links, paths, scenes and command lines, read from Markdown."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from pictures.paths import GENERATED
from tests.structure.product import PACKAGES, ROOT, python_files

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

FOLDERS = (*PACKAGES, "tests", "docs", "benchmarks", ".ci")
SCENE_FOLDERS = tuple(p.name for p in sorted((ROOT / "scenarios").iterdir()) if any(p.glob("*.toml")))
FENCE = re.compile(r"^```[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"`([^`\n]+)`")
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)]*)?\)")
WORD = re.compile(r"[\w.<>*/\-]+")
COMMAND = re.compile(r"^(?:.*?&& )?(?:\.venv/bin/)?barchain( [a-z-].*)?$")
LONG_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
PLACEHOLDER = re.compile(r"[\[<|…]|\.\.\.|\b[A-Z]{2,}\b|\s{2}")
DOCUMENT = re.compile(r"\b(?:docs|design)/[\w/]+\.md\b")


def documents() -> list[Path]:
    """All Markdown documents that people write but the changelog, which tells what was."""
    below = (path for folder in ("docs", "benchmarks") for path in (ROOT / folder).rglob("*.md"))
    written = (path for path in below if GENERATED not in path.parents)
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(written)]


def links(document: Path) -> list[str]:
    """Links to files."""
    return [link for link in LINK.findall(document.read_text(encoding="utf-8")) if "://" not in link]


def code_of(document: Path) -> list[str]:
    """Code in a document: its fenced blocks, and what stands between backticks in a line."""
    text = document.read_text(encoding="utf-8")
    return [*FENCE.findall(text), *SPAN.findall(FENCE.sub("", text))]


def paths(document: Path) -> Iterator[str]:
    """Paths in code that begin with one of the project's folders, or name a Python file; placeholders left out."""
    for code in code_of(document):
        for word in WORD.findall(code):
            path = word.rstrip(".")
            if "<" not in path and ((path.split("/")[0] in FOLDERS and "/" in path) or path.endswith(".py")):
                yield path


def exists(path: str) -> bool:
    """Whether a path leads to something in the project; a file's bare name may lie anywhere in it."""
    if "/" in path:
        return any(ROOT.glob(path.rstrip("/")))
    return any(any((ROOT / folder).rglob(path)) for folder in FOLDERS)


def scenes(document: Path) -> Iterator[str]:
    """Names of scenes in code, such as ``paper/fig05``."""
    for code in code_of(document):
        for word in WORD.findall(code):
            folder, slash, rest = word.partition("/")
            if folder in SCENE_FOLDERS and slash and rest and not set(rest) & set("<*/."):
                yield word


def command_lines(document: Path) -> Iterator[tuple[str, bool]]:
    """Words after barchain in command lines, and whether each line is whole: one that can be typed as it stands."""
    for code in code_of(document):
        for line in re.sub(r"\\?\n {4,}", " ", code).splitlines():
            command = COMMAND.match(re.split(r" #", line)[0].strip())
            if command:
                words = (command.group(1) or "").strip()
                yield words, "\n" in code and not PLACEHOLDER.search(words)


def options_in_prose(document: Path) -> list[str]:
    """Long options that sentences and tables name; fenced command lines are parsed whole."""
    return LONG_OPTION.findall(FENCE.sub("", document.read_text(encoding="utf-8")))


def named_documents() -> Iterator[tuple[Path, str]]:
    """Documents that Python files of the product and its tests point to."""
    for file in python_files(*PACKAGES, "tests", "benchmarks"):
        for path in DOCUMENT.findall(file.read_text(encoding="utf-8")):
            yield file, path
