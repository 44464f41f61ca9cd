"""No regression is lost: not over many nights, behind gaps, rotations, incomplete nights or partial repairs."""

from __future__ import annotations

import dataclasses
import datetime
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.nightly.documents import exit_code
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import Direction, results_words
from barchain.nightly.figures.figure import Figure, FigureKind, FigureUnit, NightPart
from barchain.nightly.history.acceptances import acceptances_of
from barchain.nightly.history.judging import changes_named, judge, judge_pair
from barchain.nightly.history.standing import every_change, still_holding
from barchain.nightly.telling.document import night_facts
from reports.results.nights.document import NightRun, PartResult, PartState
from reports.results.rows import NOT_RUN
from tests.nightly.history.synthetic import ENVIRONMENT, NAMES, PARTS, bits, error, identity, night, ratio, verdict

if TYPE_CHECKING:
    from barchain.nightly.history.nights import NightStore
    from reports.results.nights.document import NightlyFile

LONG = 40
OTHER_CLASS = dataclasses.replace(ENVIRONMENT, cpu="Other CPU")


def facts(store: NightStore) -> NightlyFile:
    return night_facts(store, judge(store), store.night("latest"))


def red(store: NightStore) -> bool:
    return exit_code(facts(store), "worse") is ExitCode.FINDINGS


def of(engine: str, scene: str = "paper/fig05") -> Figure:
    own = identity(unit=FigureUnit.RADIAN, engine=engine, scene=scene)
    return Figure(own, 1e-3, tolerance=1e-9, depends=NAMES)


def hard(word: str) -> Figure:
    return Figure(identity("stability.outcome", FigureKind.VERDICT, scene="hard/x"), word=word, depends=NAMES)


def test_a_scene_of_every_seventh_night_stays_red(store: NightStore) -> None:
    for k in range(LONG):
        own = [hard("stable" if k < 17 else "unstable")] if k % 7 == 3 else []
        store.add(night(error(), *own, number=k))
    assert red(store)


def test_a_standing_change_keeps_its_night_name_and_suspect(store: NightStore) -> None:
    seen = set()
    for k in range(LONG):
        engine = NightPart("engine:mujoco", "3.3.0", "aa" if k < 10 else "a2")
        adapter = NightPart("adapter:mujoco", "0.6.0", f"b{k // 20}")
        store.add(night(error(1e-9 if k < 10 else 1e-5), number=k, parts=(engine, adapter, *PARTS[2:])))
        if k in {11, 27, LONG - 1}:
            (entry,) = facts(store).standing
            seen.add((entry.id, entry.since, tuple(suspect.name for suspect in entry.suspects)))
    assert [suspects for _, _, suspects in seen] == [("engine:mujoco",)]


@pytest.mark.slow
@pytest.mark.parametrize("period", [1, 7])
def test_an_engine_that_disappears_is_told_and_stays_told(store: NightStore, period: int) -> None:
    """Also if its scenes are divided among nights."""
    told = []
    for k in range(6 * period):
        scene = f"paper/{k % period}"
        engines = ("mujoco", "pymunk") if k < 3 * period else ("mujoco",)
        store.add(night(*(of(engine, scene) for engine in engines), number=k))
        told.append(red(store))
    assert told == [k >= 3 * period for k in range(6 * period)]


def left(*scenes: str) -> NightRun:
    part = PartResult("core", PartState.LEFT, 10.0, 10.0, scenes, "interrupted", 1, "barchain compare paper")
    return NightRun("plan", 1.0, (part,))


@pytest.mark.parametrize(("scene", "told"), [("paper/fig13", True), ("paper/fig05", False)])
def test_in_an_incomplete_night_an_engine_must_be_there_where_its_scene_was_done(
    store: NightStore, scene: str, told: bool
) -> None:
    part = PartResult("core", PartState.LEFT, 10.0, 10.0, (scene,), "interrupted", 1, "barchain compare paper")
    for k in range(4):
        store.add(night(of("mujoco"), of("pymunk"), number=k))
    store.add(night(of("mujoco"), number=4, complete=False), run=NightRun("plan", 1.0, (part,)))
    assert red(store) is told


