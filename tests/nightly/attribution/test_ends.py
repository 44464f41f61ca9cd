"""Ends of an attribution: a cell of a fresh environment must be of the sort that its night had."""

from __future__ import annotations

import pytest

from barchain.nightly.attribution.attribute import as_on_the_night
from barchain.nightly.figures.figure import Figure, FigureKind
from tests.nightly.history.synthetic import NAMES, bits, error, identity, verdict

MISSING = Figure(identity("verdict", FigureKind.VERDICT), reason="does not import", depends=NAMES)


@pytest.mark.parametrize(
    ("found", "night", "alike"),
    [
        (verdict("pass"), verdict("pass"), True),
        (verdict("pass"), verdict("failed"), False),
        (MISSING, verdict("pass"), False),
        (verdict("pass"), MISSING, False),
        (MISSING, MISSING, True),
        (error(1e-9), error(2e-9), True),
        (bits("00"), bits("11"), True),
    ],
)
def test_another_verdict_or_a_missing_result_is_another_end(found: Figure, night: Figure, alike: bool) -> None:
    assert as_on_the_night(found, night) is alike
