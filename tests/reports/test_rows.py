"""Rows: one relation for all that is measured or judged."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from barchain.studies.cost.findings import unknown_orders
from reports.results import cost, ensemble
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN, RowError, Rows, parsed_tags, records, spread, tag_text
from reports.results.studies import STUDIES
from tests.support.slow import one_in

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.results.files import StudyFiles
    from reports.results.table import Table

NUMBERS = st.one_of(st.integers(-(10**9), 10**9), st.floats(allow_nan=False, allow_infinity=False))
TEXTS = st.text(st.characters(exclude_characters=';="\n\r'), min_size=1).filter(lambda text: text == text.strip())


@settings(max_examples=30, deadline=None)
@given(st.dictionaries(st.from_regex(r"[a-z][a-z0-9_]*", fullmatch=True), st.one_of(NUMBERS, TEXTS), max_size=4))
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


def test_the_rules_of_nights_are_kinds_of_figures() -> None:
    from barchain.nightly.figures.figure import FigureKind

    assert {rule.kind for study in STUDIES for rule in study.followed.values()} <= set(FigureKind)


NAMES = ("", "1.5", "nan", "True", "a b", "µ ≤ 3 °, x/y")
"""Texts that may tell rows apart: one is empty, and some look like other things"""
WORDS = (*NAMES, 'a;b="c"', "two\nlines", " blank ")
CELLS = (0.0, -1.5, 1e-300, 12345678901234567.0, math.inf, -math.inf, math.nan)
MOST_ROWS = 40


def drawn(table: Table, rng: np.random.Generator) -> pd.DataFrame:
    """Rows of a table with any content that it may have."""

    def column(name: str) -> Sequence[object]:
        if name == "outcome":
            return tuple(map(str, Outcome))
        if name == "quantity" and table.only:
            return sorted(table.only)
        if table.types[name] is str:
            return NAMES if name in table.index else WORDS
        return CELLS if table.types[name] is float else (True, False)

    choices = {name: column(name) for name in table.columns}
    found = {name: [given[k] for k in rng.integers(len(given), size=MOST_ROWS)] for name, given in choices.items()}
    frame = table.framed(pd.DataFrame(found)).drop_duplicates(list(table.index), ignore_index=True)
    for row in table.rows[1:]:  # interval and text belong to a number
        number = row.columns.get("value")
        for name in row.columns.values() if number else ():
            if name != number:
                frame.loc[frame[number].isna(), name] = "" if table.types[name] is str else math.nan
    return frame


RECORD: dict[str, Any] = {"complete": True, "scene": {"name": "some/scene"}, "host": "reference"}


@pytest.mark.parametrize("study", one_in(4, STUDIES, lambda study: study.study))
def test_all_tables_of_a_study_are_read_from_its_rows_as_they_were(study: StudyFiles) -> None:
    """Whichever tables are there: those that are not are read without rows."""
    rng = np.random.default_rng(1)
    for there in (list(study.tables), *([name] for name in study.tables)):
        tables = {name: drawn(study.tables[name], rng) for name in there}
        assert all(len(table) > 5 for table in tables.values())
        rows = records(study.to_rows(tables, RECORD).frame())
        for name, table in study.tables.items():
            expected = tables[name] if name in there else table.framed(())
            pd.testing.assert_frame_equal(table.from_rows(rows), expected, check_exact=True, obj=name)


def test_tables_without_rows_are_read_without_rows() -> None:
    for study in STUDIES:
        rows = study.to_rows(dict.fromkeys(study.tables, ()), RECORD).found
        assert not any(len(table.from_rows(rows)) for table in study.tables.values()), study.study


def test_an_interrupted_cost_study_has_no_orders() -> None:
    order = {"scene": "s", "engine": "e", "quantity": "attitude", "against": "steps"}
    table = cost.TABLES["orders"].framed([order | {"order": 4.0, "order_low": 3.9, "order_high": 4.1, "points": 6}])

    def rows(orders: pd.DataFrame) -> pd.DataFrame:
        found = cost.FILES.to_rows({"orders": orders}, {"complete": True}).frame()
        return found[found["metric"] == "order"][["value", "low", "high", "outcome", "reason"]]

    assert rows(table).to_numpy().tolist() == [[4.0, 3.9, 4.1, "", ""]]
    unknown = rows(unknown_orders(table)).fillna(0.0)
    assert unknown.to_numpy().tolist() == [[0.0, 0.0, 0.0, NOT_RUN, cost.INTERRUPTED]]


def test_rows_of_an_ensemble_have_the_last_instant_alone_with_counts_and_times() -> None:
    at = {"quantity": "attitude", "item": 1, "quantile": 0.5, "unit": "rad", "runs": 3}
    quantiles = pd.DataFrame([at | {"t_s": 0.0, "value": 1.0}, at | {"t_s": 10.0, "value": 2.0}])
    record = {"scene": {"name": "some/scene"}, "outcomes": {"finished": 3}, "phases_s": {"run": 0.5}}
    rows = Rows("ensemble")
    ensemble.add_rows(rows, quantiles, record)
    found = rows.frame()
    assert found[["metric", "quantity", "value", "unit"]].to_numpy().tolist() == [
        ["quantile", "attitude", 2.0, "rad"], ["count", "finished", 3.0, "1"], ["seconds", "run", 0.5, "s"],
    ]  # fmt: skip
    assert found["until_s"].iloc[0] == 10.0
    assert set(found["scene"]) == {"some/scene"}


def test_noise_in_times_does_not_change_whether_an_error_is_reached() -> None:
    """A coarser setting that was slower than a finer one leaves the curve: the error is then reached "at most"."""
    named = {"scene": "s", "engine": "e", "quantity": "attitude", "measure": "seconds", "target": 1e-3, "cost": 1.0}
    verdicts = []
    for status in ("reached", "at most", "not reached"):
        reach = cost.TABLES["reach"].framed([named | {"status": status}])
        rows = cost.FILES.to_rows({"reach": reach}, {"complete": True}).frame()
        verdicts.append(rows[rows["metric"] == "reach"]["outcome"].item())
    assert verdicts == ["reached", "reached", "not reached"]
