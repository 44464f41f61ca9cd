"""Unit of compilation: functions that call each other, as one module of LLVM."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from llvmlite import ir

from reference_impl.machine_code import signatures
from reference_impl.machine_code.lowering import Lowering

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from reference_impl.machine_code.functions import Compiled


class Unit:
    """Functions lowered so far, and those still to lower."""

    def __init__(self, name: str, triple: str, layout: str) -> None:
        """Begin an empty unit for a kind of processor."""
        self.module = ir.Module(name)
        self.module.triple, self.module.data_layout = triple, layout
        self.functions: dict[str, ir.Function] = {}
        self.waiting: list[Compiled] = []
        self.constants: dict[tuple[str, int], Any] = {}

    def declared(self, function: Compiled) -> ir.Function:
        """Function of this unit; its body is lowered later."""
        name = function.source.name
        if name not in self.functions:
            made = ir.Function(self.module, signatures.signature(function.source).type, name)
            made.linkage = "internal"
            made.attributes.add("nounwind")
            made.attributes.add("noinline")
            self.functions[name] = made
            self.waiting.append(function)
        return self.functions[name]

    def constant_array(self, name: str, values: Any, make: Callable[[], Any]) -> Any:
        """Constants of the unit, once each."""
        key = name, id(values)
        if key not in self.constants:
            self.constants[key] = make()
        return self.constants[key]

    def lower(self, function: Compiled) -> None:
        """Lower the body of a function."""
        source, made = function.source, self.functions[function.source.name]
        signature = signatures.signature(source)
        builder = ir.IRBuilder(made.append_basic_block("entry"))
        start = made.append_basic_block("start")
        arguments = signatures.received(builder, signature, list(made.args))
        scope = signatures.bound(builder, source, arguments)
        builder.branch(start)
        builder.position_at_end(start)
        inside = Lowering(self, builder, source, scope)
        inside.give = signatures.give(signature, builder)
        inside.body(source.tree.body)
        if not builder.block.is_terminated:
            inside.give(None)


def lowered(name: str, entries: Iterable[Compiled], triple: str, layout: str) -> str:
    """LLVM's representation of functions and everything that they call."""
    unit = Unit(name, triple, layout)
    for function in entries:
        unit.declared(function).linkage = "external"
    while unit.waiting:
        unit.lower(unit.waiting.pop())
    return str(unit.module)
