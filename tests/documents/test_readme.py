"""The README's table of engines agrees with the registry, and the citation with the package."""

import re
import tomllib
from dataclasses import dataclass

import pytest
from ruamel.yaml import YAML

from adapters.registry import built_in
from pictures.pages.libraries import library_of
from tests.documents.mentions import ROOT

NO_EXTRA = "–"
README = (ROOT / "README.md").read_text("utf-8")


@dataclass(frozen=True)
class Row:
    """A row of the table of engines."""

    engines: tuple[str, ...]
    physics: str
    extra: str
    licence: str


def rows() -> list[Row]:
    table = README[README.index("## Engines") :].split("\n\n")[1].splitlines()[2:]
    return [row_of([cell.strip() for cell in line.strip("|").split("|")]) for line in table]


def row_of(cells: list[str]) -> Row:
    return Row(tuple(re.findall(r"`([a-z0-9-]+)`", cells[0])), cells[3], cells[4], cells[5])


def told_extras(row: Row) -> set[str]:
    """Extras of a row's engines; a dash for none."""
    return set(re.findall(r"`([a-z-]+)`", row.extra)) or {NO_EXTRA}


def extras(install: str) -> set[str]:
    """Extras in a command that installs an engine; a dash for none."""
    found = re.search(r"\[([a-z,-]+)\]", install)
    return set(found.group(1).split(",")) if found else {NO_EXTRA}


def test_every_engine_stands_in_the_table_once() -> None:
    assert sorted(name for row in rows() for name in row.engines) == sorted(built_in())


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.engines[0])
def test_a_row_tells_the_physics_the_extra_and_the_licence(row: Row) -> None:
    for name in row.engines:
        engine = built_in()[name]
        assert row.physics == ("independent" if engine.external else "barchain's equations")
        assert told_extras(row) == extras(engine.install)
        assert library_of(name).licence.startswith(row.licence)


def test_the_readme_can_be_read_in_a_minute_or_two() -> None:
    assert len(README.splitlines()) <= 145


def test_the_citation_has_the_version_of_the_package() -> None:
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text("utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]
