"""Instructions for arithmetic, comparisons and mathematical functions.

Of the floating-point liberties only contraction is allowed: a product and a sum become one operation with one
rounding. Sums keep their order, so that code free of cancellation stays free of cancellation. Comparisons with NaN are
false, ``!=`` excepted, as in Python; ``min`` and ``max`` return their first argument where a comparison is false.
"""

from __future__ import annotations

import ast
import math
import operator
from typing import TYPE_CHECKING, Any

from llvmlite import ir

from reference_impl.machine_code.values import (
    DOUBLE,
    WIDTH,
    WORD,
    CompilationError,
    Kind,
    Scalar,
    Value,
    is_constant,
    kind_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable

INDEX = ir.IntType(32)
FLAGS = ("contract",)
REAL_INSTRUCTIONS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
SUMS = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
BITWISE = {ast.BitAnd: "and_", ast.BitOr: "or_", ast.BitXor: "xor", ast.LShift: "shl", ast.RShift: "ashr"}
FOLDED: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Pow: operator.pow, ast.BitAnd: operator.and_, ast.BitOr: operator.or_,
    ast.BitXor: operator.xor, ast.LShift: operator.lshift, ast.RShift: operator.rshift,
}  # fmt: skip
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
INTRINSICS = {"sqrt": "llvm.sqrt", "exp": "llvm.exp", "cos": "llvm.cos", "sin": "llvm.sin", "fabs": "llvm.fabs"}
LIBRARY = ("hypot", "nextafter")


def code(builder: ir.IRBuilder, value: Value, kind: Kind | None = None) -> Any:
    """LLVM's value of a scalar or a constant, converted from integer to real if `kind` asks for it."""
    given = kind_of(value)
    wanted = kind or given
    if is_constant(value):
        if wanted is Kind.LANES and given is not Kind.BOOLEAN:
            return ir.Constant(wanted.type, [float(value)] * WIDTH)  # type: ignore[arg-type]
        if wanted is not given and not (given is Kind.INTEGER and wanted is Kind.REAL):
            raise CompilationError(f"{given.value} given, {wanted.value} needed")
        return ir.Constant(wanted.type, float(value) if wanted is Kind.REAL else int(value))  # type: ignore[arg-type]
    assert isinstance(value, Scalar)
    if wanted is given:
        return value.code
    if (given, wanted) == (Kind.INTEGER, Kind.REAL):
        return builder.sitofp(value.code, DOUBLE)
    if wanted is Kind.LANES and given in (Kind.INTEGER, Kind.REAL):
        return in_all_lanes(builder, code(builder, value, Kind.REAL))
    raise CompilationError(f"{given.value} given, {wanted.value} needed")


def in_all_lanes(builder: ir.IRBuilder, real: Any) -> Any:
    """One real in all lanes."""
    none = ir.Constant(Kind.LANES.type, ir.Undefined)
    first = builder.insert_element(none, real, ir.Constant(INDEX, 0))
    return builder.shuffle_vector(first, none, ir.Constant(ir.VectorType(INDEX, WIDTH), [0] * WIDTH))


def common_kind(a: Value, b: Value) -> Kind:
    """Kind in which two numbers are added or compared."""
    kinds = {kind_of(a), kind_of(b)}
    if Kind.LANES in kinds:
        return Kind.LANES
    return kinds.pop() if len(kinds) == 1 else Kind.REAL


def binary(builder: ir.IRBuilder, sign: ast.operator, a: Value, b: Value) -> Value:
    """Result of ``a sign b``."""
    kind = type(sign)
    if is_constant(a) and is_constant(b) and kind in FOLDED:
        return FOLDED[kind](a, b)  # type: ignore[no-any-return]
    if kind is ast.Pow:
        return power(builder, a, b)
    if kind is ast.FloorDiv:
        return halved(builder, a, b)
    common = common_kind(a, b)
    if kind in BITWISE and kind_of(a) is kind_of(b) and common in (Kind.INTEGER, Kind.MASK):
        return Scalar(common, getattr(builder, BITWISE[kind])(code(builder, a), code(builder, b)))
    if kind in SUMS and common is Kind.INTEGER:  # an overflow is undefined; counts of bars never overflow
        return Scalar(common, getattr(builder, SUMS[kind])(code(builder, a), code(builder, b), flags=("nsw",)))
    if kind not in REAL_INSTRUCTIONS or common is Kind.MASK:
        raise CompilationError(f"operator {kind.__name__} of {kind_of(a).value} and {kind_of(b).value}")
    if common is Kind.INTEGER:  # a quotient is real
        common = Kind.REAL
    x, y = code(builder, a, common), code(builder, b, common)
    return Scalar(common, getattr(builder, REAL_INSTRUCTIONS[kind])(x, y, flags=FLAGS))


