"""Decorators of functions that are compiled, and their sources as syntax trees."""

from __future__ import annotations

import ast
import inspect
import textwrap
from dataclasses import dataclass
from functools import cached_property, update_wrapper
from typing import TYPE_CHECKING, Any, TypeVar, cast

from reference_impl.machine_code.values import CompilationError

if TYPE_CHECKING:
    from collections.abc import Callable

F = TypeVar("F", bound="Callable[..., object]")


@dataclass(frozen=True)
class Source:
    """Source of one function."""

    function: Callable[..., object]

    @property
    def name(self) -> str:
        """Name that is unique among all functions."""
        return f"{self.function.__module__}.{self.function.__qualname__}"

    @property
    def names(self) -> dict[str, Any]:
        """Names of the function's module."""
        found: dict[str, Any] = self.function.__globals__
        return found

    @cached_property
    def text(self) -> str:
        """Text of the function."""
        return textwrap.dedent(inspect.getsource(self.function))

    @cached_property
    def tree(self) -> ast.FunctionDef:
        """Syntax tree, with the file's line numbers."""
        tree = ast.parse(self.text)
        ast.increment_lineno(tree, inspect.getsourcelines(self.function)[1] - 1)
        made = tree.body[0]
        assert isinstance(made, ast.FunctionDef)
        return made

    @cached_property
    def parameters(self) -> list[str]:
        """Names of the parameters."""
        return [a.arg for a in self.tree.args.args]

    @cached_property
    def annotations(self) -> list[str]:
        """Annotations of the parameters.

        Raises
        ------
        CompilationError
            If one is missing.
        """
        if any(a.annotation is None for a in self.tree.args.args):
            raise CompilationError(f"{self.name}: each parameter needs an annotation")
        return [ast.unparse(a.annotation) for a in self.tree.args.args if a.annotation is not None]

    @cached_property
    def returns(self) -> str:
        """Annotation of the result."""
        return ast.unparse(self.tree.returns) if self.tree.returns is not None else "None"

    @cached_property
    def assigned(self) -> set[str]:
        """Names that the function assigns."""
        nodes = ast.walk(self.tree)
        return {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


class Compiled:
    """Function of its own in machine code; a call from Python compiles its library, or loads it from disk, first."""

    def __init__(self, function: Callable[..., object]) -> None:
        """Remember the function."""
        self.source = Source(function)
        self.entries: Callable[[Compiled], Callable[..., Any]] | None = None
        """Function of its library that gives the machine code of an entry; None without library"""
        update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        """Call the machine code."""
        return self.entry(*arguments)

    @cached_property
    def entry(self) -> Callable[..., Any]:
        """Machine code as a function of Python.

        Raises
        ------
        CompilationError
            If the function is an entry of no library: only compiled code can call it.
        """
        if self.entries is None:
            raise CompilationError(f"{self.source.name} is an entry of no library: only compiled code can call it")
        return self.entries(self)

    @property
    def address(self) -> int:
        """Address of the machine code."""
        found: int = self.entry.address  # type: ignore[attr-defined]
        return found


@dataclass(frozen=True)
class Inlined:
    """Mark of a function that is lowered into each of its callers."""

    source: Source


@dataclass(frozen=True)
class ThroughAddress:
    """Mark of a call through an address, the first argument; the parameters give the types of the rest."""

    source: Source


@dataclass(frozen=True)
class BuiltIn:
    """Mark of a function that stands for instructions."""

    make: Callable[[Any, list[Any]], Any]
    """From LLVM's builder and the arguments to the value"""


def built_in(make: Callable[[Any, list[Any]], Any]) -> Callable[[F], F]:
    """Let a function, whose body is empty, stand for the instructions that `make` appends."""

    def marked(function: F) -> F:
        function.__lowered__ = BuiltIn(make)  # type: ignore[attr-defined]
        return function

    return marked


def compiled(function: F) -> F:
    """Compile a function as one of its own: for functions that Python calls, or several others."""
    return cast("F", Compiled(function))


def inlined(function: F) -> F:
    """Lower a function into its callers: for small ones."""
    function.__lowered__ = Inlined(Source(function))  # type: ignore[attr-defined]
    return function


def through_address(function: F) -> F:
    """Declare a call of machine code at an address, which is the first argument; the body is empty."""
    function.__lowered__ = ThroughAddress(Source(function))  # type: ignore[attr-defined]
    return function
