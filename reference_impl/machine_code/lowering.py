"""Statements of a function into LLVM's instructions."""

from __future__ import annotations

import ast
from contextlib import contextmanager
from typing import TYPE_CHECKING

from llvmlite import ir

from reference_impl.machine_code.arithmetic import binary, code
from reference_impl.machine_code.calls import Calls
from reference_impl.machine_code.memory import Slot, Slots, keep, kept, new_slots, store, word
from reference_impl.machine_code.values import (
    WORD,
    ArrayValue,
    CompilationError,
    Kind,
    Scalar,
    StructsValue,
    StructValue,
    Value,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

BY_REFERENCE = ArrayValue, StructValue, StructsValue


class Lowering(Calls):
    """Lowering of one function's body at the builder's place."""

    def body(self, statements: list[ast.stmt]) -> None:
        """Lower statements, up to the one that leaves."""
        for statement in statements:
            if self.builder.block.is_terminated:
                return
            self.statement(statement)

    def statement(self, node: ast.stmt) -> None:
        """Lower one statement."""
        method = getattr(self, f"lower_{type(node).__name__}", None)
        if method is None:
            raise self.error(node, f"a {type(node).__name__} statement is not compiled")
        with self.located(node):
            method(node)

    @contextmanager
    def located(self, node: ast.stmt) -> Iterator[None]:
        """Add the place of a statement to an error within it."""
        try:
            yield
        except CompilationError as error:
            if error.args[0].startswith(self.source.names["__name__"]):
                raise
            raise self.error(node, str(error)) from error

    def error(self, node: ast.AST, text: str) -> CompilationError:
        """Error at the place of a node."""
        return CompilationError(f"{self.source.names['__name__']}, line {getattr(node, 'lineno', 0)}: {text}")

    def lower_Expr(self, node: ast.Expr) -> None:
        """Docstring, or call for its effect."""
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)

    def lower_Return(self, node: ast.Return) -> None:
        """Return a value to the caller."""
        self.give(None if node.value is None else self.value(node.value))

    def lower_Assign(self, node: ast.Assign) -> None:
        """Assign a value to each target."""
        value = self.value(node.value)
        for target in node.targets:
            self.assign(target, value)

    def lower_AugAssign(self, node: ast.AugAssign) -> None:
        """Change a variable or an element in place."""
        there = ast.Name(node.target.id, ast.Load()) if isinstance(node.target, ast.Name) else node.target
        self.assign(node.target, binary(self.builder, node.op, self.value(there), self.value(node.value)))

    def assign(self, target: ast.expr, value: Value) -> None:
        """Assign to a name, an element or a tuple of targets."""
        if isinstance(target, ast.Name):
            self.bind(target.id, value)
        elif isinstance(target, ast.Subscript):
            array = self.value(target.value)
            if not isinstance(array, ArrayValue):
                raise CompilationError("only elements of arrays are assigned")
            store(self.builder, array, self.indices(target.slice), value)
        elif isinstance(target, ast.Tuple) and isinstance(value, tuple) and len(value) == len(target.elts):
            for one, item in zip(target.elts, value, strict=True):
                self.assign(one, item)
        else:
            raise CompilationError(f"{ast.unparse(target)} is no target for this value")

    def bind(self, name: str, value: Value) -> None:
        """Bind a name: arrays and structs once, by reference; numbers to memory of their own."""
        before = self.scope.get(name)
        if isinstance(value, BY_REFERENCE):
            if before is not None:
                raise CompilationError(f"{name} names an array or a struct, and is assigned once only")
            self.scope[name] = value
            return
        if not isinstance(before, (Slot, tuple)):
            self.scope[name] = before = new_slots(self.builder, value)
        keep(self.builder, before, value)

    def lower_If(self, node: ast.If) -> None:
        """Branch; a condition known during compilation leaves one side only."""
        test = self.value(node.test)
        if isinstance(test, bool):
            self.body(node.body if test else node.orelse)
            return
        yes, no, after = (self.builder.append_basic_block(name) for name in ("yes", "no", "after"))
        self.builder.cbranch(code(self.builder, test, Kind.BOOLEAN), yes, no)
        goes_on = False
        for block, statements in ((yes, node.body), (no, node.orelse)):
            self.builder.position_at_end(block)
            self.body(statements)
            goes_on = self.go_to(after) or goes_on
        self.builder.position_at_end(after)
        if not goes_on:
            self.builder.unreachable()

    def go_to(self, block: ir.Block) -> bool:
        """Branch to a block, unless the present one has ended; whether it did."""
        if self.builder.block.is_terminated:
            return False
        self.builder.branch(block)
        return True

    def lower_While(self, node: ast.While) -> None:
        """Loop as long as a condition holds."""
        test, inside, after = (self.builder.append_basic_block(name) for name in ("while", "do", "done"))
        self.builder.branch(test)
        self.builder.position_at_end(test)
        self.builder.cbranch(code(self.builder, self.value(node.test), Kind.BOOLEAN), inside, after)
        self.loop(node.body, inside, test, after)

    def loop(self, statements: list[ast.stmt], inside: ir.Block, again: ir.Block, after: ir.Block) -> None:
        """Body of a loop; then the block after it."""
        self.builder.position_at_end(inside)
        self.loops.append((again, after))
        self.body(statements)
        self.loops.pop()
        self.go_to(again)
        self.builder.position_at_end(after)

    def lower_Break(self, _: ast.Break) -> None:
        """Leave the loop."""
        self.builder.branch(self.loops[-1][1])

    def lower_Continue(self, _: ast.Continue) -> None:
        """Begin the loop's next turn."""
        self.builder.branch(self.loops[-1][0])

    def lower_For(self, node: ast.For) -> None:
        """Loop over a range, or over a tuple known during compilation, whose turns are written out."""
        ranged = isinstance(node.iter, ast.Call) and getattr(node.iter.func, "id", "") == "range"
        if ranged:
            self.count(node)
            return
        items = self.value(node.iter)
        if not isinstance(items, tuple):
            raise CompilationError("a loop runs over a range or a tuple")
        for item in items:
            before = dict(self.scope)
            self.assign(node.target, item)
            self.body(node.body)
            self.scope = {name: v for name, v in self.scope.items() if name in before or isinstance(v, (Slot, tuple))}

    def count(self, node: ast.For) -> None:
        """Loop over ``range(stop)`` or ``range(start, stop)``."""
        assert isinstance(node.iter, ast.Call)
        values = [self.value(a) for a in node.iter.args]
        by = values.pop() if len(values) == 3 else 1
        if not isinstance(by, int) or by == 0 or node.orelse:
            raise CompilationError("a loop counts in steps known during compilation, other than 0, and has no else")
        bounds = [word(self.builder, v) for v in values]
        start, stop = bounds if len(bounds) == 2 else (ir.Constant(WORD, 0), bounds[0])
        counter = new_slots(self.builder, Scalar(Kind.INTEGER, start))
        keep(self.builder, counter, Scalar(Kind.INTEGER, start))
        test, inside, step, after = (self.builder.append_basic_block(name) for name in ("for", "do", "next", "done"))
        self.builder.branch(test)
        self.builder.position_at_end(test)
        now = kept(self.builder, counter)
        inwards = self.builder.icmp_signed("<" if by > 0 else ">", word(self.builder, now), stop)
        self.builder.cbranch(inwards, inside, after)
        self.builder.position_at_end(inside)
        self.assign(node.target, now)
        self.loop(node.body, self.builder.block, step, step_after(self.builder, counter, by, step, test, after))


def step_after(
    builder: ir.IRBuilder, counter: Slots, by: int, step: ir.Block, test: ir.Block, after: ir.Block
) -> ir.Block:
    """Fill the block that counts on, and return the block after the loop."""
    with builder.goto_block(step):
        keep(builder, counter, binary(builder, ast.Add(), kept(builder, counter), by))
        builder.branch(test)
    return after
