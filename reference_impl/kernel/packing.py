"""Structs: named groups of arrays and numbers that Python fills and the kernel reads by address.

A struct is a frozen dataclass whose annotations are ``float``, ``int``, ``Vector``, ``Matrix``, ``Struct`` for a struct
of any type, or a tuple of structs ``tuple[R, ...]``. In memory it is a row of 64-bit words, as the C structures of
``kernel.h`` have them: a number is one word, a vector its address and length, a matrix its address, rows and columns, a
struct its address, a tuple of structs the address of a row of addresses, and their number.
"""

from __future__ import annotations

import ctypes
import dataclasses
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""(n,) numbers, contiguous: doubles, or all arrays of a call of the wide type, which type checkers take for doubles"""
Matrix = NDArray[np.float64]
"""(rows, columns) numbers, contiguous"""
Number = type[np.float64]
DOUBLE: Number = np.float64
WIDE: Number = np.longdouble  # type: ignore[assignment]
DIMENSIONS = {"Vector": 1, "Matrix": 2}
ANY_STRUCT = "Struct"


@dataclass(frozen=True)
class Struct:
    """Base of all structs: packs its fields when it is made.

    Raises
    ------
    TypeError
        If an array has other dimensions or elements than its annotation says, or gaps in memory.
    """

    def __post_init__(self) -> None:
        """Pack the fields into words."""
        words: list[int] = []
        kept: list[Any] = []
        for name, annotation in field_types(type(self)):
            value = getattr(self, name)
            if annotation in DIMENSIONS:
                words += array_words(value, annotation, type(self).__name__, name)
            elif annotation == "float":
                words.append(int(np.float64(value).view(np.int64)))
            elif annotation == "int":
                words.append(int(value))
            elif annotation == ANY_STRUCT:
                words.append(value.address)
            else:
                addresses = np.array([item.address for item in value], dtype=np.int64)
                kept.append(addresses)
                words += [addresses.ctypes.data, len(value)]
        packed = np.array(words, dtype=np.int64)
        object.__setattr__(self, "_memory", (packed, *kept))
        object.__setattr__(self, "_address", packed.ctypes.data)

    @property
    def address(self) -> int:
        """Address of the words; valid as long as the struct lives."""
        found: int = self.__dict__["_address"]
        return found


def array_words(array: NDArray[Any], annotation: str, owner: str, name: str) -> tuple[int, ...]:
    """Address and extents of an array, a field or parameter `name` of `owner`.

    Raises
    ------
    TypeError
        If the array is not a contiguous one of numbers of the kernel.
    """
    dimensions = DIMENSIONS[annotation]
    if array.ndim != dimensions or array.dtype.type not in (DOUBLE, WIDE) or not array.flags.c_contiguous:
        raise TypeError(
            f"{owner}.{name}: {array.ndim} dimensions of {array.dtype}, contiguous {array.flags.c_contiguous}; "
            f"allowed: {dimensions} dimensions of contiguous float64"
        )
    return address_of(array), *array.shape


def address_of(array: NDArray[Any]) -> int:
    """Address of an array's first element: the buffer gives it in a quarter of the time of ``array.ctypes``."""
    buffer: Any = array
    try:
        return ctypes.addressof(ctypes.c_char.from_buffer(buffer))
    except (TypeError, ValueError):  # an array that can't be written, or an empty one, gives no buffer
        return array.ctypes.data


def field_types(struct: Any) -> tuple[tuple[str, str], ...]:
    """Name and annotation of each field, in the order of the words."""
    return known_field_types(struct)


@cache
def known_field_types(struct: Any) -> tuple[tuple[str, str], ...]:
    """:func:`field_types`, found once for each struct."""
    return tuple((f.name, str(f.type)) for f in dataclasses.fields(struct))


def word_count(struct: type[Struct]) -> int:
    """64-bit words of a struct in memory."""
    counts = {"float": 1, "int": 1, "Vector": 2, "Matrix": 3, ANY_STRUCT: 1}  # 2: a tuple of structs
    return sum(counts.get(annotation, 2) for _, annotation in field_types(struct))
