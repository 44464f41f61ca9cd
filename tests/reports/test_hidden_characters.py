"""Text from outside in pages and tables: hidden characters are codes, pages load nothing."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import pytest
from markupsafe import Markup

from reports.page import templates
from reports.render import render_all
from reports.text.words import escape_text, shown, visible
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
    assert isinstance(shown(Markup("<b>")), Markup)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Pages of a comparison."""
    return [p for p in render_all(build(tmp_path_factory.mktemp("report"), ["paper/fig05"])) if p.suffix == ".html"]


@pytest.mark.exhaustive
def test_the_policy_of_a_report_lets_it_load_nothing_and_the_report_obeys(pages: list[Path]) -> None:
    assert pages
    for page in pages:
        check_policy(page)


def test_every_template_of_a_whole_page_has_the_policy() -> None:
    whole = [name for name in templates().list_templates() if "<!doctype html>" in source(name)]
    assert set(whole) == {"base.html.j2", "case/page.html.j2", "motion.html.j2"}
    assert all(source(name).count('{% include "policy.html.j2" %}') == 1 for name in whole)


def source(name: str) -> str:
    loader = templates().loader
    return loader.get_source(templates(), name)[0]
