"""Documents carried out: files written, commands and Python run in the order of the page, outputs compared."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
EXIT_CODE = re.compile(r"#\s*exit code (\d+)")
FILE = re.compile(r"# (\w+\.toml)\n")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    language: str
    text: str


def blocks(page: Path) -> list[Block]:
    """Fenced blocks with a language, in their order."""
    return [Block(*found.groups()) for found in BLOCK.finditer(page.read_text("utf-8"))]


def carry_out(page: Path, folder: Path) -> int:
    """Carry out a page in an empty folder; the number of commands, scripts and files.

    Output that the page shows must come: the same lines up to their numbers and spaces.
    """
    count, said = 0, ""
    for block in blocks(page):
        if block.language == "text":
            missing = [line for line in shapes(block.text) if line not in shapes(said)]
            assert not missing, f"{page.name} shows lines that did not come: {missing}\n{said}"
        elif block.language == "toml" and (name := FILE.match(block.text)):
            (folder / name.group(1)).write_text(block.text, encoding="utf-8")
            count += 1
        elif block.language == "python":
            said = run([sys.executable, "-c", block.text], folder, 0)
            count += 1
        elif block.language == "sh":
            lines = [line for line in block.text.splitlines() if line.startswith("barchain ")]
            said = "".join(command(line, folder) for line in lines) or said
            count += len(lines)
    return count


def command(line: str, folder: Path) -> str:
    """Output of a command; a comment may give another exit code than 0."""
    code = EXIT_CODE.search(line)
    words = shlex.split(line, comments=True)[1:]
    return run([sys.executable, "-m", "barchain", *words], folder, int(code.group(1)) if code else 0)


def run(words: list[str], folder: Path, code: int) -> str:
    """Output and messages of a program that must end with an exit code."""
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    said = done.stdout + done.stderr
    assert done.returncode == code, f"{words} ended with {done.returncode}:\n{said}"
    return said


def shapes(text: str) -> list[str]:
    """Lines without their numbers and spaces: times and last digits differ from machine to machine."""
    return ["".join(NUMBER.sub("#", line).split()) for line in text.splitlines() if line.strip()]
