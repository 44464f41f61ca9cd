"""Rows: one relation for all that is measured or judged."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reports.tables.measured import STUDIES, Measuring
from reports.tables.rows import RowError, Rows, parsed_tags, spread, tag_text

NUMBERS = st.one_of(st.integers(-(10**9), 10**9), st.floats(allow_nan=False, allow_infinity=False))
TEXTS = st.text(st.characters(exclude_characters=';="\n\r'), min_size=1).filter(lambda text: text == text.strip())


@given(st.dictionaries(st.from_regex(r"[a-z][a-z0-9_]*", fullmatch=True), st.one_of(NUMBERS, TEXTS)))
def test_tags_are_read_as_they_were_written(tags: dict[str, int | float | str]) -> None:
    assert parsed_tags(tag_text(tags)) == tags


def test_tags_are_sorted_and_empty_ones_are_left_out() -> None:
    assert tag_text({"fault": "mu", "bars": 100.0, "level": "", "rtol": math.nan}) == "bars=100;fault=mu"


@pytest.mark.parametrize(("name", "value"), [("Bars", 1), ("a b", 1), ("f", "a=b"), ("f", "a;b"), ("f", " a")])
def test_tags_outside_the_grammar_are_rejected(name: str, value: object) -> None:
    with pytest.raises(RowError, match="allowed:"):
        tag_text({name: value})


def test_two_rows_of_one_identity_are_rejected() -> None:
    rows = Rows("cost", "paper/fig05")
    rows.add("order", 4.0, engine="reference", against="steps")
    rows.add("order", 5.0, engine="reference", against="evaluations")
    assert len(rows.frame()) == 2
    rows.add("order", 6.0, engine="reference", against="steps")
    with pytest.raises(RowError, match="one identity: cost, paper/fig05, reference, , against=steps, , order"):
        rows.frame()


def test_spread_makes_columns_of_tags() -> None:
    rows = Rows("releases")
    rows.add("seconds", 1.0, "s", version="1.10", bars=2)
    rows.add("seconds", 2.0, "s", version="1.9", quantity="run")
    found = spread(rows.frame())
    assert list(found["version"]) == ["1.10", "1.9"]
    assert found["bars"].iloc[0] == 2.0
    assert math.isnan(found["bars"].iloc[1])


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.files.name)
def test_the_rules_of_nights_are_kinds_of_figures(study: Measuring) -> None:
    from barchain.nightly.figures import FigureKind

    assert {rule.kind for rule in study.followed.values()} <= set(FigureKind)
