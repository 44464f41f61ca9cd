"""The register of tolerances is what the report shows, and every test that it names exists."""

from __future__ import annotations

from pathlib import Path

import pytest

from barchain.judge.tolerances import SAFEGUARDS, TOLERANCES, plain
from barchain.studies.comparison.run import tolerance_rows

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", sorted({entry.tested_by for entry in (*TOLERANCES, *SAFEGUARDS)}))
def test_every_test_that_the_register_names_exists(name: str) -> None:
    files = [*ROOT.glob("tests/judge/*.py"), *ROOT.glob("tests/harness/*.py")]
    assert any(f"def {name}(" in path.read_text(encoding="utf-8") for path in files)


def test_a_number_in_a_table_has_no_leading_zero_in_its_exponent() -> None:
    assert [plain(x) for x in (1e-6, 1e-10, 0.01)] == ["1e-6", "1e-10", "0.01"]


def test_the_report_shows_every_tolerance() -> None:
    assert [row["derivation"] for row in tolerance_rows()] == [t.derivation for t in TOLERANCES]
