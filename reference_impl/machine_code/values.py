"""Values during compilation: typed results of instructions, arrays, structs, and constants of Python.

A constant (float, integer, Boolean, or tuple of them) stays an object of Python until an instruction needs it.
A tuple of values is a tuple of Python.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

from llvmlite import ir

from reference_impl.machine_code.processor import register_width

WIDTH = register_width()
"""Doubles in the widest vector register"""
DOUBLE, WORD, BIT, POINTER = ir.DoubleType(), ir.IntType(64), ir.IntType(1), ir.PointerType()
BYTES = 8
"""Size of every element in memory: a double, an integer or an address"""


class Kind(enum.Enum):
    """Types of scalars, and of one number (`LANES`) or Boolean (`MASK`) in each lane of a vector register."""

    REAL = "float"
    INTEGER = "int"
    BOOLEAN = "bool"
    LANES = "Lanes"
    MASK = "Mask"

    @property
    def type(self) -> ir.Type:
        """LLVM's type."""
        lanes, mask = ir.VectorType(DOUBLE, WIDTH), ir.VectorType(BIT, WIDTH)
        return {Kind.REAL: DOUBLE, Kind.INTEGER: WORD, Kind.BOOLEAN: BIT, Kind.LANES: lanes, Kind.MASK: mask}[self]


class CompilationError(TypeError):
    """Source outside the compiled part of Python; the message names file and line, and the allowed forms."""


@dataclass(frozen=True)
class Scalar:
    """Result of an instruction."""

    kind: Kind
    code: Any
    """LLVM's value"""


@dataclass(frozen=True)
class ArrayValue:
    """Contiguous array: one extent for a vector, two for a matrix."""

    address: Any
    extents: tuple[Any, ...]
    """LLVM's integers, slowest index first"""
    kind: Kind = Kind.REAL
    """Of the elements: real or integer"""


@dataclass(frozen=True)
class StructValue:
    """Struct behind an address, with its fields already loaded."""

    address: Any
    fields: dict[str, Value]


@dataclass(frozen=True)
class StructsValue:
    """Array of addresses of structs of one type."""

    of: type
    address: Any
    count: Any


Constant = float | int | bool
Value = Scalar | ArrayValue | StructValue | StructsValue | Constant | tuple[Any, ...] | None


def is_constant(value: Value) -> bool:
    """Whether a value is a number known during compilation."""
    return isinstance(value, (bool, int, float))


def kind_of(value: Value) -> Kind:
    """Type of a scalar or a constant.

    Raises
    ------
    CompilationError
        If the value is neither.
    """
    if isinstance(value, Scalar):
        return value.kind
    if isinstance(value, bool):
        return Kind.BOOLEAN
    if isinstance(value, int):
        return Kind.INTEGER
    if isinstance(value, float):
        return Kind.REAL
    raise CompilationError(f"a number is needed, given: {type(value).__name__}")
