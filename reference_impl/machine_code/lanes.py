"""Numbers in the lanes of a vector register: one of `WIDTH` chains in each.

LLVM's own vectorizer does not see through a loop over lanes around a whole evaluation. Here each operator is a vector
instruction by construction: ``+ - * /``, comparisons, and ``& | ~`` of masks. A real beside lanes stands in each of
them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from llvmlite import ir

from reference_impl.machine_code.arithmetic import code
from reference_impl.machine_code.functions import built_in
from reference_impl.machine_code.memory import element
from reference_impl.machine_code.values import BYTES, WIDTH, WORD, ArrayValue, CompilationError, Kind, Scalar

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.machine_code.structs import Matrix, Vector

Lanes = Any
"""A number in each lane; inside compiled code only"""
Mask = Any
"""A Boolean in each lane; inside compiled code only"""
BITS, INTEGERS = ir.IntType(WIDTH), ir.VectorType(WORD, WIDTH)
ROUNDER = 6755399441055744.0  # 1.5·2^52: its addition rounds to an integer, which the sum's last bits are


def lanes(builder: Any, value: Any) -> Any:
    """LLVM's vector of a number."""
    return code(builder, value, Kind.LANES)


def of_each(name: str) -> Callable[[Any, list[Any]], Scalar]:
    """Intrinsic of LLVM for each lane."""

    def make(builder: Any, arguments: list[Any]) -> Scalar:
        kind, full = Kind.LANES.type, f"{name}.v{WIDTH}f64"
        callee = builder.module.globals.get(full) or ir.Function(builder.module, ir.FunctionType(kind, [kind]), full)
        return Scalar(Kind.LANES, builder.call(callee, [lanes(builder, arguments[0])]))

    return make


def chosen_by(sign: str) -> Callable[[Any, list[Any]], Scalar]:
    """First number where its comparison with the second holds, else the second."""

    def make(builder: Any, arguments: list[Any]) -> Scalar:
        a, b = (lanes(builder, x) for x in arguments)
        return Scalar(Kind.LANES, builder.select(builder.fcmp_ordered(sign, a, b), a, b))

    return make


def selected(builder: Any, arguments: list[Any]) -> Scalar:
    """Second argument in flagged lanes, the third in the others."""
    mask, a, b = arguments
    return Scalar(Kind.LANES, builder.select(code(builder, mask, Kind.MASK), lanes(builder, a), lanes(builder, b)))


def place(builder: Any, array: ArrayValue, index: Any) -> Any:
    """Address of a row of a matrix with `WIDTH` columns, or of an element of a vector."""
    if not isinstance(array, ArrayValue) or array.kind is not Kind.REAL:
        raise CompilationError("lanes are read from arrays of reals")
    if len(array.extents) == 1:
        return element(builder, array, [index])
    rows = ArrayValue(array.address, (array.extents[0], ir.Constant(WORD, WIDTH)))
    return element(builder, rows, [index])


def loaded(builder: Any, arguments: list[Any]) -> Scalar:
    """Lanes in memory."""
    where = place(builder, arguments[0], arguments[1])
    return Scalar(Kind.LANES, builder.load(where, typ=Kind.LANES.type, align=BYTES))


def stored(builder: Any, arguments: list[Any]) -> None:
    """Lanes into memory."""
    where = place(builder, arguments[0], arguments[1])
    builder.store(lanes(builder, arguments[2]), where, align=BYTES)


def digit_of(builder: Any, arguments: list[Any]) -> Scalar:
    """Binary digit of an integer in each lane; negative ones are in two's complement."""
    number, position = arguments
    summed = builder.fadd(lanes(builder, number), ir.Constant(Kind.LANES.type, [ROUNDER] * WIDTH))
    shift = ir.Constant(INTEGERS, [position] * WIDTH)
    return Scalar(Kind.MASK, builder.trunc(builder.lshr(builder.bitcast(summed, INTEGERS), shift), Kind.MASK.type))


def packed(builder: Any, arguments: list[Any]) -> Scalar:
    """Flags as the bits of an integer."""
    return Scalar(Kind.INTEGER, builder.zext(builder.bitcast(code(builder, arguments[0], Kind.MASK), BITS), WORD))


def unpacked(builder: Any, arguments: list[Any]) -> Scalar:
    """Bits of an integer as flags."""
    word = code(builder, arguments[0], Kind.INTEGER)
    return Scalar(Kind.MASK, builder.bitcast(builder.trunc(word, BITS), Kind.MASK.type))


@built_in(loaded)
def get(array: Matrix, row: int) -> Lanes:
    """Row of a matrix with a column for each lane."""


@built_in(stored)
def put(array: Matrix, row: int, value: Lanes) -> None:
    """Set a row of a matrix with a column for each lane."""


@built_in(loaded)
def load(array: Vector, start: int) -> Lanes:
    """As many numbers of a vector as there are lanes, from an element on."""


@built_in(stored)
def store(array: Vector, start: int, value: Lanes) -> None:
    """Set as many numbers of a vector as there are lanes, from an element on."""


@built_in(lambda builder, a: Scalar(Kind.LANES, lanes(builder, a[0])))
def equal(number: float) -> Lanes:
    """One number in all lanes."""


@built_in(of_each("llvm.sqrt"))
def root(x: Lanes) -> Lanes:
    """Square root."""


@built_in(of_each("llvm.fabs"))
def size(x: Lanes) -> Lanes:
    """Absolute value."""


@built_in(selected)
def select(mask: Mask, a: Lanes, b: Lanes) -> Lanes:
    """`a` in flagged lanes, `b` in the others."""


@built_in(chosen_by("<"))
def smaller(a: Lanes, b: Lanes) -> Lanes:
    """Smaller of two numbers; the second beside NaN."""


@built_in(chosen_by(">"))
def larger(a: Lanes, b: Lanes) -> Lanes:
    """Larger of two numbers; the second beside NaN."""


@built_in(packed)
def bits(mask: Mask) -> int:
    """Flags as an integer, bit 0 that of lane 0."""
    raise NotImplementedError


@built_in(
    lambda builder, a: Scalar(Kind.MASK, builder.bitcast(builder.trunc(code(builder, a[0]), BITS), Kind.MASK.type))
)
def flags(number: int) -> Mask:
    """Flags from the bits of an integer."""


@built_in(digit_of)
def digit(x: Lanes, position: int) -> Mask:
    """Flags of lanes whose integer-valued numbers, below 2^51 in magnitude, have a binary digit 1 at `position`."""
