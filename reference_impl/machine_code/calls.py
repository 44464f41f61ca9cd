"""Calls: of built-in and mathematical functions, of compiled functions, of inlined ones, and through addresses."""

from __future__ import annotations

import ast
import types
from abc import abstractmethod
from typing import TYPE_CHECKING, Any

from reference_impl.machine_code import arithmetic, signatures
from reference_impl.machine_code.arithmetic import code
from reference_impl.machine_code.expressions import Expressions
from reference_impl.machine_code.functions import BuiltIn, Compiled, Inlined, ThroughAddress
from reference_impl.machine_code.memory import keep, kept, new_slots
from reference_impl.machine_code.values import (
    ArrayValue,
    CompilationError,
    Kind,
    Scalar,
    StructsValue,
    Value,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from llvmlite import ir

    from reference_impl.machine_code.functions import Source


def length(value: Value) -> Value:
    """Length of a vector, number of rows of a matrix, or number of structs or items."""
    if isinstance(value, ArrayValue):
        return Scalar(Kind.INTEGER, value.extents[0])
    if isinstance(value, StructsValue):
        return Scalar(Kind.INTEGER, value.count)
    if isinstance(value, tuple):
        return len(value)
    raise CompilationError("len() of a value without length")


def absolute(builder: ir.IRBuilder, value: Value) -> Value:
    """Magnitude of a real."""
    return arithmetic.function(builder, "llvm.fabs", code(builder, value, Kind.REAL))


BUILT_IN: dict[str, Callable[[ir.IRBuilder, list[Value]], Value]] = {
    "len": lambda _, a: length(a[0]),
    "abs": lambda builder, a: absolute(builder, a[0]),
    "min": lambda builder, a: arithmetic.extreme(builder, "<", a),
    "max": lambda builder, a: arithmetic.extreme(builder, ">", a),
    "int": lambda builder, a: arithmetic.rounded_to_integer(builder, a[0]),
    "float": lambda builder, a: Scalar(Kind.REAL, code(builder, a[0], Kind.REAL)),
    "bool": lambda builder, a: Scalar(Kind.BOOLEAN, code(builder, a[0], Kind.BOOLEAN)),
    "isfinite": lambda builder, a: arithmetic.finite(builder, a[0]),
}


class Calls(Expressions):
    """Expressions with calls."""

    @abstractmethod
    def body(self, statements: list[ast.stmt]) -> None:
        """Lower the statements of an inlined function."""

    def value_Call(self, node: ast.Call) -> Value:
        """Result of a call."""
        if node.keywords:
            raise CompilationError(f"{ast.unparse(node)}: arguments are given in order, without names")
        name, callee = self.callee(node.func)
        return self.called(name, callee, [self.value(a) for a in node.args])

    def callee(self, node: ast.expr) -> tuple[str, Any]:
        """Name and object of a called function; None for built-in functions."""
        if isinstance(node, ast.Name):
            return node.id, self.source.names.get(node.id)
        module = self.source.names.get(getattr(getattr(node, "value", None), "id", ""))
        if isinstance(node, ast.Attribute) and isinstance(module, types.ModuleType):
            return node.attr, getattr(module, node.attr, None)
        raise CompilationError(f"{ast.unparse(node)} can't be called")

    def called(self, name: str, callee: Any, arguments: list[Value]) -> Value:
        """Result of a call of an object of Python.

        Raises
        ------
        CompilationError
            If the function is none of those that compiled code calls.
        """
        lowered = getattr(callee, "__lowered__", None)
        if isinstance(callee, Compiled):
            return self.call_compiled(callee, arguments)
        if isinstance(lowered, Inlined):
            return self.inline(lowered.source, arguments)
        if isinstance(lowered, ThroughAddress):
            return self.call_through_address(lowered.source, arguments)
        if isinstance(lowered, BuiltIn):
            return lowered.make(self.builder, arguments)  # type: ignore[no-any-return]
        if name in BUILT_IN:
            return BUILT_IN[name](self.builder, arguments)
        if name in arithmetic.INTRINSICS or name in arithmetic.LIBRARY:
            reals = [code(self.builder, a, Kind.REAL) for a in arguments]
            return arithmetic.function(self.builder, arithmetic.INTRINSICS.get(name, name), *reals)
        allowed = ", ".join([*BUILT_IN, *arithmetic.INTRINSICS, *arithmetic.LIBRARY])
        raise CompilationError(f"{name}() is not compiled; allowed: compiled and inlined functions, {allowed}")

    def call_compiled(self, callee: Compiled, arguments: list[Value]) -> Value:
        """Call a function of the same unit."""
        signature = signatures.signature(callee.source)
        words = signatures.passed(self.builder, signature, arguments)
        return signatures.returned(signature, self.builder, self.builder.call(self.unit.declared(callee), words))

    def call_through_address(self, source: Source, arguments: list[Value]) -> Value:
        """Call the function at an address, the first argument."""
        signature = signatures.signature(source, skipped=1)
        address = code(self.builder, arguments[0], Kind.INTEGER)
        words = signatures.passed(self.builder, signature, arguments[1:])
        target = self.builder.inttoptr(address, signature.type.as_pointer())
        return signatures.returned(signature, self.builder, self.builder.call(target, words))

    def inline(self, source: Source, arguments: list[Value]) -> Value:
        """Lower the body of a function at the place of its call."""
        if len(arguments) != len(source.parameters):
            raise CompilationError(f"{source.name}: {len(arguments)} arguments, allowed: {len(source.parameters)}")
        inner = type(self)(self.unit, self.builder, source, signatures.bound(self.builder, source, arguments))
        result = Result(self.builder)
        inner.give = result.give
        inner.body(source.tree.body)
        return result.value()


class Result:
    """Value that an inlined function returns, from any of its returns."""

    def __init__(self, builder: ir.IRBuilder) -> None:
        """Prepare the block after the call."""
        self.builder = builder
        self.after = builder.append_basic_block("returned")
        self.slots: Any = None

    def give(self, value: Value) -> None:
        """Keep a value and leave the function."""
        if value is not None:
            if self.slots is None:
                self.slots = new_slots(self.builder, value)
            keep(self.builder, self.slots, value)
        self.builder.branch(self.after)

    def value(self) -> Value:
        """Value after the call."""
        if not self.builder.block.is_terminated:
            self.builder.branch(self.after)
        self.builder.position_at_end(self.after)
        return None if self.slots is None else kept(self.builder, self.slots)
