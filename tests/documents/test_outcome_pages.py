"""Pages for readers of a report name every outcome."""

import re

from reports.results.outcome import Outcome
from tests.documents.mentions import ROOT

PAGE = ROOT / "docs/howto/reading_the_report.md"


def test_every_outcome_has_one_row_in_reading_the_report():
    table = PAGE.read_text("utf-8").split("## Outcomes, and what to do")[1]
    named = re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)
    assert sorted(named) == sorted(Outcome)
