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
    BIT,
    DOUBLE,
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

FLAGS = ("contract",)
REAL_INSTRUCTIONS = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
INTEGER_INSTRUCTIONS = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.BitAnd: "and_"}
FOLDED: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.BitAnd: operator.and_, ast.Pow: operator.pow,
}  # fmt: skip
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
INTRINSICS = {"sqrt": "llvm.sqrt", "exp": "llvm.exp", "cos": "llvm.cos", "sin": "llvm.sin", "fabs": "llvm.fabs"}
LIBRARY = ("hypot", "nextafter")


def code(builder: ir.IRBuilder, value: Value, kind: Kind | None = None) -> Any:
    """LLVM's value of a scalar or a constant, converted from integer to real if `kind` asks for it."""
    given = kind_of(value)
    wanted = kind or given
    if is_constant(value):
        if wanted is not given and not (given is Kind.INTEGER and wanted is Kind.REAL):
            raise CompilationError(f"{given.value} given, {wanted.value} needed")
        return ir.Constant(wanted.type, float(value) if wanted is Kind.REAL else int(value))  # type: ignore[arg-type]
    assert isinstance(value, Scalar)
    if wanted is given:
        return value.code
    if (given, wanted) == (Kind.INTEGER, Kind.REAL):
        return builder.sitofp(value.code, DOUBLE)
    raise CompilationError(f"{given.value} given, {wanted.value} needed")


def binary(builder: ir.IRBuilder, sign: ast.operator, a: Value, b: Value) -> Value:
    """Result of ``a sign b``."""
    kind = type(sign)
    if is_constant(a) and is_constant(b) and kind in FOLDED:
        return FOLDED[kind](a, b)  # type: ignore[no-any-return]
    if kind is ast.Pow:
        return power(builder, a, b)
    if kind is ast.FloorDiv:
        return halved(builder, a, b)
    if kind is not ast.Div and {kind_of(a), kind_of(b)} == {Kind.INTEGER}:
        return Scalar(Kind.INTEGER, integer(builder, kind, a, b))
    if kind not in REAL_INSTRUCTIONS:
        raise CompilationError(f"operator {kind.__name__} of {kind_of(a).value} and {kind_of(b).value}")
    x, y = code(builder, a, Kind.REAL), code(builder, b, Kind.REAL)
    return Scalar(Kind.REAL, getattr(builder, REAL_INSTRUCTIONS[kind])(x, y, flags=FLAGS))


def integer(builder: ir.IRBuilder, kind: type[ast.operator], a: Value, b: Value) -> Any:
    """Integer result; sums that overflow are undefined, which counts of bars never do."""
    x, y = code(builder, a), code(builder, b)
    if kind is ast.BitAnd:
        return builder.and_(x, y)
    return getattr(builder, INTEGER_INSTRUCTIONS[kind])(x, y, flags=("nsw",))


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
    return Scalar(Kind.REAL, builder.fneg(code(builder, value, Kind.REAL), flags=FLAGS))


def compared(builder: ir.IRBuilder, sign: ast.cmpop, a: Value, b: Value) -> Scalar:
    """Result of a comparison."""
    symbol = COMPARISONS.get(type(sign))
    if symbol is None:
        raise CompilationError(f"comparison {type(sign).__name__}; allowed: {', '.join(COMPARISONS.values())}")
    if Kind.REAL not in (kind_of(a), kind_of(b)):
        return Scalar(Kind.TRUTH, builder.icmp_signed(symbol, code(builder, a), code(builder, b)))
    compare = builder.fcmp_unordered if symbol == "!=" else builder.fcmp_ordered
    return Scalar(Kind.TRUTH, compare(symbol, code(builder, a, Kind.REAL), code(builder, b, Kind.REAL)))


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
    """Other truth value."""
    return Scalar(Kind.TRUTH, builder.xor(code(builder, value, Kind.TRUTH), ir.Constant(BIT, 1)))
