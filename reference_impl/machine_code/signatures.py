"""Types of compiled functions in memory: what is passed for each parameter, and returned.

A number is passed as itself, a vector as address and length, a matrix as address, rows and columns, a struct as the
address of its words.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from llvmlite import ir

from reference_impl.machine_code.arithmetic import code
from reference_impl.machine_code.memory import array_kind, keep, loaded_struct, new_slots
from reference_impl.machine_code.structs import DIMENSIONS, Struct, array_words
from reference_impl.machine_code.values import (
    POINTER,
    WORD,
    ArrayValue,
    CompilationError,
    Kind,
    Scalar,
    StructValue,
    Value,
    kind_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.machine_code.functions import Source

KINDS = {kind.value: kind for kind in Kind}
"""By annotation"""
C_TYPES: dict[Kind, Any] = {Kind.REAL: ctypes.c_double, Kind.INTEGER: ctypes.c_int64, Kind.BOOLEAN: ctypes.c_bool}
NO_RESULT = "None"
TUPLE = "tuple["


@dataclass(frozen=True)
class Signature:
    """Types of a function's parameters and result."""

    name: str
    parameters: tuple[tuple[str, str], ...]
    """Name and annotation"""
    returns: str
    names: dict[str, Any]
    """Names of the module, among them the structs"""

    @cached_property
    def results(self) -> tuple[Kind, ...]:
        """Kinds of the results."""
        if self.returns == NO_RESULT:
            return ()
        words = self.returns.removeprefix(TUPLE).removesuffix("]").split(", ")
        return tuple(KINDS[word] for word in words)

    @cached_property
    def type(self) -> ir.FunctionType:
        """LLVM's type."""
        kinds = [kind.type for kind in self.results]
        result = ir.VoidType() if not kinds else kinds[0] if len(kinds) == 1 else ir.LiteralStructType(kinds)
        return ir.FunctionType(result, [t for _, annotation in self.parameters for t in passed_types(annotation)])

    @cached_property
    def c_type(self) -> Any:
        """Prototype for calls from Python, which release the interpreter lock.

        Raises
        ------
        CompilationError
            If the function returns a tuple.
        """
        if len(self.results) > 1:
            raise CompilationError(f"{self.name} returns a tuple: only compiled code can call it")
        given: list[Any] = [t for _, annotation in self.parameters for t in c_types(annotation)]
        return ctypes.CFUNCTYPE(C_TYPES[self.results[0]] if self.results else None, *given)

    def words(self, arguments: tuple[Any, ...]) -> list[Any]:
        """Arguments of a call from Python.

        Raises
        ------
        TypeError
            If there are more or fewer than parameters, or an array is of another type.
        """
        if len(arguments) != len(self.parameters):
            raise TypeError(f"{self.name}: {len(arguments)} arguments, allowed: {len(self.parameters)}")
        found: list[Any] = []
        for (name, annotation), value in zip(self.parameters, arguments, strict=True):
            if annotation in DIMENSIONS:
                found += array_words(value, annotation, self.name, name)
            else:
                found.append(value.address if isinstance(value, Struct) else value)
        return found


def signature(source: Source, skipped: int = 0) -> Signature:
    """Signature of a function by its annotations, without the first `skipped` parameters."""
    parameters = tuple(zip(source.parameters, source.annotations, strict=True))
    return Signature(source.name, parameters[skipped:], source.returns, source.names)


def passed_types(annotation: str) -> list[ir.Type]:
    """LLVM's types of a parameter."""
    if annotation in KINDS:
        return [KINDS[annotation].type]
    return [POINTER, *[WORD] * DIMENSIONS.get(annotation, 0)]


def c_types(annotation: str) -> list[Any]:
    """Types of a parameter in calls from Python."""
    if annotation in KINDS:
        return [C_TYPES[KINDS[annotation]]]
    return [ctypes.c_void_p, *[ctypes.c_int64] * DIMENSIONS.get(annotation, 0)]


def passed(builder: ir.IRBuilder, signature: Signature, arguments: list[Value]) -> list[Any]:
    """LLVM's values of the arguments of a call.

    Raises
    ------
    CompilationError
        If an argument has another type than its parameter.
    """
    if len(arguments) != len(signature.parameters):
        raise CompilationError(f"{signature.name}: {len(arguments)} arguments, allowed: {len(signature.parameters)}")
    words: list[Any] = []
    for (name, annotation), value in zip(signature.parameters, arguments, strict=True):
        if annotation in KINDS:
            words.append(code(builder, value, KINDS[annotation]))
        elif isinstance(value, ArrayValue) and len(value.extents) == DIMENSIONS.get(annotation):
            words += [value.address, *value.extents]
        elif isinstance(value, StructValue):
            words.append(value.address)
        else:
            raise CompilationError(f"{signature.name}: {name} needs {annotation}")
    return words


def returned(signature: Signature, builder: ir.IRBuilder, result: Any) -> Value:
    """Value of a call."""
    kinds = signature.results
    if len(kinds) < 2:
        return Scalar(kinds[0], result) if kinds else None
    return tuple(Scalar(kind, builder.extract_value(result, k)) for k, kind in enumerate(kinds))


def give(signature: Signature, builder: ir.IRBuilder) -> Callable[[Value], None]:
    """Return statement of a function."""

    def give_value(value: Value) -> None:
        if not signature.results:
            builder.ret_void()
            return
        values = value if isinstance(value, tuple) else (value,)
        words = [code(builder, v, kind) for v, kind in zip(values, signature.results, strict=True)]
        if len(words) == 1:
            builder.ret(words[0])
            return
        whole = ir.Constant(signature.type.return_type, ir.Undefined)
        for k, word in enumerate(words):
            whole = builder.insert_value(whole, word, k)
        builder.ret(whole)

    return give_value


def received(builder: ir.IRBuilder, signature: Signature, arguments: list[Any]) -> list[Value]:
    """Values of the parameters inside a function."""
    found: list[Value] = []
    words = iter(arguments)
    for _, annotation in signature.parameters:
        if annotation in KINDS:
            found.append(Scalar(KINDS[annotation], next(words)))
        elif annotation in DIMENSIONS:
            address = next(words)
            extents = tuple(next(words) for _ in range(DIMENSIONS[annotation]))
            found.append(ArrayValue(address, extents, array_kind(annotation)))
        else:
            found.append(loaded_struct(builder, struct_type(signature, annotation), next(words)))
    return found


def struct_type(signature: Signature, annotation: str) -> type[Struct]:
    """Struct that an annotation names.

    Raises
    ------
    CompilationError
        If the module of the function has no such struct when it runs.
    """
    found = signature.names.get(annotation)
    if not (isinstance(found, type) and issubclass(found, Struct)):
        raise CompilationError(f"{signature.name}: {annotation} is no struct imported at run time")
    return found


def bound(builder: ir.IRBuilder, source: Source, arguments: list[Value]) -> dict[str, Any]:
    """Scope of a function; parameters that it assigns get memory of their own."""
    scope: dict[str, Any] = {}
    for name, value in zip(source.parameters, arguments, strict=True):
        if name not in source.assigned:
            scope[name] = value
            continue
        kind_of(value)  # only numbers are assigned
        scope[name] = new_slots(builder, value)
        keep(builder, scope[name], value)
    return scope
