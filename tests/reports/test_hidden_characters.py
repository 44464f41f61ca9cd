"""Text from outside in pages and tables: hidden characters are codes, pages load nothing."""

from __future__ import annotations

from markupsafe import Markup

from reports.page import templates
from reports.text.words import escape_text, shown, visible
from scenarios.text import is_hidden


def test_reports_escape_the_characters_that_scenes_reject() -> None:
    """Categories of hidden characters have none beyond the second plane but tags of languages."""
    every = [*map(chr, range(0x20000)), *map(chr, range(0xE0000, 0xE1000))]
    wrong = [c for c in every if (visible(c) != c) is not is_hidden(c)]
    assert wrong == []


def test_hidden_characters_are_written_as_codes_in_html_and_markdown() -> None:
    page = templates().from_string("{{ a }}|{{ b }}|{{ 1.5 }}")
    assert page.render(a="x\u202ey\x1b", b=Markup("<b>\u200b\n</b>")) == r"x\u202ey\x1b|<b>\u200b" + "\n</b>|1.5"
    assert escape_text("a\u202e\nb &lt; <i>") == r"a\\u202e b \&lt; \<i\>"
    assert isinstance(shown(Markup("<b>")), Markup)


def test_every_template_of_a_whole_page_has_the_policy() -> None:
    sources = {name: templates().loader.get_source(templates(), name)[0] for name in templates().list_templates()}
    whole = {name: text for name, text in sources.items() if "<!doctype html>" in text}
    assert len(whole) >= 3
    assert all(text.count('{% include "policy.html.j2" %}') == 1 for text in whole.values())
