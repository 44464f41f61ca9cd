"""Bytes between processes that run calls: frames, and lists of frames."""

from __future__ import annotations

import struct
from typing import IO, TYPE_CHECKING

from barchain.runs.message import MessageError

if TYPE_CHECKING:
    from collections.abc import Sequence

LENGTH = struct.Struct("<Q")


def write_frame(file: IO[bytes], content: bytes) -> None:
    """Write bytes after their length."""
    file.write(LENGTH.pack(len(content)))
    file.write(content)
    file.flush()


def read_frame(file: IO[bytes]) -> bytes | None:
    """Bytes that :func:`write_frame` wrote; None at the end of the file."""
    head = file.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    (length,) = LENGTH.unpack(head)
    content = file.read(length)
    return content if len(content) == length else None


def joined(parts: Sequence[bytes]) -> bytes:
    """Several bytes as one."""
    return b"".join((LENGTH.pack(len(parts)), *(LENGTH.pack(len(part)) for part in parts), *parts))


def parted(content: bytes) -> list[bytes]:
    """Parts that :func:`joined` joined.

    Raises
    ------
    MessageError
        If the lengths contradict the content.
    """
    size = LENGTH.size
    count = LENGTH.unpack_from(content)[0] if len(content) >= size else -1
    if not 0 <= count <= len(content) // size - 1:
        raise MessageError("its answer is damaged: a wrong number of parts")
    lengths = struct.unpack_from(f"<{count}Q", content, size)
    place = (1 + count) * size
    if place + sum(lengths) != len(content):
        raise MessageError("its answer is damaged: wrong lengths of parts")
    parts = []
    for length in lengths:
        parts.append(content[place : place + length])
        place += length
    return parts
