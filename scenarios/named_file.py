"""Content of a file that a user names: never more than a bound, and never an endless wait.

A name may lead to a device without an end (``/dev/zero``), to a pipe without a writer, or to a regular file whose
reading waits (``/proc/kmsg``). A pipe that ends is as good as a file.
"""

from __future__ import annotations

import os
import select
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

WAIT_S = 30.0
"""For all that a pipe or a device brings, s. A program that runs longer writes its file first."""
CHUNK = 1 << 20
"""Bytes of one read"""
MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
"""Byte-order marks, and the encodings that they tell"""


class UnreadableError(ValueError):
    """A file that can't be read, or is something else; the message does not name it."""


def read_named(path: Path, most: int) -> bytes:
    """Content of a file.

    Parameters
    ----------
    path : Path
    most : int
        Allowed bytes.

    Raises
    ------
    UnreadableError
        If the file can't be read, is larger, or does not end in time.
    """
    deadline, parts, size = time.monotonic() + WAIT_S, list[bytes](), 0
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(handle, "rb", buffering=0) as file:
            while os.name == "nt" or select.select([file], [], [], max(0.0, deadline - time.monotonic()))[0]:
                part = file.read(CHUNK)
                if part == b"":
                    return b"".join(parts)
                parts.append(part or b"")
                size += len(parts[-1])
                if size > most:
                    whole = os.fstat(handle).st_size
                    given = f"{whole}" if whole > most else f"more than {most}"
                    raise UnreadableError(f"{given} bytes given, allowed: at most {most}")
    except (OSError, ValueError) as error:  # also a name with a null character, or a handle beyond those of `select`
        if isinstance(error, UnreadableError):
            raise
        raise UnreadableError(f"can't be read: {getattr(error, 'strerror', None) or error}") from None
    raise UnreadableError(f"has no end after {WAIT_S:.0f} s; write a pipe's content into a file first")


def decoded(content: bytes, fallback: str | None = None) -> str:
    """Text in the encoding of its byte-order mark, else in UTF-8, else in the encoding `fallback`.

    Raises
    ------
    UnreadableError
        If it is no such text.
    """
    encoding = next((encoding for mark, encoding in MARKS.items() if content.startswith(mark)), "utf-8")
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        if fallback is not None and encoding == "utf-8":
            return content.decode(fallback)
        raise UnreadableError(f"can't be read as {encoding.upper()}: {error.reason} at byte {error.start}") from None
