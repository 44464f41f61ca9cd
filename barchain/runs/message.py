"""Wire format of answers: JSON text and float64 arrays, read without running code."""

from __future__ import annotations

import io
import json
import math
import zipfile
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import DTypeLike, NDArray

    from adapters.trajectory import Array

HEADER = "header"
TEXT_LENGTH = 500
"""Characters of a text that are kept"""
MAX_INFO = 50
"""Entries of `info` that are kept"""


class MessageError(ValueError):
    """An answer that is not in the wire format; the message names the part and its type."""


class DeclarationError(TypeError):
    """A declaration of an engine that is missing, of a wrong type or out of range; the message names it."""


def message_bytes(header: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Bytes of a message; numbers of the header may be NaN or infinite."""
    text = np.frombuffer(json.dumps(header, default=plain_scalar).encode("ascii"), np.uint8)
    sink = io.BytesIO()
    np.savez(sink, **{HEADER: text}, **arrays)  # type: ignore[arg-type]
    return sink.getvalue()


def plain_scalar(value: object) -> object:
    """Python number of a NumPy scalar with the same value and the same text.

    Raises
    ------
    TypeError
        For anything else.
    """
    if isinstance(value, (np.float64, np.integer, np.bool_)):
        return value.item()
    raise TypeError(f"a message holds no {type(value).__name__}")


def need_finite(value: object, place: str = "its answer") -> None:
    """Check that no number in nested values is NaN or infinite; the message names its place."""
    if isinstance(value, float) and not math.isfinite(value):
        raise MessageError(f"{place} is {value}, expected a finite number")
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, entry in inside:
        need_finite(entry, plain_text(key) if isinstance(value, dict) else f"{place}[{key}]")


def read_message(content: bytes, dtype: DTypeLike = np.float64) -> tuple[dict[str, Any], dict[str, Array]]:
    """Header and arrays of an answer.

    Parameters
    ----------
    content : bytes
        From :func:`message_bytes`.
    dtype : dtype
        Type of all arrays.

    Raises
    ------
    MessageError
        If it is damaged, holds other types than text and float64, or its header is no JSON object.
    """
    try:
        need_as_written(content)
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        header = json.loads(found.pop(HEADER).tobytes().decode("ascii"))
    except Exception as error:  # bytes that an engine wrote itself may raise anything: MemoryError, zlib.error, ...
        raise MessageError(f"its answer is damaged: {plain_text(error)}") from None
    if not isinstance(header, dict):
        raise MessageError(f"its answer is a {type(header).__name__}, expected an object")
    for name, values in found.items():
        if values.dtype != dtype:
            raise MessageError(f"{plain_text(name)} holds {values.dtype}, expected {np.dtype(dtype)}")
    return header, found


def need_as_written(content: bytes) -> None:
    """Check that an answer holds no more bytes than it has: ours are not compressed, and a forged one may inflate.

    Raises
    ------
    MessageError
        If it would.
    """
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        size = sum(entry.file_size for entry in file.infolist())
        if size > len(content) or any(entry.compress_type != zipfile.ZIP_STORED for entry in file.infolist()):
            raise MessageError(f"{size} bytes in an archive of {len(content)}, expected no compression")


def plain_text(value: object, length: int = TEXT_LENGTH) -> str:
    """One printable line of text: control characters, lone surrogates and bidirectional marks become spaces."""
    try:
        text = str(value)
    except Exception as error:
        text = f"a {type(value).__name__} whose text raises {type(error).__name__}"
    printable = "".join(c if c.isprintable() else " " for c in text[: 4 * length])
    return " ".join(printable.split())[:length]


def plain_number(value: object) -> float | int | None:
    """Finite Python number; None of anything else. A NumPy scalar is converted."""
    if isinstance(value, np.generic) and value.ndim == 0:
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        return value if math.isfinite(value) else None
    except OverflowError:
        return None


def plain_info(info: object) -> dict[str, float | int | str]:
    """Counters and words of an engine as JSON values.

    Raises
    ------
    MessageError
        If `info` is no mapping of names to finite numbers and text.
    """
    if not isinstance(info, dict):
        raise MessageError(f"info is a {type(info).__name__}, expected a dict")
    if len(info) > MAX_INFO:
        raise MessageError(f"info has {len(info)} entries, at most {MAX_INFO} are allowed")
    found: dict[str, float | int | str] = {}
    for key, value in info.items():
        number = plain_number(value)
        if not isinstance(key, str) or (number is None and not isinstance(value, str)):
            said = f"a {type(value).__name__}" if plain_number(value) is None and not is_number(value) else repr(value)
            raise MessageError(f"info[{plain_text(key, 40)!r}] is {said}, expected a finite number or text")
        found[plain_text(key, 60)] = plain_text(value) if number is None else number
    return found


def is_number(value: object) -> bool:
    """Whether a value is a number, finite or not."""
    return isinstance(value, (int, float, np.number))