def test_small_drifts_of_an_error_without_rounding_add_up(store: NightStore) -> None:
    directions = []
    for k in range(4):
        store.add(night(error(1e-5 * 1.009**k, tolerance=None), number=k))
        directions += [change.direction for change in judge(store).tonight]
    assert directions == [Direction.CHANGED, Direction.WORSE, Direction.CHANGED]


def test_a_void_night_is_not_judged_against_a_baseline_either(store: NightStore) -> None:
    before, after = night(error(1e-9)), night(error(1e-5), number=1, void="a fault was missed")
    judged = judge_pair(before, after)
    assert judged.tonight == ()
    told = night_facts(store, judged, after, "release")
    assert exit_code(told, "worse") is ExitCode.NOT_BELIEVED
    assert "void" in told.sentence


def test_bits_are_compared_with_the_last_night_of_the_same_parts_however_long_ago(store: NightStore) -> None:
    newer = (NightPart("engine:mujoco", "3.4.0", "ff"), *PARTS[1:])
    for k in range(LONG):
        store.add(night(bits("bb" if k == LONG - 1 else "aa"), number=k, parts=newer if k in {3, LONG - 1} else PARTS))
    (change,) = judge(store).tonight
    assert change.irreproducible


@pytest.mark.parametrize("other", [{"plan": "another"}, {"environment": OTHER_CLASS}])
def test_what_is_gone_stays_gone_on_another_plan_or_machine(store: NightStore, other: dict[str, object]) -> None:
    for k in range(12):
        lost = [error(1e-5, "lost.max")] if k < 4 else []
        store.add(night(error(), *lost, number=k, **(other if k >= 8 else {})))
        assert red(store) is (k >= 4)


def test_a_recovered_slow_down_holds_no_longer_and_a_step_keeps_its_name(store: NightStore) -> None:
    random = np.random.default_rng(0)
    for k in range(90):
        level = 3.0 if 30 <= k < 60 else 2.0
        store.add(night(ratio(level * float(np.exp(0.01 * random.standard_normal()))), number=k))
    nights = [one.name for one in store.nights()]
    assert len({c.id for name in nights[45:55] for c in every_change(judge(store, name))}) == 1
    assert still_holding(judge(store, nights[55]))
    assert not still_holding(judge(store))


def test_a_run_that_is_not_reproducible_is_not_accepted_by_a_pattern(store: NightStore) -> None:
    store.add(night(bits("aa"), number=0))
    store.add(night(bits("bb"), number=1))
    with pytest.raises(HistoryError, match="not reproducible can't be accepted"):
        changes_named(judge(store), "*")


def standing(store: NightStore) -> list[str]:
    judged = judge(store)
    return [
        change.identity.quantity for change in (*judged.tonight, *still_holding(judged)) if change.direction == "worse"
    ]


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


def test_a_figure_that_a_baseline_of_the_same_plan_has_may_not_be_gone() -> None:
    before, after = night(error(), verdict(), number=0), night(verdict(), number=1)
    assert [change.identity.quantity for change in judge_pair(before, after).tonight] == ["attitude.max"]


def test_a_regression_that_was_partly_repaired_is_shown_and_accepted_as_it_is_now(store: NightStore) -> None:
    for k, value in enumerate((1e-5, 1e-2, 2e-5)):
        store.add(night(error(value), number=k))
    (change,) = still_holding(judge(store))
    assert (change.since[:10], results_words(change)) == ("2026-01-02", ("1e-05 rad", "2e-05 rad"))
    assert change.factor == pytest.approx(2.0)
    (entry,) = acceptances_of([change], "me", datetime.datetime.now(datetime.UTC), "known")
    assert (entry.was, entry.became) == ("1e-05 rad", "2e-05 rad")


def test_a_figure_that_a_night_had_no_time_for_is_not_counted_as_judged(store: NightStore) -> None:
    for k in range(2):
        store.add(night(error(), verdict(), number=k))
    store.add(night(error(None, reason=f"{NOT_RUN}: the machine was busy"), verdict(), number=2))
    judged = judge(store)
    assert (judged.tonight, judged.judged) == ((), 1)
