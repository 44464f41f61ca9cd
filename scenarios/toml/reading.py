"""From the bytes of a scene file to its tables of plain values."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

from scenarios.named_file import UnreadableError, decoded, read_named
from scenarios.size_limits import FILE_BYTES, MOST_LINE

if TYPE_CHECKING:
    from pathlib import Path


def read_text(path: Path) -> str:
    """Text of a file, with or without a byte-order mark.

    Raises
    ------
    UnreadableError
        If the file can't be read as text.
    LimitError
        If it is too large.
    """
    try:
        FILE_BYTES.check(path.stat().st_size)
    except OSError as error:
        raise UnreadableError(f"can't be read: {error.strerror or error}") from None
    return decoded(read_named(path, FILE_BYTES.most))


def tables_of(text: str) -> dict[str, Any]:
    """Tables of a TOML text.

    Raises
    ------
    UnreadableError
        If the text is no TOML.
    LimitError
        If it is too long.
    """
    FILE_BYTES.check(len(text))
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also a whole number of more than 4300 digits
        raise UnreadableError(f"not valid TOML: {one_line(str(error))}") from None


def one_line(text: str) -> str:
    """Message on one line of limited length."""
    whole = " ".join(text.split())
    return whole if len(whole) <= MOST_LINE else whole[: MOST_LINE - 3] + "..."
