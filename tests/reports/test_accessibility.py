"""Pages can be read by everyone: axe-core finds nothing in either colour scheme, on a phone, a laptop, a large one."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING

import pytest

from reports import render as reports
from tests.reports.study_pages import PAGES
from tests.support.accessibility import violations
from tests.support.browser import in_browser
from tests.support.report_fixture import build
from tests.support.slow import exhaustive_but

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.slow
@in_browser
@pytest.mark.parametrize("name", exhaustive_but(PAGES, ["nightly", "results"]))
def test_axe_finds_nothing_on_a_page(name: str, tmp_path: Path) -> None:
    found = violations(PAGES[name](tmp_path))
    assert not found, "\n".join(found)


def test_headings_descend_by_one_level_and_what_scrolls_or_is_operated_has_a_name(tmp_path: Path) -> None:
    page = reports.render(build(tmp_path, ["basics/two_bars_free"], samples=21))[0].read_text()
    levels = [int(n) for n in re.findall(r"<h([1-6])", page)]
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))
    boxes = re.findall(r'<div class="scroll[^>]*>', page)
    assert boxes
    assert all('tabindex="0" role="group" aria-label="' in box for box in boxes)
    controls = re.findall(r'<input [^>]*id="([^"]+)"', page)
    assert len(controls) == page.count("<input ") == len(set(controls))
    assert all(f'<label for="{control}">' in page for control in controls)
