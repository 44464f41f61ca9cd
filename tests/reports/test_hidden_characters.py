"""Text from outside in pages and tables: hidden characters are codes, formulas are text, pages load nothing."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from markupsafe import Markup

from reports.page import templates
from reports.render import render_all
from reports.tables.cells import as_cell, from_cell, from_cells, to_cells
from reports.text.markdown import escape_text
from reports.text.visible import visible, written
from scenarios.text import is_hidden
from tests.support.page_policy import check_policy
from tests.support.report_fixture import build

if TYPE_CHECKING:
    from pathlib import Path


def test_reports_escape_the_characters_that_scenes_reject() -> None:
    wrong = [c for c in map(chr, range(sys.maxunicode + 1)) if (visible(c) != c) is not is_hidden(c)]
    assert wrong == []


def test_hidden_characters_are_written_as_codes_in_html_and_markdown() -> None:
    page = templates().from_string("{{ a }}|{{ b }}|{{ 1.5 }}")
    assert page.render(a="x\u202ey\x1b", b=Markup("<b>\u200b\n</b>")) == r"x\u202ey\x1b|<b>\u200b" + "\n</b>|1.5"
    assert escape_text("a\u202e\nb &lt; <i>") == r"a\\u202e b \&lt; \<i\>"
    assert isinstance(written(Markup("<b>")), Markup)


@pytest.mark.parametrize("text", ["=1+1", "+A1", "-A1", "@SUM(A1)", "\t=1", "\r=1", "'=1", "''@x", "-", "=HYPERLINK()"])
def test_a_cell_that_begins_like_a_formula_is_marked_as_text_and_read_back(text: str) -> None:
    assert as_cell(text) == f"'{text}"
    assert from_cell(as_cell(text)) == text


@pytest.mark.parametrize(
    "text", ["", "pass", "'quoted'", "-1.5", "+2e-9", "-inf", "reference, rtol=1e-13", "a=b", "−3"]
)
def test_numbers_and_plain_text_stay(text: str) -> None:
    assert as_cell(text) == text == from_cell(text)


@given(st.text(alphabet="'=+-@\t\r a1.", max_size=6))
def test_every_text_reads_back_as_written(text: str) -> None:
    assert from_cell(as_cell(text)) == text


def test_a_table_keeps_numbers_and_types() -> None:
    frame = pd.DataFrame({"x": [-1.0, 2.0], "n": [-1, 2], "words": ["=a", None], "mixed": [-1.0, "-a"]})
    assert to_cells(frame)["words"].tolist()[0] == "'=a"
    assert to_cells(frame)["mixed"].tolist() == [-1.0, "'-a"]
    pd.testing.assert_frame_equal(from_cells(to_cells(frame)), frame)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Pages of a comparison."""
    return [p for p in render_all(build(tmp_path_factory.mktemp("report"), ["paper/fig05"])) if p.suffix == ".html"]


def test_the_policy_of_a_report_lets_it_load_nothing_and_the_report_obeys(pages: list[Path]) -> None:
    assert pages
    for page in pages:
        check_policy(page)


def test_every_template_of_a_whole_page_has_the_policy() -> None:
    whole = [name for name in templates().list_templates() if "<!doctype html>" in source(name)]
    assert set(whole) == {"crossval/report.html.j2", "nightly/page.html.j2", "study_page.html.j2"}
    assert all(source(name).count('{% include "policy.html.j2" %}') == 1 for name in whole)


def source(name: str) -> str:
    loader = templates().loader
    assert loader is not None
    return loader.get_source(templates(), name)[0]
