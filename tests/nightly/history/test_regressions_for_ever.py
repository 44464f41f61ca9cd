"""A regression stands until it is undone or accepted: after years, on new machines, after pruning, in rotations."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.nightly.documents import exit_code
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import Direction
from barchain.nightly.figures.figure import Figure, FigureKind, FigureUnit, NightPart
from barchain.nightly.history.acceptances import accept
from barchain.nightly.history.judging import changes_named, judge, judge_pair
from barchain.nightly.history.pruning import needed_nights
from barchain.nightly.history.standing import every_change, still_holding
from barchain.nightly.telling.document import night_facts
from reports.results.nights.document import NightRun, PartResult, PartState
from tests.nightly.history.synthetic import ENVIRONMENT, NAMES, PARTS, bits, error, identity, night, ratio, verdict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.nights import NightStore
    from reports.results.nights.document import NightlyFile

LONG = 60
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


def test_a_scene_added_later_is_followed_as_one_of_the_first_night(store: NightStore) -> None:
    for k in range(LONG):
        own = [error(1e-9 if k < 10 else 1e-5)] if k >= 5 else []
        store.add(night(error(1e-3, "other.max"), *own, number=k))
    assert red(store)


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


def test_a_change_that_came_with_a_new_machine_stands_on_its_later_nights(store: NightStore) -> None:
    for k in range(8):
        environment = ENVIRONMENT if k < 5 else OTHER_CLASS
        store.add(night(error(1e-9 if k < 5 else 1e-5), number=k, environment=environment))
        assert red(store) is (k >= 5)


def test_an_acceptance_that_ended_does_not_come_back(store: NightStore) -> None:
    for k in range(LONG):
        store.add(night(error(1e-5 if 5 <= k < 8 or k >= 10 else 1e-9), number=k))
        if k == 5:
            accept(store, judge(store).tonight[:1], "Ada", "known")
            assert not red(store)
    assert red(store)


def test_pruning_spares_the_nights_that_a_regression_is_compared_with(store: NightStore) -> None:
    for k in range(20):
        store.add(night(error(1e-9 if k < 5 else 1e-5), verdict(), number=k))
    gone = store.prune(keep=3, spared=needed_nights(store))
    assert len(gone) > 10
    assert red(store)


@pytest.mark.slow
@pytest.mark.parametrize("period", [1, 2, 7])
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


@pytest.mark.parametrize(("scenes", "told"), [(["paper/fig13"], True), (["paper/fig05"], False)])
def test_in_an_incomplete_night_an_engine_must_be_there_where_its_scene_was_done(
    store: NightStore, scenes: Sequence[str], told: bool
) -> None:
    for k in range(5):
        engines = ("mujoco", "pymunk") if k < 4 else ("mujoco",)
        store.add(night(*map(of, engines), number=k, complete=k < 4), run=left(*scenes) if k == 4 else None)
    assert red(store) is told


def test_a_disappearance_still_stands_on_an_incomplete_night(store: NightStore) -> None:
    for k in range(6):
        engines = ("mujoco", "pymunk") if k < 4 else ("mujoco",)
        store.add(night(*map(of, engines), number=k, complete=k < 5))
    assert red(store)


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


def test_a_baseline_without_a_common_figure_is_no_agreement(store: NightStore) -> None:
    before, after = night(error(quantity="reaction.max"), plan="other"), night(error(), number=1)
    told = night_facts(store, judge_pair(before, after), after, "release")
    assert exit_code(told, "worse") is ExitCode.NOT_BELIEVED
    assert told.sentence.startswith("Nothing was compared")


def test_bits_are_compared_with_the_last_night_of_the_same_parts_however_long_ago(store: NightStore) -> None:
    newer = (NightPart("engine:mujoco", "3.4.0", "ff"), *PARTS[1:])
    for k in range(LONG):
        store.add(night(bits("bb" if k == LONG - 1 else "aa"), number=k, parts=newer if k in {3, LONG - 1} else PARTS))
    (change,) = judge(store).tonight
    assert change.irreproducible


def test_a_figure_of_two_nights_far_apart_is_judged(store: NightStore) -> None:
    for k in range(LONG):
        rare = [error(1e-5, "rare.max")] if k in {0, LONG - 1} else []
        store.add(night(error(), *rare, number=k))
    assert judge(store).judged == 2


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
