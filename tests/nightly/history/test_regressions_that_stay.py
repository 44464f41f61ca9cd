"""No regression is lost: not over many nights, not behind other machines, gaps, partial repairs or old acceptances."""

from __future__ import annotations

import datetime
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from barchain.nightly.figures.changes import results_words
from barchain.nightly.figures.figure import Figure, FigureKind
from barchain.nightly.history.acceptances import acceptances_of, accepting
from barchain.nightly.history.judging import judge, judge_pair
from barchain.nightly.history.standing import still_holding
from reports.results.rows import NOT_RUN
from tests.nightly.history.synthetic import NAMES, error, identity, night, verdict

if TYPE_CHECKING:
    from barchain.nightly.history.nights import NightStore

LATER = datetime.datetime(2100, 1, 1, tzinfo=datetime.UTC)


def standing(store: NightStore) -> list[str]:
    judged = judge(store)
    return [
        change.identity.quantity for change in (*judged.tonight, *still_holding(judged)) if change.direction == "worse"
    ]


def test_a_drift_below_rounding_on_every_night_is_told_in_the_end(store: NightStore) -> None:
    for k in range(60):
        store.add(night(error(1e-5 * (1.0 + 0.0005 * k), tolerance=1e-7), number=k))
    assert standing(store) == ["attitude.max"]


def test_nights_of_another_machine_do_not_push_those_of_this_one_out(store: NightStore) -> None:
    store.add(night(verdict(), number=0))
    other = night(verdict(), number=1)
    other = replace(other, environment=replace(other.environment, cpu="another processor"))
    for k in range(1, 36):
        moved = night(verdict(), number=k)
        store.add(replace(moved, environment=other.environment))
    store.add(night(verdict("inconsistent"), number=36))
    assert standing(store) == ["verdict"]


def test_a_figure_that_comes_back_worse_after_a_gap_is_worse(store: NightStore) -> None:
    store.add(night(error(1e-5), number=0))
    store.add(night(error(None, reason="NaN"), number=1))
    store.add(night(error(1e-2), number=2))
    ((change,), first, last) = judge(store).tonight, store.nights()[0], store.nights()[2]
    assert (change.direction, change.was.value, change.last, change.since) == ("worse", 1e-5, first.name, last.name)
    assert still_holding(judge(store)) == []  # since tonight, and not since it was missing


def test_a_figure_that_was_worse_and_is_gone_is_missing_since_it_is_gone(store: NightStore) -> None:
    for k, figure in enumerate((error(1e-5), error(1e-4), error(None, reason="NaN"), error(None, reason="NaN"))):
        store.add(night(figure, number=k))
    (state,) = still_holding(judge(store))
    assert state.now.missing
    assert [state.last, state.since] == [each.name for each in store.nights()[1:3]]


def test_an_engine_that_crashed_from_the_start_and_passes_once_may_not_crash_again(store: NightStore) -> None:
    for k, word in enumerate(("failed", "failed", "pass", "failed")):
        store.add(night(verdict(word), number=k))
    (change,) = judge(store).tonight
    assert (change.direction, change.was.word, change.now.word) == ("worse", "pass", "failed")


def on_random_scene(word: str, fault: str = "") -> Figure:
    """Figure of nights of 0.7: rating of an engine, or of a fault in it, on a random scene."""
    return Figure(
        identity("campaign.class", FigureKind.VERDICT, scene="random/3", setting=fault), word=word, depends=NAMES
    )


@pytest.mark.parametrize("plan", ["plan", "other"])
def test_random_scenes_in_nights_of_0_7_are_judged_and_nothing_is_missed_where_later_nights_have_none(
    plan: str, store: NightStore
) -> None:
    for k, (engine, fault) in enumerate((("pass", "caught"), ("pass", "caught"), ("false alarm", "missed"))):
        rate = Figure(identity("campaign.rate.missed", FigureKind.VALUE, unit="1"), 0.1 * k, low=0.0, high=1.0)
        store.add(night(verdict(), on_random_scene(engine), on_random_scene(fault, "mu"), rate, number=k))
    assert [change.direction for change in judge(store).tonight] == ["worse", "worse"]
    store.add(night(verdict(), number=3, plan=plan))
    assert judge(store).tonight == ()
    assert standing(store) == ["campaign.class", "campaign.class"]


def test_a_small_repair_does_not_end_a_large_regression(store: NightStore) -> None:
    for k, value in enumerate((1e-5, 1e-2, 0.9e-2, 0.9e-2)):
        store.add(night(error(value), number=k))
    assert standing(store) == ["attitude.max"]
    store.add(night(error(1e-5), number=4))
    assert standing(store) == []


def test_a_regression_stands_longer_than_the_nights_that_are_followed_one_by_one(store: NightStore) -> None:
    for k in range(40):
        store.add(night(verdict("pass" if k < 3 else "inconsistent"), number=k))
    assert standing(store) == ["verdict"]


def test_an_acceptance_ends_when_the_figure_moves_away(store: NightStore) -> None:
    for k, word in enumerate(("pass", "inconsistent")):
        store.add(night(verdict(word), number=k))
    (first,) = judge(store).tonight
    (kept,) = acceptances_of([first], "Ada", LATER, "known")
    assert accepting(first, [kept], LATER) is kept
    for k, word in enumerate(("pass", "inconsistent"), start=2):
        store.add(night(verdict(word), number=k))
    (again,) = judge(store).tonight
    assert accepting(again, [kept], LATER) is None


def test_a_figure_that_a_baseline_of_the_same_plan_has_may_not_be_gone() -> None:
    before, after = night(error(), verdict(), number=0), night(verdict(), number=1)
    assert [change.identity.quantity for change in judge_pair(before, after).tonight] == ["attitude.max"]


def test_a_regression_that_was_partly_repaired_is_shown_and_accepted_as_it_is_now(store: NightStore) -> None:
    for k, value in enumerate((1e-5, 1e-2, 2e-5)):
        store.add(night(error(value), number=k))
    (change,) = still_holding(judge(store))
    assert (change.since[:10], results_words(change)) == ("2026-01-02", ("1e-05 rad", "2e-05 rad"))
    assert change.factor == pytest.approx(2.0)
    (entry,) = acceptances_of([change], "me", LATER, "known")
    assert (entry.was, entry.became) == ("1e-05 rad", "2e-05 rad")


def test_a_figure_that_a_night_had_no_time_for_is_not_counted_as_judged(store: NightStore) -> None:
    for k in range(2):
        store.add(night(error(), verdict(), number=k))
    store.add(night(error(None, reason=f"{NOT_RUN}: the machine was busy"), verdict(), number=2))
    judged = judge(store)
    assert (judged.tonight, judged.judged) == ((), 1)
