"""The README's table of engines agrees with the registry, and the citation with the package."""

import re
import tomllib

import pytest
from ruamel.yaml import YAML

from adapters.registry import built_in
from pictures.pages.libraries import library_of
from tests.structure.product import ROOT

README = (ROOT / "README.md").read_text("utf-8")
LINES = README[README.index("## Engines") :].split("\n\n")[1].splitlines()[2:]
ROWS = [[cell.strip() for cell in line.strip("|").split("|")] for line in LINES]
"""Cells of the table of engines: names, …, physics, extra, licence"""


def engines_of(row: list[str]) -> list[str]:
    return re.findall(r"`([a-z0-9-]+)`", row[0])


def test_every_engine_stands_in_the_table_once() -> None:
    assert sorted(name for row in ROWS for name in engines_of(row)) == sorted(built_in())


@pytest.mark.parametrize("row", ROWS, ids=lambda row: engines_of(row)[0])
def test_a_row_tells_the_physics_the_extra_and_the_licence(row: list[str]) -> None:
    for name in engines_of(row):
        engine = built_in()[name]
        assert row[3] == ("independent" if engine.external else "barchain's equations")
        extra = re.search(r"\[([a-z,-]+)\]", engine.install)
        assert set(re.findall(r"`([a-z-]+)`", row[4])) == (set(extra[1].split(",")) if extra else set())
        assert library_of(name).licence.startswith(row[5])


def test_the_citation_has_the_version_of_the_package() -> None:
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]