def power(builder: ir.IRBuilder, a: Value, b: Value) -> Value:
    """Square, or the library's power."""
    if b == 2:
        return binary(builder, ast.Mult(), a, a)
    return function(builder, "llvm.pow", code(builder, a, Kind.REAL), code(builder, b, Kind.REAL))


def halved(builder: ir.IRBuilder, a: Value, b: Value) -> Value:
    """Half of an integer, rounded down."""
    if b != 2:
        raise CompilationError("operator // by another divisor than 2")
    return Scalar(Kind.INTEGER, builder.ashr(code(builder, a, Kind.INTEGER), ir.Constant(WORD, 1)))


def function(builder: ir.IRBuilder, name: str, *arguments: Any) -> Scalar:
    """Call of a function of reals: an intrinsic of LLVM, or a function of the C library."""
    module = builder.module
    if name.startswith("llvm."):
        callee = module.declare_intrinsic(name, [DOUBLE])
        if name == "llvm.pow":
            callee = module.declare_intrinsic(name, [DOUBLE], ir.FunctionType(DOUBLE, [DOUBLE, DOUBLE]))
    else:
        callee = module.globals.get(name) or ir.Function(
            module, ir.FunctionType(DOUBLE, [DOUBLE] * len(arguments)), name
        )
    return Scalar(Kind.REAL, builder.call(callee, arguments))


def negative(builder: ir.IRBuilder, value: Value) -> Value:
    """Value with the other sign."""
    if is_constant(value):
        return -value  # type: ignore[operator]
    if kind_of(value) is Kind.INTEGER:
        return Scalar(Kind.INTEGER, builder.neg(code(builder, value)))
    return Scalar(kind_of(value), builder.fneg(code(builder, value), flags=FLAGS))


def compared(builder: ir.IRBuilder, sign: ast.cmpop, a: Value, b: Value) -> Scalar:
    """Result of a comparison."""
    symbol = COMPARISONS.get(type(sign))
    if symbol is None:
        raise CompilationError(f"comparison {type(sign).__name__}; allowed: {', '.join(COMPARISONS.values())}")
    common = common_kind(a, b)
    if common not in (Kind.REAL, Kind.LANES):
        return Scalar(Kind.BOOLEAN, builder.icmp_signed(symbol, code(builder, a), code(builder, b)))
    compare = builder.fcmp_unordered if symbol == "!=" else builder.fcmp_ordered
    result = Kind.MASK if common is Kind.LANES else Kind.BOOLEAN
    return Scalar(result, compare(symbol, code(builder, a, common), code(builder, b, common)))


def extreme(builder: ir.IRBuilder, symbol: str, values: list[Value]) -> Value:
    """Smallest (``<``) or largest (``>``) of several values."""
    kind = Kind.REAL if any(kind_of(v) is Kind.REAL for v in values) else Kind.INTEGER
    found = code(builder, values[0], kind)
    compare = builder.fcmp_ordered if kind is Kind.REAL else builder.icmp_signed
    for value in values[1:]:
        other = code(builder, value, kind)
        found = builder.select(compare(symbol, other, found), other, found)
    return Scalar(kind, found)


def rounded_to_integer(builder: ir.IRBuilder, value: Value) -> Value:
    """Integer part of a real."""
    if kind_of(value) is not Kind.REAL:
        return value
    return Scalar(Kind.INTEGER, builder.fptosi(code(builder, value), WORD))


def finite(builder: ir.IRBuilder, value: Value) -> Value:
    """Whether a real is finite."""
    size = function(builder, "llvm.fabs", code(builder, value, Kind.REAL))
    return compared(builder, ast.Lt(), size, math.inf)


def negated(builder: ir.IRBuilder, value: Value) -> Scalar:
    """Other Boolean, or the other bits of an integer or a mask."""
    if kind_of(value) not in (Kind.BOOLEAN, Kind.INTEGER, Kind.MASK):
        raise CompilationError(f"{kind_of(value).value} given; allowed after not and ~: bool, int, Mask")
    return Scalar(kind_of(value), builder.not_(code(builder, value)))
