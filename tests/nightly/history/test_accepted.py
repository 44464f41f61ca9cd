"""Accepted changes: shown as such, and back when the figure moves again or the date has passed."""

from __future__ import annotations

import datetime
import json
from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run
from barchain.nightly.history.changes.accepted import acceptance_of, accepting
from barchain.nightly.history.changes.judging import judge_night
from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.judged import accept, accepted, change_named, judge, worse_and_not_accepted
from barchain.nightly.history.location import VARIABLE
from barchain.nightly.history.model.checked_text import FigureError
from barchain.nightly.history.store import NightStore, open_store
from tests.nightly.history.histories import as_series, history_of
from tests.nightly.history.synthetic import bits, count, error, night, verdict

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.history.changes.model import Change

AT = datetime.datetime(2026, 6, 1, tzinfo=datetime.UTC)


def last_change(*values: float) -> Change:
    nights = history_of(*[[error(v)] for v in values])
    return judge_night(as_series(nights), nights).changes[-1]


def test_what_was_accepted_is_accepted_numerically_and_comes_back_when_it_moves() -> None:
    made = acceptance_of(last_change(1e-5, 3e-5), "someone", AT, "a looser tolerance")
    assert accepting(last_change(1e-5, 3e-5), [made], AT) is made
    assert accepting(last_change(1e-5, 3e-5 + 1e-12), [made], AT) is made
    assert accepting(last_change(1e-5, 4e-5), [made], AT) is None
    assert accepting(last_change(1e-5, 3e-5, 1e-5), [made], AT) is None


def test_an_acceptance_ends_on_its_date() -> None:
    until = AT + datetime.timedelta(days=30)
    change = last_change(1e-5, 3e-5)
    made = acceptance_of(change, "someone", AT, "for a month", until)
    assert accepting(change, [made], until - datetime.timedelta(seconds=1)) is made
    assert accepting(change, [made], until) is None


@pytest.mark.parametrize(
    ("was", "now", "later"),
    [
        (verdict("pass"), verdict("failed"), verdict("timed_out")),
        (count(100), count(200), count(201)),
    ],
)
def test_verdicts_and_counts_are_accepted_exactly(was, now, later) -> None:
    nights = history_of([was], [now], [later])
    first, second = judge_night(as_series(nights), nights).changes
    made = acceptance_of(first, "someone", AT, "known")
    assert accepting(first, [made], AT) is made
    assert accepting(second, [made], AT) is None


def test_a_reason_is_needed() -> None:
    with pytest.raises(FigureError, match="reason"):
        acceptance_of(last_change(1e-5, 3e-5), "someone", AT, " ")


def test_acceptances_are_stored_once_and_outlive_their_nights(store: NightStore) -> None:
    for k, value in enumerate((1e-5, 3e-5)):
        store.add(night(error(value), number=k))
    judged = judge(store)
    (made,) = accept(store, [change_named(judged, error().identity.name)], "someone", "a looser tolerance")
    assert accepted(store) == (made,)
    assert worse_and_not_accepted(judged, accepted(store), AT) == []
    assert len(worse_and_not_accepted(judged, [], AT)) == 1
    store.prune(keep=1)
    assert accepted(store) == (made,)


def test_a_run_that_is_not_reproducible_can_not_be_accepted(store: NightStore) -> None:
    for k, word in enumerate(("aa", "bb")):
        store.add(night(bits(word), number=k))
    (change,) = judge(store).tonight
    with pytest.raises(HistoryError, match="can't be accepted"):
        accept(store, [change], "someone", "never mind")


@pytest.fixture
def filled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "history.sqlite"
    with open_store(str(place), create=True) as opened:
        for k, value in enumerate((1e-5, 1e-5, 3e-5)):
            opened.add(night(error(value), verdict(), number=k))
    monkeypatch.setenv(VARIABLE, str(place))
    return place


def test_changes_are_listed_accepted_and_then_shown_as_accepted(
    filled: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["history", "changes", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert (row["direction"], row["was"], row["is"]) == ("worse", "1e-05 rad", "3e-05 rad")
    assert row["suspects"] == "none: all parts that the figure depends on are the same"
    assert row["accepted"] == ""
    assert run(["history", "accept", row["id"], "--reason", "a looser tolerance", "--until", "2999-01-01"]) == 0
    assert "accepted by" in capsys.readouterr().out
    assert run(["history", "changes"]) == 0
    text = capsys.readouterr().out
    assert "1 change among 2 figures with an earlier night" in text
    assert "a looser tolerance" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["changes", "2026-02"], "no such night"),
        (["accept", "paper/fig05:mujoco:steps_per_orbit=1000:attitude.mx", "--reason", "x"], "attitude.max?"),
        (["accept", "0123456789"], "--reason"),
        (["accept", error().identity.name, "--reason", " "], "--reason"),
        (["accept", error().identity.name, "--reason", "x", "--until", "2020-01-01"], "has passed"),
        (["accept", error().identity.name, "--reason", "x", "--until", "soon"], "soon"),
    ],
)
def test_a_fault_is_one_line(filled: Path, words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["history", *words]) == 2
    shown = capsys.readouterr().err
    assert shown.count("\n") == 1
    assert said in shown


def test_the_same_value_after_a_recovery_is_another_change() -> None:
    nights = history_of([error(1e-5)], [error(3e-5)], [error(1e-5)], [error(3e-5)])
    first, _, second = judge_night(as_series(nights), nights).changes
    for one, other in ((first, second), (second, first)):
        made = acceptance_of(one, "someone", AT, "a looser tolerance")
        assert accepting(one, [made], AT) is made
        assert accepting(other, [made], AT) is None


def test_a_second_acceptance_says_which_one_it_replaces(filled: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["history", "accept", error().identity.name, "--reason"]
    assert run([*words, "first"]) == 0
    assert "replaces" not in capsys.readouterr().err
    assert run([*words, "second"]) == 0
    assert "first" in capsys.readouterr().err
