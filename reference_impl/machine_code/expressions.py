"""Expressions into LLVM's instructions."""

from __future__ import annotations

import ast
import types
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from reference_impl.machine_code.arithmetic import binary, code, common_kind, compared, negated, negative
from reference_impl.machine_code.memory import Slot, constant_array, kept, load, struct_at
from reference_impl.machine_code.values import (
    ArrayValue,
    CompilationError,
    Kind,
    Scalar,
    StructsValue,
    StructValue,
    Value,
    is_constant,
    kind_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from llvmlite import ir

    from reference_impl.machine_code.functions import Compiled, Source


class Declarations(Protocol):
    """Functions and constants of the unit that is lowered."""

    def declared(self, function: Compiled) -> Any:
        """LLVM's function."""

    def constant_array(self, name: str, values: Any, make: Callable[[], ArrayValue]) -> ArrayValue:
        """Constants, made once."""


class Expressions:
    """Values of expressions at the builder's place, in one function's scope."""

    def __init__(self, unit: Declarations, builder: ir.IRBuilder, source: Source, scope: dict[str, Any]) -> None:
        """Prepare; `scope` binds the parameters."""
        self.unit, self.builder, self.source, self.scope = unit, builder, source, scope
        self.loops: list[tuple[ir.Block, ir.Block]] = []
        self.give: Callable[[Value], None]
        """Function that lowers the return of a value"""

    def value(self, node: ast.expr) -> Value:
        """Value of an expression."""
        method: Callable[[Any], Value] | None = getattr(self, f"value_{type(node).__name__}", None)
        if method is None:
            raise CompilationError(f"{ast.unparse(node)}: a {type(node).__name__} is not compiled")
        return method(node)

    def value_Constant(self, node: ast.Constant) -> Value:
        """Number in the source."""
        if not is_constant(node.value):  # type: ignore[arg-type]
            raise CompilationError(f"constant {node.value!r}; allowed: numbers and Booleans")
        return node.value  # type: ignore[return-value]

    def value_Name(self, node: ast.Name) -> Value:
        """Local variable, or constant of the module."""
        if node.id not in self.scope:
            return self.constant(node.id, self.source.names.get(node.id))
        bound = self.scope[node.id]
        slots = isinstance(bound, Slot) or (isinstance(bound, tuple) and any_slot(bound))
        return kept(self.builder, bound) if slots else bound

    def constant(self, name: str, given: Any) -> Value:
        """Object of Python as a constant of the compiled code."""
        if isinstance(given, np.ndarray):
            return self.unit.constant_array(name, given, lambda: constant_array(self.builder, given))
        if isinstance(given, (bool, int, float, tuple)):
            return given
        raise CompilationError(f"{name} is no number, array or tuple of the module")

    def value_Tuple(self, node: ast.Tuple) -> Value:
        """Tuple of values."""
        return tuple(self.value(item) for item in node.elts)

    def value_Attribute(self, node: ast.Attribute) -> Value:
        """Field of a struct, shape of an array, or constant of a module."""
        module = self.source.names.get(getattr(node.value, "id", ""))
        if isinstance(module, types.ModuleType):
            return self.constant(ast.unparse(node), getattr(module, node.attr, None))
        whole = self.value(node.value)
        if isinstance(whole, ArrayValue) and node.attr == "shape":
            return tuple(Scalar(Kind.INTEGER, extent) for extent in whole.extents)
        if isinstance(whole, StructValue) and node.attr in whole.fields:
            return whole.fields[node.attr]
        raise CompilationError(f"{ast.unparse(node)} is neither a field of a struct nor a shape")

    def indices(self, node: ast.expr) -> list[Value]:
        """Indices of a subscript."""
        found = self.value(node)
        return list(found) if isinstance(found, tuple) else [found]

    def value_Subscript(self, node: ast.Subscript) -> Value:
        """Element of an array, row of a matrix, item of a tuple, or one of several structs."""
        whole, indices = self.value(node.value), self.indices(node.slice)
        if isinstance(whole, ArrayValue):
            return load(self.builder, whole, indices)
        if isinstance(whole, StructsValue):
            return struct_at(self.builder, whole, indices[0])
        if isinstance(whole, tuple) and isinstance(indices[0], int):
            return whole[indices[0]]  # type: ignore[no-any-return]
        raise CompilationError(f"{ast.unparse(node)} has no such index during compilation")

    def value_BinOp(self, node: ast.BinOp) -> Value:
        """Result of an operator."""
        return binary(self.builder, node.op, self.value(node.left), self.value(node.right))

    def value_UnaryOp(self, node: ast.UnaryOp) -> Value:
        """Other sign, or other Boolean."""
        operand = self.value(node.operand)
        if isinstance(node.op, ast.USub):
            return negative(self.builder, operand)
        if isinstance(node.op, ast.Not) and kind_of(operand) is Kind.BOOLEAN:
            return (not operand) if isinstance(operand, bool) else negated(self.builder, operand)
        if isinstance(node.op, ast.Invert) and kind_of(operand) is not Kind.BOOLEAN:
            return negated(self.builder, operand)
        raise CompilationError(f"{ast.unparse(node)}: allowed: - of numbers, not of bool, ~ of int and Mask")

    def value_Compare(self, node: ast.Compare) -> Value:
        """Result of one comparison."""
        if len(node.ops) != 1:
            raise CompilationError(f"{ast.unparse(node)}: one comparison at a time")
        return compared(self.builder, node.ops[0], self.value(node.left), self.value(node.comparators[0]))

    def value_BoolOp(self, node: ast.BoolOp) -> Value:
        """``and`` or ``or``; the right side is evaluated only if it decides."""
        found = self.value(node.values[0])
        for other in node.values[1:]:
            found = self.decided(isinstance(node.op, ast.And), found, other)
        return found

    def decided(self, goes_on: bool, first: Value, second: ast.expr) -> Value:
        """``first and second`` if `goes_on`, else ``first or second``."""
        if isinstance(first, bool):
            return self.value(second) if first is goes_on else first
        left = code(self.builder, first, Kind.BOOLEAN)
        begin, more, after = self.builder.block, *(self.builder.append_basic_block(n) for n in ("more", "decided"))
        self.builder.cbranch(left, *((more, after) if goes_on else (after, more)))
        self.builder.position_at_end(more)
        right = code(self.builder, self.value(second), Kind.BOOLEAN)
        last = self.builder.block
        self.builder.branch(after)
        self.builder.position_at_end(after)
        merged = self.builder.phi(Kind.BOOLEAN.type)
        merged.add_incoming(left, begin)
        merged.add_incoming(right, last)
        return Scalar(Kind.BOOLEAN, merged)

    def value_IfExp(self, node: ast.IfExp) -> Value:
        """One of two values; only that one is evaluated."""
        test = self.value(node.test)
        if isinstance(test, bool):
            return self.value(node.body if test else node.orelse)
        blocks = [self.builder.append_basic_block(name) for name in ("yes", "no")]
        after = self.builder.append_basic_block("either")
        self.builder.cbranch(code(self.builder, test, Kind.BOOLEAN), *blocks)
        found = []
        for block, branch in zip(blocks, (node.body, node.orelse), strict=True):
            self.builder.position_at_end(block)
            found.append((self.value(branch), self.builder.block))
        return self.merged(found, after)

    def merged(self, found: list[tuple[Value, ir.Block]], after: ir.Block) -> Value:
        """Value from either of two blocks, whose branches to `after` are made here."""
        (a, first), (b, second) = found
        kinds = common_kinds(a, b)
        leaves = []
        for value, block in found:
            self.builder.position_at_end(block)
            leaves.append([code(self.builder, v, k) for v, k in zip(flat(value), kinds, strict=True)])
            self.builder.branch(after)
        self.builder.position_at_end(after)
        scalars = []
        for kind, x, y in zip(kinds, *leaves, strict=True):
            phi = self.builder.phi(kind.type)
            phi.add_incoming(x, first)
            phi.add_incoming(y, second)
            scalars.append(Scalar(kind, phi))
        return tuple(scalars) if isinstance(a, tuple) else scalars[0]


def any_slot(bound: tuple[Any, ...]) -> bool:
    """Whether a tuple is one of slots."""
    return bool(bound) and (isinstance(bound[0], Slot) or (isinstance(bound[0], tuple) and any_slot(bound[0])))


def flat(value: Value) -> tuple[Value, ...]:
    """Scalars of a value."""
    return value if isinstance(value, tuple) else (value,)


def common_kinds(a: Value, b: Value) -> list[Kind]:
    """Kinds that hold two values, scalar by scalar."""
    found = []
    for x, y in zip(flat(a), flat(b), strict=True):
        found.append(common_kind(x, y))
    return found
