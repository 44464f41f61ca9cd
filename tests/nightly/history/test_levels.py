"""Levels: what is worse than it was, since when and by what; news against what was told last."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.nightly.figures.changes import ROUNDING_LEVEL, Direction
from barchain.nightly.figures.figure import Figure
from barchain.nightly.figures.suspects import unknown_parts
from barchain.nightly.history.acceptances import accept, accepted
from barchain.nightly.history.judging import (
    FILE,
    folded_night,
    judge,
    read_levels,
)
from barchain.nightly.history.news import keep_judgement, left_out
from barchain.nightly.history.nights import open_store
from barchain.nightly.history.pruning import needed_nights
from barchain.nightly.history.standing import standing
from tests.nightly.history.synthetic import ENVIRONMENT, bits, count, error, night, ratio, verdict

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore

GOOD = 1e-5
NAME = error().identity.name
OTHER_CLASS = dataclasses.replace(ENVIRONMENT, cpu="Other CPU")


def add(store: NightStore, *factors: float | None, first: int | None = None) -> JudgedNight:
    """Add nights with these errors, relative to a good one; without the figure where there is none."""
    begin = len(store.nights()) if first is None else first
    for k, factor in enumerate(factors, start=begin):
        own = [error(factor * GOOD)] if factor is not None else []
        store.add(night(count(), *own, number=k))
        judged = judge(store)
        keep_judgement(store, judged)
    return judged


def red(store: NightStore) -> list[tuple[float | None, int]]:
    """Factor and number of steps of all that is worse than accepted on the last night."""
    states = standing(judge(store), accepted(store))
    return [(state.change.factor, state.change.steps) for state in states if state.acceptance is None]


def held(store: NightStore) -> list[float | None]:
    """Factors of all that is worse than it was, and accepted."""
    return [state.change.factor for state in standing(judge(store), accepted(store)) if state.acceptance is not None]


COURSES = {
    "two steps are open with their whole factor": ((1, 5, 6), set(), [(6, 2)], []),
    "an accepted small step leaves the large one before it open": ((1, 5, 6), {2}, [(5, 1)], []),
    "steps that were accepted one after the other are accepted together": ((1, 5, 6), {1, 2}, [], [6]),
    "an accepted step stays so once the open one before it is undone": ((1, 5, 6, 1.2), {2}, [], [1.2]),
    "two causes of errors do not multiply exactly": ((1, 5, 6, 1.2, 1.22), {2}, [], [1.22]),
    "the undone step is open if it comes back": ((1, 5, 6, 1.2, 1.22, 5), {2}, [(5 / 1.22, 1)], []),
    "an accepted step lets no larger one through once the open one is undone": (
        (1, 5, 6, 2), {2}, [(2 / 1.2, 1)], [],
    ),
    "what becomes better while it is worse than accepted is no step": ((1, 5, 3), set(), [(3, 1)], []),
    "what comes on top of an accepted step is relative to it": ((1, 5, 5, 6), {1}, [(1.2, 1)], []),
    "an accepted figure that became better stays accepted": ((1, 5, 3), {1}, [], [3]),
    "an accepted figure that became better may be no worse again": ((1, 5, 3, 5), {1}, [(5 / 3, 1)], []),
    "an acceptance ends where the figure is back at its level": ((1, 5, 1, 5), {1}, [(5, 1)], []),
    "a missing figure can be accepted": ((1, 1, None), {2}, [], [None]),
    "a figure that comes back worse is not accepted with its absence": ((1, 1, None, 10), {2}, [(10, 1)], []),
    "an improvement of two nights is no level": ((1, 0.2, 0.2, 1), set(), [], []),
    "an improvement is the level after three nights": ((1, 0.2, 0.2, 0.2, 1), set(), [(5, 1)], []),
    "the level is then the worst of these three": ((1, 0.2, 0.5, 0.3, 0.5), set(), [], []),
    "what is worse than the worst of these three is worse": ((1, 0.2, 0.5, 0.3, 0.5, 0.6), set(), [(1.2, 1)], []),
}  # fmt: skip
"""Errors of nights, relative to a good one, the nights whose news is accepted, and what is red or held in the end"""


@pytest.mark.parametrize(("factors", "accepting", "open_ones", "accepted_ones"), COURSES.values(), ids=list(COURSES))
def test_what_is_worse_is_measured_from_its_level_and_from_what_was_accepted(
    store: NightStore,
    factors: Sequence[float | None],
    accepting: set[int],
    open_ones: list[tuple[float, int]],
    accepted_ones: list[float | None],
) -> None:
    for k, factor in enumerate(factors):
        judged = add(store, factor)
        if k in accepting:
            accept(store, judged.tonight, "Ada", "meant")
    assert [steps for _, steps in red(store)] == [steps for _, steps in open_ones]
    assert [factor for factor, _ in red(store)] == pytest.approx([factor for factor, _ in open_ones])
    assert held(store) == pytest.approx(accepted_ones)


def test_a_drift_is_told_on_each_night_and_stands_with_its_whole_factor_since_its_first_step(store: NightStore) -> None:
    judged = add(store, *(1.3**k for k in range(6)))
    assert [change.factor for change in judged.tonight] == pytest.approx([1.3])
    (state,) = standing(judged)
    assert (state.change.factor, state.change.since) == (pytest.approx(1.3**5), store.nights()[1].name)


def test_a_figure_that_is_back_at_its_level_says_so(store: NightStore) -> None:
    (change,) = add(store, 1, 5, 1).tonight
    assert (change.direction, change.reason.partition(";")[0]) == (Direction.BETTER, "back at its level")
    assert red(store) == []


@pytest.mark.parametrize(("nights", "is_red"), [(2, False), (3, True)])
def test_the_end_of_an_improvement_is_worse_only_after_three_nights(
    store: NightStore, nights: int, is_red: bool
) -> None:
    assert [change.direction for change in add(store, 1, 0.2).tonight] == [Direction.BETTER]
    assert add(store, *[0.2] * (nights - 1)).tonight == ()
    judged = add(store, 1)
    assert [change.direction for change in judged.tonight] == [Direction.WORSE if is_red else Direction.CHANGED]


def test_noise_of_rounding_is_never_red(store: NightStore) -> None:
    random = np.random.default_rng(1)
    rounding = 1e-12
    for k in range(20):
        value = rounding * float(random.uniform(0.0, ROUNDING_LEVEL)) if k != 10 else 0.0
        store.add(night(error(value, tolerance=rounding), number=k))
        assert red(store) == []


def test_a_drift_that_begins_among_errors_of_rounding_stands_since_then(store: NightStore) -> None:
    """Of ×11 over three nights ×8 lie below 30 shares of rounding, where nothing is worse yet."""
    for number, shares in enumerate((4, 9, 20, 45)):
        store.add(night(error(shares * 1e-12, tolerance=1e-12), number=number))
    (state,) = standing(judge(store))
    assert (state.change.last, state.change.since) == tuple(one.name for one in store.nights()[0:3:2])
    assert (state.change.steps, state.latest) == (2, store.nights()[3].name)


def test_a_step_of_an_error_of_rounding_that_moved_little_before_is_its_own(store: NightStore) -> None:
    for number, shares in enumerate((4, 9, 5, 300)):
        store.add(night(error(shares * 1e-12, tolerance=1e-12), number=number))
    (state,) = standing(judge(store))
    assert (state.change.last, state.change.since) == tuple(one.name for one in store.nights()[2:])


@pytest.mark.parametrize(
    ("nights", "factors"),
    [
        ([("inconsistent", 1.0), ("inconsistent", 0.1), ("pass", 3.0)], []),
        ([("inconsistent", 1.0), ("inconsistent", 0.1), ("pass", 3.0), ("pass", 6.0)], [2.0]),
        ([("pass", 1.0), ("inconsistent", 1.0), ("pass", 2.0)], [2.0]),
    ],
)
def test_the_errors_of_a_wrong_result_bind_no_right_one_and_those_of_right_nights_do(
    store: NightStore, nights: list[tuple[str, float]], factors: list[float]
) -> None:
    for number, (word, factor) in enumerate(nights):
        own = verdict(word)
        own = dataclasses.replace(own, identity=dataclasses.replace(own.identity, setting=""))
        store.add(night(error(factor * GOOD), own, number=number))
    assert [factor for factor, _ in red(store)] == pytest.approx(factors)


def test_a_run_that_is_not_reproducible_is_red_on_its_night_only(store: NightStore) -> None:
    for k, word in enumerate(("aa", "bb", "bb")):
        store.add(night(bits(word), number=k))
    nights = [one.name for one in store.nights()]
    assert [judge(store, name).worse for name in nights] == [False, True, False]
    assert standing(judge(store)) == []


def test_a_late_night_begins_levels_that_were_not_there_and_changes_nothing_else(store: NightStore) -> None:
    add(store, 5, 5, first=10)
    store.add(night(count(), error(GOOD), error(GOOD, "new.max"), number=1))
    add(store, 5, first=12)
    assert red(store) == []
    store.add(night(count(), error(5 * GOOD), error(2 * GOOD, "new.max"), number=13))
    assert [state.change.identity.quantity for state in standing(judge(store))] == ["new.max"]


def test_a_night_that_is_voided_later_counts_no_longer(store: NightStore) -> None:
    add(store, 1, 5, 5)
    assert red(store) != []
    first, *_ = store.nights()
    record = store.place.read(f"{first.name}/record.json") or b""
    store.place.write(f"{first.name}/record.json", record.replace(b'"void": null', b'"void": "a fault was missed"'))
    assert red(store) == []


@pytest.mark.parametrize("damage", ["deleted", "flipped", "cut"])
def test_levels_that_a_night_lost_are_folded_again(store: NightStore, damage: str) -> None:
    for k in range(12):
        own = [error(1e-9 * (1 + k // 5), "moving.max"), verdict("pass" if k % 7 else "inconsistent")]
        gone = [error(GOOD, "gone.max")] if k < 6 else []
        store.add(night(*own, *gone, bits(str(k // 4)), ratio(), number=k))
        before = folded_night(store, store.summary("latest"), store.nights())
    assert len(before.table.rows) == 5
    for one in store.nights():
        content = store.place.read(f"{one.name}/{FILE}") or b""
        store.place.remove(f"{one.name}/{FILE}")
        if damage != "deleted":
            broken = content[:-20] if damage == "cut" else content[:200] + bytes([content[200] ^ 1]) + content[201:]
            store.place.write(f"{one.name}/{FILE}", broken)
    assert judge(store).tonight == before.news
    assert folded_night(store, store.summary("latest"), store.nights()) == before


@pytest.mark.parametrize("copied", ["latest", "earlier"])
def test_nights_from_another_history_hide_nothing_that_is_open(store: NightStore, tmp_path: Path, copied: str) -> None:
    other = open_store(str(tmp_path / "other"), create=True)
    if copied == "latest":
        add(store, 1, 5, 5)
        add(other, 5, first=3)
    else:
        add(other, 20, 6, first=3)
        add(store, 1, 5, 5, first=10)
    for name in other.place.sizes("*/*"):
        store.place.write(name, other.place.read(name) or b"")
    assert read_levels(store.place, other.nights()[0]) is not None
    assert red(store) == [(pytest.approx(5.0), 1)]
    add(store, 5, first=13)
    assert red(store) == [(pytest.approx(5.0), 1)]


def test_that_a_missing_figure_is_accepted_accepts_no_step_before_it(store: NightStore) -> None:
    add(store, 1, 5)
    for k in (2, 3):
        store.add(night(count(), Figure(error().identity, reason="the program is not there"), number=k))
        judged = judge(store)
        keep_judgement(store, judged)
        if k == 2:
            accept(store, [change for change in judged.tonight if change.now.missing], "me", "on its way")
    assert red(store) == [(pytest.approx(5.0), 1)]


def test_what_an_earlier_night_told_is_no_loss_if_its_file_is_damaged(store: NightStore) -> None:
    add(store, 1, 5, 5)
    path = f"{store.nights()[1].name}/told.json"
    store.place.write(path, b"{")
    assert red(store) == [(pytest.approx(5.0), 1)]
    assert path in left_out(store)


def test_the_night_after_pruned_ones_is_not_the_first(store: NightStore) -> None:
    add(store, 1, 1, 1)
    store.prune(keep=1)
    assert not judge(store).is_first


def test_parts_behind_a_change_since_a_pruned_night_are_unknown(store: NightStore) -> None:
    judged = add(store, 1, 1, 5)
    (change,) = judged.tonight
    assert unknown_parts(change, judged.by_name) == ()
    (unknown,) = unknown_parts(change, {judged.night.name: judged.night})
    assert change.last in unknown


def test_a_night_whose_damage_was_not_seen_tells_nothing_and_costs_itself_alone(store: NightStore) -> None:
    before = add(store, 1, 1, 5)
    last = night(error(5 * GOOD), number=3)
    store.add(last)
    path = f"{last.name}/figures.parquet"
    store.place.write(path, b"x" * len(store.place.read(path) or b""))
    assert judge(store, last.name).tonight == ()
    assert judge(store).night == before.night
    assert judge(store).tonight == before.tonight != ()


def test_what_is_worse_stays_so_when_nights_are_pruned(store: NightStore) -> None:
    add(store, 1, 1, 1, 5, 5, 6, *[6] * 10)
    before = red(store)
    assert len(store.prune(keep=1, spared=needed_nights(store))) > 8
    assert red(store) == before
    (state,) = standing(judge(store))
    assert {state.change.last, state.change.since, state.latest} <= {one.name for one in store.nights()}
    add(store, 6, first=16)
    assert red(store) == before


def test_a_time_that_moved_before_there_are_enough_nights_is_told_as_such(store: NightStore) -> None:
    for k in range(8):
        store.add(night(ratio(1.5 if k > 5 else 1.0 + 0.001 * k), ratio(1.0, "still"), number=k))
    judged = judge(store)
    assert judged.tonight == ()
    assert judged.so_far.endswith("time_ratio/reference-fast: ×1.5 so far, 8 of the 12 nights that a step needs")


def test_each_machine_has_levels_of_its_own(store: NightStore) -> None:
    def of(number: int, factor: float, *, other: bool) -> Sequence[float | None]:
        environment = OTHER_CLASS if other else ENVIRONMENT
        store.add(night(error(factor * GOOD), number=number, environment=environment))
        return [factor for factor, _ in red(store)]

    assert of(0, 1, other=False) == []
    assert of(1, 2, other=True) == pytest.approx([2.0])
    assert of(2, 1, other=False) == []
    assert of(3, 2, other=True) == pytest.approx([2.0])
