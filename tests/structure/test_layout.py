"""The layout: one class a name, folders that one can survey, tests that stand alone."""

from __future__ import annotations

import ast
from collections import defaultdict
from typing import TYPE_CHECKING

from tests.structure.product import PACKAGES, ROOT, classes, python_files, relative, tree

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

MOST_ENTRIES = 16
DATA = {".toml", ".csv", ".parquet"}  # folders of scenes and of certified solutions grow with the number of scenes


def entries(folder: Path) -> list[Path]:
    """What a folder holds, caches and the marker of typed packages left out."""
    left_out = {"__pycache__", "py.typed"}
    return [path for path in folder.iterdir() if path.name not in left_out and not path.name.startswith(".")]


def folders() -> Iterator[Path]:
    """Every folder of the product that holds more than data."""
    for package in PACKAGES:
        for folder in (ROOT / package, *(ROOT / package).rglob("*")):
            if folder.is_dir() and folder.name != "__pycache__" and {p.suffix for p in entries(folder)} - DATA:
                yield folder


def imported(path: Path) -> Iterator[str]:
    """Dotted names of what a file imports; of ``from a import b`` both ``a`` and ``a.b``."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_no_two_classes_of_the_product_and_its_tools_share_a_name() -> None:
    places = defaultdict(list)
    for path in python_files(*PACKAGES, "pictures", "benchmarks"):
        for each in classes(path):
            places[each.name].append(f"{relative(path)}:{each.lineno}")
    shared = [f"{name}: {', '.join(where)}" for name, where in sorted(places.items()) if len(where) > 1]
    assert not shared, f"{len(shared)} names are shared\n" + "\n".join(shared)


def test_no_folder_of_the_product_holds_more_than_sixteen_entries() -> None:
    full = [f"{relative(f)}: {len(entries(f))}" for f in folders() if len(entries(f)) > MOST_ENTRIES]
    assert not full, full


def test_no_test_module_imports_another_test_module() -> None:
    files = python_files("tests")
    found = [
        f"{relative(path)} imports {name}"
        for path in files
        for name in imported(path)
        if any(part.startswith("test_") for part in name.split(".")[:3]) and name.startswith("tests.")
    ]
    assert not found, "\n".join(found)
