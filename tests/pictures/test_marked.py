"""Tables between two comments of a page are written anew, and nothing else of the page changes."""

from __future__ import annotations

import pytest

from pictures.pages.marked import PAGES, START, TABLES, with_part, with_tables
from pictures.paths import DOCS

PAGE = "Before.\n<!-- exit-codes: generated -->\nold\n<!-- end of exit-codes -->\nAfter.\n"


def test_a_table_is_written_anew_between_its_comments() -> None:
    found = with_tables(PAGE)
    assert found.startswith("Before.\n<!-- exit-codes: generated -->\n\n| code | meaning |")
    assert found.endswith("\n\n<!-- end of exit-codes -->\nAfter.\n")
    assert "\nold\n" not in found


def test_a_page_that_is_written_twice_stays_as_it_is() -> None:
    assert with_tables(with_tables(PAGE)) == with_tables(PAGE)


@pytest.mark.parametrize("lost", ["<!-- end of exit-codes -->", "<!-- exit-codes: generated -->"])
def test_a_part_without_one_of_its_comments_is_an_error(lost: str) -> None:
    with pytest.raises(ValueError, match="exit-codes: one comment before the part and one after it are needed"):
        with_part(PAGE.replace(lost, ""), "exit-codes", "new")


def test_a_name_that_no_table_has_is_an_error() -> None:
    with pytest.raises(KeyError, match="colours"):
        with_tables("<!-- colours: generated -->\n<!-- end of colours -->\n")


def test_every_table_stands_on_a_page() -> None:
    named = [name for page in PAGES for name in START.findall((DOCS / page).read_text(encoding="utf-8"))]
    assert set(named) == set(TABLES)
