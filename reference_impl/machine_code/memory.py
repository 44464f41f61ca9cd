"""Instructions for arrays and structs in memory, and for local variables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from llvmlite import ir

from reference_impl.machine_code.arithmetic import code
from reference_impl.machine_code.structs import ANY_STRUCT, DIMENSIONS, ELEMENTS, Struct, field_types, item_type
from reference_impl.machine_code.values import (
    BYTES,
    DOUBLE,
    POINTER,
    WORD,
    ArrayValue,
    CompilationError,
    Kind,
    Scalar,
    StructsValue,
    StructValue,
    Value,
    kind_of,
)


@dataclass(frozen=True)
class Slot:
    """Memory of a local variable; LLVM turns it into registers."""

    kind: Kind
    place: Any


Slots = Slot | tuple[Any, ...]
"""Slot of a scalar, or slots of a tuple"""


def new_slots(builder: ir.IRBuilder, value: Value) -> Slots:
    """Memory for a value of the same type, allocated at the start of the function."""
    if isinstance(value, tuple):
        return tuple(new_slots(builder, item) for item in value)
    kind = kind_of(value)
    with builder.goto_entry_block():
        return Slot(kind, builder.alloca(kind.type))


def keep(builder: ir.IRBuilder, slots: Slots, value: Value) -> None:
    """Store a value.

    Raises
    ------
    CompilationError
        If the value has another type than the one stored first.
    """
    if isinstance(slots, Slot):
        builder.store(code(builder, value, slots.kind), slots.place)
        return
    if not isinstance(value, tuple) or len(value) != len(slots):
        raise CompilationError(f"a tuple of {len(slots)} values is needed")
    for slot, item in zip(slots, value, strict=True):
        keep(builder, slot, item)


def kept(builder: ir.IRBuilder, slots: Slots) -> Value:
    """Value in a slot."""
    if isinstance(slots, Slot):
        return Scalar(slots.kind, builder.load(slots.place, typ=slots.kind.type))
    return tuple(kept(builder, slot) for slot in slots)


def word(builder: ir.IRBuilder, value: Value) -> Any:
    """LLVM's integer of an index."""
    return code(builder, value, Kind.INTEGER)


def element(builder: ir.IRBuilder, array: ArrayValue, indices: list[Value]) -> Any:
    """Address of an element, or of the start of a row; indices count from 0 and are not checked."""
    offset = word(builder, indices[0])
    for extent, index in zip(array.extents[1:], indices[1:], strict=False):
        offset = builder.add(builder.mul(offset, extent, flags=("nsw",)), word(builder, index), flags=("nsw",))
    for extent in array.extents[len(indices) :]:
        offset = builder.mul(offset, extent, flags=("nsw",))
    return builder.gep(array.address, [offset], inbounds=True, source_etype=array.kind.type)


def load(builder: ir.IRBuilder, array: ArrayValue, indices: list[Value]) -> Value:
    """Element of an array, or row of a matrix."""
    place = element(builder, array, indices)
    if len(indices) < len(array.extents):
        return ArrayValue(place, array.extents[len(indices) :], array.kind)
    return Scalar(array.kind, builder.load(place, typ=array.kind.type, align=BYTES))


def store(builder: ir.IRBuilder, array: ArrayValue, indices: list[Value], value: Value) -> None:
    """Set an element."""
    if len(indices) != len(array.extents):
        raise CompilationError(f"{len(array.extents)} indices are needed, given: {len(indices)}")
    builder.store(code(builder, value, array.kind), element(builder, array, indices), align=BYTES)


def loaded_struct(builder: ir.IRBuilder, of: type[Struct], address: Any) -> StructValue:
    """Struct at an address, with all of its fields loaded; unused ones cost nothing."""
    at = 0

    def next_word(kind: Any) -> Any:
        nonlocal at
        place = builder.gep(address, [ir.Constant(WORD, at)], inbounds=True, source_etype=WORD)
        at += 1
        return builder.load(place, typ=kind, align=BYTES)

    fields: dict[str, Value] = {}
    for name, annotation in field_types(of):
        if annotation == "float":
            fields[name] = Scalar(Kind.REAL, next_word(DOUBLE))
        elif annotation == "int":
            fields[name] = Scalar(Kind.INTEGER, next_word(WORD))
        elif annotation in DIMENSIONS:
            start = next_word(POINTER)
            extents = tuple(next_word(WORD) for _ in range(DIMENSIONS[annotation]))
            fields[name] = ArrayValue(start, extents, array_kind(annotation))
        elif annotation == ANY_STRUCT:
            fields[name] = StructValue(next_word(POINTER), {})
        else:
            fields[name] = StructsValue(item_type(of, annotation), next_word(POINTER), next_word(WORD))
    return StructValue(address, fields)


def struct_at(builder: ir.IRBuilder, structs: StructsValue, index: Value) -> StructValue:
    """One of several structs."""
    place = builder.gep(structs.address, [word(builder, index)], inbounds=True, source_etype=POINTER)
    return loaded_struct(builder, structs.of, builder.load(place, typ=POINTER, align=BYTES))


def constant_array(builder: ir.IRBuilder, values: np.ndarray[Any, Any]) -> ArrayValue:
    """Array of constants in the compiled code: reals or integers."""
    kind = Kind.INTEGER if values.dtype.kind == "i" else Kind.REAL
    flat = ir.ArrayType(kind.type, values.size)
    name = builder.module.get_unique_name("constants")
    table = ir.GlobalVariable(builder.module, flat, name)
    table.initializer = ir.Constant(flat, values.ravel().tolist())
    table.global_constant, table.linkage = True, "internal"
    return ArrayValue(table, tuple(ir.Constant(WORD, n) for n in values.shape), kind)


def array_kind(annotation: str) -> Kind:
    """Kind of the elements of an array."""
    return Kind.INTEGER if ELEMENTS[annotation] == np.int64 else Kind.REAL
