"""Tables of the public interfaces, from the docstrings: the names of a module with arguments and first sentence."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import re
import textwrap
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from pictures.pages.words import table
from scenarios.effect_types import all_effect_names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import ModuleType

ROLE = re.compile(r":[a-z]+:`(?:[^`<]*<)?[~!]?([^`>]+)>?`")
PLAIN = str | int | float | type | None
"""Types of defaults that are shown; `type` is that of a missing default"""
HEAD = ("name", "meaning")


def engine_interface() -> str:
    """Names of `barchain.engine`, classes with their public members."""
    module = importlib.import_module("barchain.engine")
    found = {name: getattr(module, name) for name in module.__all__}
    classes = {name: value for name, value in found.items() if inspect.isclass(value) and inspect.getdoc(value)}
    functions = {name: value for name, value in found.items() if inspect.isfunction(value)}
    others = {**constants(importlib.import_module("adapters.trajectory")), **constants(module)}
    parts = [f"## Functions\n\n{table(HEAD, (row(name, value) for name, value in functions.items()))}"]
    parts.append(f"## Constants and types\n\n{table(HEAD, ((f'`{n}`', others[n]) for n in found if n in others))}")
    for name, cls in classes.items():
        members = [*attribute_rows(cls), *field_rows(cls), *member_rows(cls)]
        parts.append("\n\n".join([f"## `{name}`", first_paragraph(cls), *([table(HEAD, members)] if members else [])]))
    return "\n\n".join([*parts, effect_names()])


def effect_names() -> str:
    """Names for `Engine.effects`."""
    names = ", ".join(f"`{name}`" for name in sorted(all_effect_names()))
    return f"## Names of effects\n\nAn engine's `effects` may hold: {names}."


def constants(module: ModuleType) -> dict[str, str]:
    """Meanings of a module's constants, from the docstrings that follow them."""
    body = ast.parse(inspect.getsource(module)).body
    return {name.strip("`"): meaning for name, meaning in documented(body)}


def attribute_rows(cls: type) -> Iterator[tuple[str, str]]:
    """Rows of the fields in a class's docstring: its section Attributes, or of a dataclass Parameters."""
    pattern = r"^(?:Attributes|Parameters)\n-+\n(.*?)(?:^\S+\n-+\n|\Z)"
    section = re.search(pattern, inspect.getdoc(cls) or "", re.DOTALL | re.MULTILINE)
    for entry in re.finditer(r"^(\w[\w, ]*) : (.*)\n((?: +.*\n?)+)", section[1] if section else "", re.MULTILINE):
        for name in entry[1].split(", "):
            yield f"`{name}`", f"{entry[2]}. {plain(entry[3])}"


def field_rows(cls: type) -> Iterator[tuple[str, str]]:
    """Rows of the fields, class attributes and choices of a class that a docstring follows in its source."""
    body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    assert isinstance(body, ast.ClassDef)
    yield from documented(body.body)


def documented(body: list[ast.stmt]) -> Iterator[tuple[str, str]]:
    """Rows of the public names that are assigned or declared, and followed by a docstring."""
    for statement, after in pairwise(body):
        target = target_of(statement)
        if target and isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
            yield f"`{target}`", plain(str(after.value.value))


def target_of(statement: ast.stmt) -> str:
    """Public name that a statement of a class's body assigns or declares; empty without one."""
    targets = statement.targets if isinstance(statement, ast.Assign) else []
    target = statement.target if isinstance(statement, ast.AnnAssign) else next(iter(targets), None)
    return target.id if isinstance(target, ast.Name) and not target.id.startswith("_") else ""


def member_rows(cls: type) -> Iterator[tuple[str, str]]:
    """Rows of the functions and properties that a class defines itself; its own arguments and call first."""
    if not dataclasses.is_dataclass(cls) and inspect.isfunction(made := vars(cls).get("__init__")):
        yield f"`{cls.__name__}{arguments(made)}`", first_paragraph(made)
    if inspect.isfunction(called := vars(cls).get("__call__")):
        yield f"call `{arguments(called)}`", first_paragraph(called)
    for name, member in vars(cls).items():
        inner = member.__func__ if isinstance(member, classmethod | staticmethod) else member
        if not name.startswith("_") and (inspect.isfunction(inner) or isinstance(inner, property)):
            yield row(name, inner)


def row(name: str, member: Any) -> tuple[str, str]:
    """Name with its arguments, and the first paragraph of the docstring."""
    called = f"{name}{arguments(member)}" if inspect.isfunction(member) else name
    return f"`{called}`", first_paragraph(member)


def arguments(function: Callable[..., Any]) -> str:
    """Arguments without types: ``(scene, *, steps=None)``; a default that is no plain value is an ellipsis."""
    signature = inspect.signature(function)
    bare = [
        p.replace(annotation=p.empty, default=p.default if isinstance(p.default, PLAIN) else ...)
        for p in signature.parameters.values()
        if p.name not in ("self", "cls")
    ]
    return str(signature.replace(parameters=bare, return_annotation=signature.empty)).replace("Ellipsis", "…")


def first_paragraph(member: Any) -> str:
    """First paragraph of a docstring."""
    return plain(inspect.getdoc(member) or "")


def plain(docstring: str) -> str:
    """First paragraph of a docstring in one line, with code in place of Sphinx roles."""
    paragraph = docstring.strip().partition("\n\n")[0]
    return ROLE.sub(lambda m: f"`{m[1]}`", " ".join(paragraph.split())).replace("``", "`")


TABLES: dict[str, Callable[[], str]] = {"engine-interface": engine_interface}
"""Tables by their names"""
