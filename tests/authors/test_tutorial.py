"""The tutorial shows the package as it is written, and names helpers that are there."""

from __future__ import annotations

import ast
import re

import pytest

from barchain import engine as kit
from barchain import load_scene
from tests.structure.product import ROOT

TUTORIAL = (ROOT / "docs/tutorials/your_own_engine.md").read_text(encoding="utf-8")
SOURCE = ROOT / "barchain/engine/template/source"
SHOWN = re.findall(r"^```python\n(.*?)^```", TUTORIAL, re.MULTILINE | re.DOTALL)
ROW = re.compile(r"^\| (?:model|start|loads|step|impulses|channels|landing) \|.*\| (`.*`) \|$", re.MULTILINE)


def statements(text: str) -> set[str]:
    """Simple statements of a text, each on one line and in one style."""
    nodes = ast.walk(ast.parse(text))
    return {ast.unparse(node) for node in nodes if isinstance(node, ast.stmt) and not hasattr(node, "body")}


def package_statements() -> set[str]:
    sources = [p.read_text(encoding="utf-8") for p in SOURCE.glob("*.py.j2")]
    return set().union(*(statements(re.sub(r"{{ (\w+) }}", r"\1", text)) for text in sources))


@pytest.mark.parametrize("shown", SHOWN)
def test_every_statement_in_the_tutorial_is_in_the_package(shown: str) -> None:
    assert statements(shown) <= package_statements()


def test_every_helper_in_the_tutorials_last_table_is_public() -> None:
    rows = ROW.findall(TUTORIAL)
    assert len(rows) == 7
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    (bar, *_) = kit.bars_of(load_scene("basics/two_bars_free").chain)
    assert named <= {*kit.__all__, *bar._fields}
