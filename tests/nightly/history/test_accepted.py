"""Accepted changes: shown as such, and back when the figure moves again or the date has passed."""

from __future__ import annotations

import datetime
import json
import re
import tomllib
from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import Direction
from barchain.nightly.figures.storage import VARIABLE
from barchain.nightly.history.acceptances import FILE, accept, acceptances_of, accepted, accepting, write_accepted
from barchain.nightly.history.judging import change_named, changes_named, judge
from barchain.nightly.history.nights import NightStore, open_store
from barchain.nightly.history.standing import every_change
from tests.nightly.history.histories import history_of, news_of
from tests.nightly.history.synthetic import error, night, verdict

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.history.acceptances import Acceptance
    from barchain.nightly.history.levels import JudgedNight

AT = datetime.datetime(2026, 6, 1, tzinfo=datetime.UTC)


def last_change(*values: float) -> Change:
    nights = history_of(*[[error(v)] for v in values])
    return news_of(nights)[-1]


def worse_and_not_accepted(judged: JudgedNight, known: Sequence[Acceptance], at: datetime.datetime) -> list[Change]:
    """Changes for the worse that a night tells first and that no acceptance covers."""
    return [c for c in judged.tonight if c.direction is Direction.WORSE and accepting(c, known, at) is None]


def test_an_acceptance_ends_on_its_date() -> None:
    until = AT + datetime.timedelta(days=30)
    change = last_change(1e-5, 3e-5)
    (made,) = acceptances_of([change], "someone", AT, "for a month", until)
    assert accepting(change, [made], until - datetime.timedelta(seconds=1)) is made
    assert accepting(change, [made], until) is None


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


@pytest.fixture
def filled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "history"
    opened = open_store(str(place), create=True)
    for k, value in enumerate((1e-5, 1e-5, 3e-5)):
        opened.add(night(error(value), verdict(), number=k))
    monkeypatch.setenv(VARIABLE, str(place))
    return place


