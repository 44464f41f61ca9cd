"""Texts in whose place benchmarks plant mistakes are still there, once each: a run of hours would end on the first."""

import pytest

from benchmarks import planted_changes, planted_in_the_code
from tests.structure.product import ROOT

IN_THE_CODE = [(file, old) for (file, _), mistakes in planted_in_the_code.MISTAKES.items() for old, _ in mistakes]
CHANGES = [(plant.file, plant.old) for plant in planted_changes.SOURCES if plant.old]


@pytest.mark.parametrize(("file", "old"), [*IN_THE_CODE, *CHANGES])
def test_a_planted_text_occurs_once_in_its_file(file: str, old: str) -> None:
    assert (ROOT / file).read_text("utf-8").count(old) == 1
