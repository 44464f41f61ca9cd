"""Told changes are held: steps of times, names of changes, acceptances of several changes."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures import steps
from barchain.nightly.figures.changes import Direction
from barchain.nightly.figures.figure import FigureKind, FigureUnit
from barchain.nightly.figures.steps import LEAST_EFFECT, find_steps
from barchain.nightly.history.acceptances import accept, accepted, accepting
from barchain.nightly.history.judging import change_named, changes_named, judge
from barchain.nightly.history.news import keep_judgement, steps_before, told_by
from barchain.nightly.history.pruning import needed_nights
from barchain.nightly.history.standing import every_change, still_holding
from tests.nightly.history.noise import Array, noise, told
from tests.nightly.history.synthetic import Figure, bits, error, identity, night, ratio
from tests.support.slow import exhaustive_but

if TYPE_CHECKING:
    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore

QUANTITY = "time_ratio"
LATER = datetime.datetime(2100, 1, 1, tzinfo=datetime.UTC)


def ratios(*values: float) -> list[Figure]:
    """Figures of a night."""
    return [ratio(value, f"{QUANTITY}.{k}") for k, value in enumerate(values)]


def is_red(judged: JudgedNight) -> bool:
    """Whether a change for the worse is new on a night, or still holds."""
    return any(change.direction is Direction.WORSE for change in (*judged.tonight, *still_holding(judged)))


def run_night(store: NightStore, number: int, *values: float) -> bool:
    """Add a night of some ratios, keep what it tells, and give whether it is red."""
    store.add(night(*ratios(*values), number=number))
    judged = judge(store)
    keep_judgement(store, judged)
    return is_red(judged)


def run_nights(store: NightStore, x: Array) -> list[bool]:
    """Add nights of ratios with the logarithms (series, nights), and give which are red."""
    return [run_night(store, k, *np.exp(column)) for k, column in enumerate(x.T)]


@pytest.mark.parametrize("seed", exhaustive_but([21, 24, 36], [24]))
@pytest.mark.slow
def test_a_slow_down_near_the_threshold_does_not_turn_green_and_red_in_turns(seed: int, store: NightStore) -> None:
    x = noise(seed, 6, 60, 0.02, 0.3)
    x[0, 30:] += 0.08
    alone = [bool(told(x[:, : k + 1])[0]) for k in range(60)]
    first = alone.index(True)
    assert not all(alone[first:])  # the step is clear enough on some nights only
    red = run_nights(store, x)
    assert red == [k >= first for k in range(60)]


def test_a_held_step_is_given_up_where_the_levels_no_longer_differ() -> None:
    x = noise(13, 1, 80, 0.01, 0.0)[0]
    known = {40: True}
    for size, held in ((0.6 * LEAST_EFFECT, True), (0.3 * LEAST_EFFECT, False), (-0.05, False)):
        moved = x.copy()
        moved[40:] += size
        found = find_steps(moved, 1e-12, told=known)
        assert [step.held for step in found if step.factor > 1.0] == [True] * held


@pytest.mark.parametrize("second", [0.1, 0.7, -0.1])
def test_a_second_step_of_a_figure_is_told_as_soon_as_a_first_one(second: float) -> None:
    """Also where nobody recorded the first one: the clearest step of a night is no measure for the others."""
    x = noise(0, 20, 112, 0.02, 0.3)
    x[0, 60:] += 0.1
    x[0, 100:] += second
    assert any(len(told(x[:, :night])[0]) == 2 for night in range(101, 112))


@pytest.mark.exhaustive
def test_a_doubling_after_an_accepted_slow_down_is_told(store: NightStore) -> None:
    x = noise(15, 4, 70, 0.01, 0.0)
    x[0, 30:] += 0.1
    x[0, 45:] += 0.69
    for k in range(70):
        run_night(store, k, *np.exp(x[:, k]))
        if k == 44:
            accept(store, still_holding(judge(store)), "Ada", "more checks")
    red = [c for c in still_holding(judge(store)) if accepting(c, accepted(store), LATER) is None]
    assert [c.factor for c in red] == pytest.approx([2.0], rel=0.05)
    assert [c.factor for c in every_change(judge(store))] == pytest.approx([1.1, 2.0], rel=0.05)


def test_a_step_whose_first_night_was_not_judged_is_held(store: NightStore) -> None:
    x = noise(21, 6, 60, 0.02, 0.3)
    x[0, 30:] += 0.08
    red = []
    for k in range(48):
        store.add(night(*ratios(*np.exp(x[:, k])), number=k))
        if k > 35:  # the first clear night, 35, was judged against a baseline, say
            judged = judge(store)
            keep_judgement(store, judged)
            red.append(bool(judged.tonight or still_holding(judged)))
    assert all(red)


@pytest.mark.slow
def test_a_step_keeps_its_name_when_its_first_night_is_resumed(store: NightStore) -> None:
    x = noise(17, 4, 50, 0.01, 0.0)
    x[0, 30:] += 0.3
    for k in range(50):
        store.add(night(*ratios(*np.exp(x[:, k])), number=k, complete=k != 30, label="cut"))
        keep_judgement(store, judge(store))
    (before,) = every_change(judge(store))
    store.add(night(*ratios(*np.exp(x[:, 30])), error(), number=30, label="cut"))
    (after,) = every_change(judge(store))
    assert judge(store).tonight == ()
    assert after.id == before.id
    assert steps_before(told_by(store), judge(store).night.name)[after.identity.name] == [(after.since, True)]


def test_a_busy_night_tells_no_step_again(store: NightStore) -> None:
    for k in range(32):
        values = 1.5 if k >= 20 else 1.0 + 0.001 * (k % 3), 1.0 + 0.001 * (k % 3)
        if k < 20:
            store.add(night(*ratios(*values), number=k))
        else:
            run_night(store, k, *values)
    busy = [
        Figure(ratio(1.0, f"{QUANTITY}.{k}").identity, reason="other processes used 1.2 processors") for k in (0, 1)
    ]
    store.add(night(*busy, number=32))
    judged = judge(store)
    assert judged.tonight == ()
    assert [c.direction for c in still_holding(judged)] == [Direction.WORSE]


def test_a_figure_that_is_gone_stays_red_longer_than_steps_are_looked_for(
    store: NightStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(steps, "WINDOW", 30)
    for k in range(45):
        own = [ratio(1.0 + 0.001 * (k % 3), "gone")] if k < 12 else []
        store.add(night(error(), *own, number=k))
    assert [c.identity.quantity for c in still_holding(judge(store))] == ["gone"]


def test_of_several_changes_all_are_accepted_or_none(store: NightStore) -> None:
    store.add(night(error(1e-5), bits("aa"), number=0))
    store.add(night(error(3e-5), bits("bb"), number=1))
    judged = judge(store)
    assert len(judged.tonight) == 2
    with pytest.raises(HistoryError, match="nothing was accepted"):
        accept(store, judged.tonight, "Ada", "known")
    assert accepted(store) == ()


@pytest.mark.exhaustive
def test_a_step_that_is_given_up_hides_no_real_one_beside_it(store: NightStore) -> None:
    """A speed-up is told, and a few nights later the figure is slower than it ever was."""
    x = noise(1, 6, 80, 0.02, 0.3)
    x[0, 40:] -= 0.11
    x[0, 46:] += 0.26
    red = run_nights(store, x)
    assert red[-1]
    assert all(red[red.index(True) :])


@pytest.mark.exhaustive
def test_pruning_keeps_an_accepted_step_accepted(store: NightStore) -> None:
    x = noise(19, 4, 100, 0.01, 0.0)
    x[0, 30:] += 0.2
    x[1, 60:] += 0.2
    run_nights(store, x)
    second = max(still_holding(judge(store)), key=lambda c: c.since)
    accept(store, [second], "Ada", "more checks")
    store.prune(keep=20, spared=needed_nights(store))
    run_night(store, 100, *np.exp(x[:, 99]))
    held = {c.identity: accepting(c, accepted(store), LATER) is not None for c in still_holding(judge(store))}
    assert held[second.identity]
    assert sorted(held.values()) == [False, True]


def test_a_report_of_an_earlier_night_changes_no_name(store: NightStore) -> None:
    x = noise(3, 6, 60, 0.02, 0.3)
    x[0, 30:] += 0.12
    for k in range(60):
        store.add(night(*ratios(*np.exp(x[:, k])), number=k))
    nights = [each.name for each in store.nights()]
    keep_judgement(store, judge(store, nights[45]))
    keep_judgement(store, judge(store))
    before = [c.id for c in every_change(judge(store))]
    for k in (40, 38, 36, 35, 34):
        keep_judgement(store, judge(store, nights[k]))
    assert [c.id for c in every_change(judge(store))] == before != []


def test_figures_of_one_name_and_two_units_are_accepted_both(store: NightStore) -> None:
    def both(number: int, value: float) -> None:
        places = (identity(unit=FigureUnit.RADIAN), identity(unit=FigureUnit.METRE))
        store.add(night(*(Figure(i, value, tolerance=1e-12) for i in places), number=number))

    both(0, 1e-5)
    both(1, 2e-5)
    assert len(changes_named(judge(store), "*")) == 2
    assert len(changes_named(judge(store), identity(unit=FigureUnit.METRE).name)) == 2
    assert change_named(judge(store), identity(unit=FigureUnit.METRE).name).identity.kind is FigureKind.ERROR