def test_changes_are_listed_accepted_and_then_shown_as_accepted(
    filled: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["history", "changes", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert (row["direction"], row["was"], row["became"]) == ("worse", "1e-05 rad", "3e-05 rad")
    assert row["suspects"] == []
    assert row["accepted"] is None
    assert run(["history", "accept", row["id"], "--reason", "a looser tolerance", "--until", "2999-01-01"]) == 0
    assert "accepted: paper/fig05" in capsys.readouterr().out
    assert run(["history", "changes"]) == 0
    text = capsys.readouterr().out
    assert "One figure of 2 changed tonight" in text
    assert "a looser tolerance" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["changes", "2026-02"], "no such night"),
        (["accept", "paper/fig05:mujoco:steps_per_orbit=1000:attitude.mx", "--reason", "x"], "attitude.max?"),
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


def test_a_second_acceptance_says_which_one_it_replaces(filled: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["history", "accept", error().identity.name, "--reason"]
    assert run([*words, "first"]) == 0
    assert "replaces" not in capsys.readouterr().out
    assert run([*words, "second"]) == 0
    assert re.search(r"replaces: .*: first$", capsys.readouterr().out, re.MULTILINE)
    assert [one.reason for one in accepted(open_store(str(filled)))] == ["second"]


def test_one_entry_accepts_all_that_fits_a_pattern_and_ends_for_each_figure_that_moves(store: NightStore) -> None:
    def both(number: int, first: float, second: float) -> None:
        store.add(night(error(first, "a.max"), error(second, "b.max"), number=number))

    both(0, 1e-5, 1e-5)
    both(1, 3e-5, 3e-5)
    accept(store, changes_named(judge(store), "*:mujoco:*"), "Ada", "looser", pattern="*:mujoco:*")
    (entry,) = tomllib.loads((store.place.read(FILE) or b"").decode())["accepted"]
    assert (entry["pattern"], entry["since"]) == ("*:mujoco:*", store.nights()[1].name)
    assert worse_and_not_accepted(judge(store), accepted(store), AT) == []
    both(2, 3e-5, 9e-5)
    assert [c.identity.quantity for c in worse_and_not_accepted(judge(store), accepted(store), AT)] == ["b.max"]


def test_a_pattern_accepts_the_step_of_one_night_alone(
    store: NightStore, url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for number, factor in enumerate((1, 5, 6, 12)):
        store.add(night(error(factor * 1e-5), error(factor * 2e-5, "rate.max"), number=number))
    step = store.nights()[2].name
    words = ["history", "accept", "*:mujoco:*", "--step", step, "--reason", "a fifth on purpose", "--history", url]
    assert run(words) == 0
    said = capsys.readouterr().out
    assert "covers up to ×1.2 in one step since 2026-01-03" in said
    (still,) = [line for line in said.splitlines() if "still worse than accepted" in line]
    assert still.startswith("  still worse than accepted: 2 figures by up to ×10 since 2026-01-02")
    assert still.endswith("; `barchain history accept '*:mujoco:*'` accepts all of it")
    (entry,) = accepted(store)
    assert (entry.pattern, entry.first, entry.since) == ("*:mujoco:*", "", step)
    assert run([*words[:3], "--step", store.nights()[0].name, *words[5:]]) == 2
    assert "fits none of 0 changed figures on 2026-01-01" in capsys.readouterr().err


def test_an_acceptance_is_listed_and_taken_back(filled: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = error().identity.name
    assert run(["history", "accept", name, "--reason", "a looser tolerance"]) == 0
    capsys.readouterr()
    assert run(["history", "accepted"]) == 0
    said = capsys.readouterr().out
    assert said.startswith(f"{name}: 3e-05 rad (before 1e-05 rad), since 2026-01-03")
    assert run(["history", "withdraw", name]) == 0
    assert run(["history", "accepted"]) == 0
    assert capsys.readouterr().out.splitlines()[1:] == ["nothing is accepted"]
    assert run(["history", "withdraw", name]) == 2
    assert "nothing is accepted for it" in capsys.readouterr().err


def test_entries_that_have_lapsed_are_listed_as_such_after_the_others(
    filled: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store = open_store(str(filled))
    (change,) = judge(store).tonight
    (ended,) = accept(store, [change], "Ada", "ended")
    holds = ended.model_copy(update={"pattern": "*", "reason": "holds"})
    write_accepted(store, [ended.model_copy(update={"until": ended.date}), holds])
    assert run(["history", "accepted"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first.endswith(": holds")
    assert second.startswith(f"lapsed: {change.identity.name}")
    store.add(night(error(1e-5), verdict(), number=3))  # back at its level
    assert run(["history", "accepted", "--json"]) == 0
    assert [one["lapsed"] for one in json.loads(capsys.readouterr().out)] == [True, True]


def test_an_entry_that_somebody_wrote_by_hand_is_read_and_a_wrong_key_is_one_line(store: NightStore) -> None:
    for k, value in enumerate((1e-5, 3e-5)):
        store.add(night(error(value), number=k))
    text = (
        f'[[accepted]]\npattern = "*"\nsince = "{store.nights()[1].name}"\nreason = "r"\nwho = "w"\n'
        "date = 2026-01-05\nuntil = 2026-07-01\n"
    )
    store.place.write(FILE, text.encode())
    assert worse_and_not_accepted(judge(store), accepted(store), AT) == []
    store.place.write(FILE, text.replace("until", "untill").encode())
    with pytest.raises(HistoryError, match=r"accepted\[1\].untill: unknown key \(did you mean until"):
        accepted(store)


def test_a_pattern_accepts_nothing_that_is_seen_first_on_a_later_night(store: NightStore) -> None:
    """A scene that is measured now and then may have changed by something else since."""
    for k in range(4):
        often, seldom = error(1e-5 if k < 2 else 3e-5), error(1e-5 if k < 2 else 1.0, "rate.max")
        store.add(night(often, *([seldom] if k != 2 else []), number=k, complete=k != 2))
        if k == 2:
            accept(store, changes_named(judge(store), "*:mujoco:*"), "Ada", "meant", pattern="*:mujoco:*")
    changed = {c.identity.quantity: accepting(c, accepted(store), AT) for c in every_change(judge(store))}
    assert changed["attitude.max"] is not None
    assert changed["rate.max"] is None
