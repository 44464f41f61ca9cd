"""Bytes between processes that run calls: frames, lists of frames, and answers that are read without running code."""

from __future__ import annotations

import json
import struct
from typing import IO, TYPE_CHECKING

from barchain.boundary.message import MessageError, plain_number, plain_text
from barchain.execution.call import Answer, CallEnd

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


def packed_answers(answers: Sequence[Answer]) -> bytes:
    """Answers as bytes."""
    heads = [[str(a.end), a.reason, a.seconds] for a in answers]
    return joined([json.dumps(heads).encode("ascii"), *(a.content for a in answers)])


def unpacked_answers(content: object, count: int) -> list[Answer]:
    """Answers to `count` calls, from a worker that is not trusted to send them well.

    Raises
    ------
    MessageError
        If they are no such answers.
    """
    if not isinstance(content, bytes):
        raise MessageError(f"its answer is a {type(content).__name__}, expected bytes")
    head, *contents = parted(content) or [b""]
    try:
        heads = json.loads(head.decode("ascii"))
        found = [Answer(c, CallEnd(end), plain_text(why), seconds_of(s)) for (end, why, s), c in zip(heads, contents)]  # noqa: B905
    except (ValueError, TypeError) as error:
        raise MessageError(f"its answer is damaged: {plain_text(error)}") from None
    if not len(found) == len(heads) == len(contents) == count:
        raise MessageError(f"its answer is to {len(contents)} calls, expected {count}")
    return found


def seconds_of(value: object) -> float:
    """Duration from an answer."""
    return float(plain_number(value) or 0.0)
