"""Sphinx roles in docstrings and comments, resolved against the product's source text."""

from __future__ import annotations

import ast
import functools
import re
from typing import TYPE_CHECKING

from tests.structure.product import PACKAGES, bound, module_name, python_files, tree

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

ROLE = re.compile(r":(?:mod|func|class|meth|data|attr|exc|const|obj):`~?\.?([^`<>]+)`")


@functools.cache
def modules() -> dict[str, Path]:
    """Every module of the product, and of its tests, by its dotted name."""
    return {module_name(path): path for path in python_files(*PACKAGES, "tests", "benchmarks")}


def roles(path: Path) -> Iterator[tuple[int, str]]:
    """Line and target of every role in a file."""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        for found in ROLE.finditer(line):
            yield number, found.group(1)


def resolves(target: str, path: Path) -> bool:
    """Whether a role's target is a module, or a name in a module or a class of the file it stands in."""
    parts = target.split(".")
    if in_module(parts, path):
        return True
    if any(holds(parts, node.body, path) for node in ast.walk(tree(path)) if isinstance(node, ast.ClassDef)):
        return True
    return any(
        name in modules() and (at == len(parts) or in_module(parts[at:], modules()[name]))
        for at in range(len(parts), 0, -1)
        for name in [".".join(parts[:at])]
    )


def in_module(parts: list[str], path: Path) -> bool:
    """Whether a dotted name starts with what a module binds."""
    return holds(parts, tree(path).body, path)


def holds(parts: list[str], body: list[ast.stmt], path: Path) -> bool:
    """Whether a dotted name is bound in a body, its later parts in the classes or modules that the first one names."""
    first, *rest = parts
    return any(name == first and (not rest or inside(rest, node, path)) for name, node in bound(body))


def inside(rest: list[str], node: ast.stmt, path: Path) -> bool:
    """Whether the later parts of a dotted name are there in what the first part names."""
    if isinstance(node, ast.ClassDef):
        return holds(rest, node.body, path) or any(from_base(rest, base, path) for base in node.bases)
    if isinstance(node, ast.ImportFrom):
        names = [f"{node.module}.{alias.name}" for alias in node.names]
        found = [modules()[name] for name in names if name in modules()]
        if any(in_module(rest, each) for each in found):
            return True
        source = modules().get(node.module or "")
        return source is not None and any(in_module([alias.name, *rest], source) for alias in node.names)
    return False


def from_base(rest: list[str], base: ast.expr, path: Path) -> bool:
    """Whether a base class, named plainly, has a member."""
    return isinstance(base, ast.Name) and in_module([base.id, *rest], path)
