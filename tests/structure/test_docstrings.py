"""Cross-references in docstrings lead somewhere, and public records describe each of their fields."""

from __future__ import annotations

import dataclasses
import inspect
import re

import pytest

import barchain
from barchain.studies.comparison.run import ComparisonResult
from reports.results.comparison import METRIC_COLUMNS, QUANTITY_UNITS
from scenarios import effect_types, scene
from tests.structure.product import PACKAGES, python_files, relative
from tests.structure.roles import resolves, roles


@pytest.mark.parametrize("package", [*PACKAGES, "tests", "benchmarks"])
def test_every_role_in_a_docstring_names_something_that_exists(package: str) -> None:
    lost = [
        f"{relative(path)}:{number}: {target}"
        for path in python_files(package)
        for number, target in roles(path)
        if not resolves(target, path)
    ]
    assert not lost, "\n".join(lost)


EFFECTS = [found for _, found in inspect.getmembers(effect_types, dataclasses.is_dataclass)]
RECORDS = [barchain.Scene, scene.CentralBody, scene.Orbit, scene.Chain, scene.Run, *EFFECTS]
RECORDS += [barchain.Trajectory, barchain.Setting, ComparisonResult]


@pytest.mark.parametrize("record", RECORDS, ids=lambda record: record.__name__)
def test_the_docstring_of_a_public_record_describes_each_field(record: type) -> None:
    text = inspect.getdoc(record) or ""
    head = re.search(r"^(Attributes|Parameters)\n-+\n", text, re.MULTILINE)
    assert head, "no section"
    section = text[head.end() :].partition("\n\nRaises")[0]
    described = [name for line in re.findall(r"^(\w[\w, ]*) : \S", section, re.MULTILINE) for name in line.split(", ")]
    assert sorted(described) == sorted(field.name for field in dataclasses.fields(record))


def test_the_metrics_of_a_comparison_are_described_column_by_column() -> None:
    text = inspect.getdoc(ComparisonResult) or ""
    assert not [column for column in METRIC_COLUMNS if f"``{column}``" not in text]
    assert not [quantity for quantity in QUANTITY_UNITS if f"``{quantity}``" not in text]
