"""Pages can be read by everyone: axe-core finds nothing in either colour scheme, on a phone, a laptop, a large one."""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING

import pytest

from reports import render as reports
from tests.reports.study_pages import PAGES
from tests.support.accessibility import OUTSIDE, TOO_WIDE, html_files, main, violations
from tests.support.browser import in_browser
from tests.support.report_fixture import build
from tests.support.slow import exhaustive_but

if TYPE_CHECKING:
    from pathlib import Path

FAULTY = """<!doctype html><html lang="en"><head><title>Page</title></head><body><main><h1>Page</h1>
{}</main></body></html>"""
FAULTS = {
    "color-contrast": '<p style="color:#bbb;background:#fff">Pale</p>',
    "image-alt": '<img src="data:image/gif;base64,R0lGODlhAQABAAAAACw=">',
    "label": "<input type=checkbox>",
    "heading-order": "<h4>Deep</h4>",
    "svg-img-alt": '<svg role="img" viewBox="0 0 1 1"><path d="M0 0H1"/></svg>',
    "scrollable-region-focusable": '<div style="overflow:auto;height:2em">' + "<p>Long</p>" * 9 + "</div>",
    TOO_WIDE: '<div style="width:3000px">Wide</div>',
    "empty-table-header": "<table><tr><th></th><th>a</th></tr><tr><td>1</td><td>2</td></tr></table>",
}


@pytest.mark.slow
@in_browser
@pytest.mark.parametrize("name", exhaustive_but(PAGES, ["nightly", "results"]))
def test_axe_finds_nothing_on_a_page(name: str, tmp_path: Path) -> None:
    found = violations([PAGES[name](tmp_path)])
    assert not found, "\n".join(map(str, found))


@pytest.mark.slow
@in_browser
@pytest.mark.parametrize("rule", exhaustive_but(FAULTS, ["color-contrast"]))
def test_a_fault_of_a_page_is_found_and_named(rule: str, tmp_path: Path) -> None:
    pages = tmp_path / "page.html", tmp_path / "plain.html"
    for page, body in zip(pages, (FAULTS[rule], "<p>Plain</p>"), strict=True):
        page.write_text(FAULTY.format(body))
    found = violations(pages, schemes=["light"], widths=[390])
    assert {(v.page, v.rule) for v in found} == {("page.html", rule)}


@pytest.mark.exhaustive
@in_browser
def test_folded_parts_are_checked_and_a_page_that_follows_an_address_is_told(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text(FAULTY.format(f"<details><summary>More</summary>{FAULTS['label']}</details>"))
    assert "label" in [v.rule for v in violations([page], ["dark"], [1200])]
    page.write_text(FAULTY.format('<p style="background:url(http://example.invalid/x.png)">Text</p>'))
    assert OUTSIDE in [v.rule for v in violations([page], ["dark"], [1200])]


@pytest.mark.exhaustive
@in_browser
def test_the_command_counts_violations_of_files_and_folders(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "deep").mkdir()
    for path, text in ((tmp_path / "good.html", "<p>Plain</p>"), (tmp_path / "deep" / "bad.html", FAULTS["label"])):
        path.write_text(FAULTY.format(text))
    assert main([str(tmp_path), "--widths", "390"]) == 1
    assert "2 pages, 2 schemes, 1 widths: 2 violations" in capsys.readouterr().out
    assert main([str(tmp_path / "good.html"), "--widths", "390"]) == 0


def test_a_folder_without_pages_is_no_success(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert html_files([tmp_path]) == []
    assert main([str(tmp_path)]) == 1
    assert "0 pages" in capsys.readouterr().out


def test_headings_descend_by_one_level_and_what_scrolls_or_is_operated_has_a_name(tmp_path: Path) -> None:
    page = reports.render(build(tmp_path, ["basics/two_bars_free"], samples=21))[0].read_text()
    levels = [int(n) for n in re.findall(r"<h([1-6])", page)]
    assert levels[0] == 1
    assert all(after <= before + 1 for before, after in itertools.pairwise(levels))
    boxes = re.findall(r'<div class="scroll[^>]*>', page)
    assert boxes
    assert all('tabindex="0" role="group" aria-label="' in box for box in boxes)
    controls = re.findall(r'<input [^>]*id="([^"]+)"', page)
    assert controls
    assert len(controls) == page.count("<input ") == len(set(controls))
    assert all(f'<label for="{control}">' in page for control in controls)
