"""From the bytes of a scene file to its tables of plain values, within limits that hold before Python's reader starts.

Python's TOML reader calls itself for each level of nesting, and its time grows with the square of the dots in a key.
Both are counted here on the text without its strings and comments.
"""

from __future__ import annotations

import os
import re
import tomllib
from typing import TYPE_CHECKING, Any

from scenarios.limits import FILE_BYTES, MOST_DOTS, MOST_LINE, MOST_NESTING, LimitError

if TYPE_CHECKING:
    from pathlib import Path

QUOTED = re.compile(
    r'"""(?:\\.|[^\\])*?(?:"{3,5}|\Z)'
    r"|'''.*?(?:'{3,5}|\Z)"
    r'|"(?:\\.|[^"\\\n])*(?:"|$|\Z)'
    r"|'[^'\n]*(?:'|$|\Z)"
    r"|#[^\n]*",
    re.DOTALL | re.MULTILINE,
)
"""Strings and comments; an open string ends with its line or with the text, so that each character is read once"""
BRACKETS = re.compile(r"[\[{\]}]")
DOTTED = re.compile(rf"(?:\.[ \t\w-]*+){{{MOST_DOTS + 1}}}")


class UnreadableError(ValueError):
    """A file that can't be read, or is no TOML."""


def read_text(path: Path) -> str:
    """Text of a file.

    Raises
    ------
    UnreadableError
        If the file can't be read as text.
    LimitError
        If it is too large.
    """
    try:
        FILE_BYTES.check(path.stat().st_size)
        with open(path, encoding="utf-8", opener=without_waiting) as file:
            text = file.read(FILE_BYTES.most + 1)
    except UnicodeDecodeError as error:
        raise UnreadableError(f"can't be read as UTF-8: {error.reason} at byte {error.start}") from None
    except OSError as error:
        raise UnreadableError(f"can't be read: {error.strerror or error}") from None
    FILE_BYTES.check(len(text))  # it may grow, and files of the system tell no size
    return text


def without_waiting(path: str, flags: int) -> int:
    """Descriptor of a file whose content, if it is yet to come as in ``/proc/kmsg``, is not waited for."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def tables_of(text: str) -> dict[str, Any]:
    """Tables of a TOML text.

    Raises
    ------
    UnreadableError
        If the text is no TOML.
    LimitError
        If it is too long, or nested too deep.
    """
    FILE_BYTES.check(len(text))
    bare = QUOTED.sub(stand_in, text)
    check_nesting(bare)
    check_dots(bare)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also a whole number of more than 4300 digits
        raise UnreadableError(f"not valid TOML: {one_line(str(error))}") from None


def stand_in(quoted: re.Match[str]) -> str:
    """Letter for a string or a comment, as a quoted key is a key; its lines stay."""
    return "s" + "\n" * quoted[0].count("\n")


def check_nesting(bare: str) -> None:
    """Reject brackets inside more than :data:`MOST_NESTING` brackets."""
    depth = 0
    for found in BRACKETS.finditer(bare):
        depth = depth + 1 if found[0] in "[{" else max(depth - 1, 0)
        if depth > MOST_NESTING:
            raise LimitError(
                f"line {line_of(bare, found)}: more than {MOST_NESTING} brackets inside each other given, "
                f"allowed: at most {MOST_NESTING}"
            )


def check_dots(bare: str) -> None:
    """Reject keys of more than :data:`MOST_DOTS` dots."""
    found = DOTTED.search(bare)
    if found:
        raise LimitError(
            f"line {line_of(bare, found)}: a key with more than {MOST_DOTS} dots given, allowed: at most {MOST_DOTS}"
        )


def line_of(text: str, found: re.Match[str]) -> int:
    """Line of a find, from 1."""
    return text.count("\n", 0, found.start()) + 1


def one_line(text: str) -> str:
    """Message on one line of limited length."""
    whole = " ".join(text.split())
    return whole if len(whole) <= MOST_LINE else whole[: MOST_LINE - 3] + "..."
