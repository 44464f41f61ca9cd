"""Rules of change, one for each kind of figure."""

from __future__ import annotations

import dataclasses
import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from barchain.nightly.figures.changes import (
    Direction,
    compared,
    judge_number,
    judge_verdict,
)
from barchain.nightly.figures.figure import Figure, FigureKind, FigureUnit, NightPart
from barchain.nightly.history.standing import still_holding
from reports.results.outcome import Outcome
from tests.nightly.history.histories import folded, history_of, judged_last, news_of
from tests.nightly.history.synthetic import NAMES, PARTS, bits, count, error, identity, verdict


def value(number: float, low: float | None = None, high: float | None = None, tolerance: float | None = None) -> Figure:
    own = identity("order", FigureKind.VALUE, unit=FigureUnit.ONE)
    return Figure(own, number, "", low, high, tolerance, depends=NAMES)


def other(name: str, digest: str = "ff") -> tuple[NightPart, ...]:
    return tuple(dataclasses.replace(p, digest=digest) if p.name == name else p for p in PARTS)


def test_errors_within_rounding_are_numerically_the_same_and_beyond_better_or_worse() -> None:
    was = error(1e-5, tolerance=1e-9)
    assert judge_number(was, error(1e-5, tolerance=1e-9)) is None
    within = judge_number(was, error(1e-5 + 1.9e-9, tolerance=1e-9))
    assert within.direction is Direction.SAME
    beyond = judge_number(was, error(1e-5 + 2.1e-9, tolerance=1e-9))
    assert beyond.direction is Direction.WORSE
    half = judge_number(was, error(5e-6, tolerance=1e-9))
    assert (half.direction, half.factor) == (Direction.BETTER, pytest.approx(0.5))


def test_an_error_without_recorded_rounding_is_never_called_the_same() -> None:
    was = error(1e-5, tolerance=None)
    assert judge_number(was, error(1.000001e-5, tolerance=None)).direction is Direction.CHANGED
    assert judge_number(was, error(1.1e-5, tolerance=None)).direction is Direction.WORSE
    assert judge_number(was, error(1.1e-5, tolerance=1.0)).direction is Direction.WORSE
    judged = judge_number(error(0.0), error(1e-3))
    assert (judged.direction, judged.factor) == (Direction.WORSE, None)


@given(a=st.floats(0.0, 1e3), b=st.floats(0.0, 1e3), ta=st.floats(0.0, 1.0), tb=st.floats(0.0, 1.0))
def test_the_rule_of_errors_is_the_same_both_ways(a: float, b: float, ta: float, tb: float) -> None:
    there, back = (
        judge_number(error(a, tolerance=ta), error(b, tolerance=tb)),
        judge_number(error(b, tolerance=tb), error(a, tolerance=ta)),
    )
    assert (there is None) == (back is None)
    if there is not None and back is not None:
        assert {there.direction, back.direction} in ({Direction.SAME}, {Direction.BETTER, Direction.WORSE})


def test_small_steps_within_rounding_do_not_add_up_unseen() -> None:
    nights = history_of(*[[error(1e-5 + k * 0.7e-9, tolerance=1e-9)] for k in range(8)])
    found = news_of(nights)
    assert [c.since for c in found] == [nights[3].name, nights[6].name]
    assert [c.direction for c in found] == [Direction.WORSE, Direction.WORSE]
    assert folded(nights)[-1].same == 1


def test_an_error_of_rounding_is_told_when_it_moves_and_is_never_worse() -> None:
    """Below 30 shares of rounding another order of additions decides how large an error is."""
    small, large, far = (error(x, tolerance=1e-12) for x in (3e-12, 2e-11, 2e-10))
    nights = history_of([small], [large], [large], [small])
    assert [change.direction for change in news_of(nights)] == [Direction.CHANGED, Direction.BETTER]
    assert still_holding(judged_last(history_of([small], [large], [large]))) == []
    (change,) = news_of(history_of([small], [far]))
    assert change.direction is Direction.WORSE


def test_an_error_of_the_centre_of_mass_beyond_its_bound_of_rounding_is_worse() -> None:
    """A program of order 4 on a circular orbit, its errors three times as large: ten shares."""
    (change,) = news_of(history_of(*[[error(x, "com.max", tolerance=5.85e-5)] for x in (1.97e-4, 5.93e-4)]))
    assert change.direction is Direction.WORSE


def test_every_flip_of_a_verdict_is_told_with_its_direction() -> None:
    for was, now in itertools.product(Outcome, Outcome):
        judged = judge_verdict(verdict(str(was)), verdict(str(now)))
        assert (judged is None) == (was is now)
        if judged is not None:
            assert judged.direction in {Direction.BETTER, Direction.WORSE}
            if was.ok and not now.ok:
                assert judged.direction is Direction.WORSE


@pytest.mark.parametrize(
    ("was", "now", "direction"),
    [
        ("stable", "drifting", Direction.WORSE),
        ("killed", "survives", Direction.WORSE),
        ("clean", "false alarm", Direction.WORSE),
        ("missed", "caught", Direction.BETTER),
        ("relevant", "negligible", Direction.CHANGED),
    ],
)
def test_each_study_has_its_own_scale(was: str, now: str, direction: Direction) -> None:
    assert judge_verdict(verdict(was), verdict(now)).direction is direction


def test_counts_are_exact_and_values_change_where_their_intervals_part() -> None:
    assert compared(count(1000), count(1001)).direction is Direction.CHANGED
    assert compared(value(2.0, 1.9, 2.1), value(2.15, 2.05, 2.2)).direction is Direction.SAME
    assert compared(value(2.0, 1.9, 2.1), value(2.4, 2.3, 2.5)).direction is Direction.CHANGED
    assert compared(value(2.0, tolerance=0.1), value(2.15, tolerance=0.1)).direction is Direction.SAME
    assert compared(value(2.0), value(2.0 + 1e-15)).direction is Direction.CHANGED


def test_a_figure_that_is_missing_is_no_agreement() -> None:
    gone = Figure(error().identity, reason="timed out", depends=NAMES)
    assert compared(error(), gone).direction is Direction.WORSE
    assert "timed out" in compared(error(), gone).reason
    assert compared(gone, error()).direction is Direction.BETTER
    assert compared(gone, gone) is None


def test_equal_parts_with_other_bits_are_not_reproducible_and_told_first() -> None:
    nights = history_of([bits("aa"), error(1e-5)], [bits("bb"), error(2e-5)])
    judged = judged_last(nights)
    assert judged.tonight[0].irreproducible
    assert "not reproducible" in judged.tonight[0].reason
    assert judged.worse


def test_other_parts_may_give_other_bits() -> None:
    nights = history_of([bits("aa")], [bits("bb")], parts={1: other("engine:mujoco")})
    (change,) = judged_last(nights).tonight
    assert change.direction is Direction.CHANGED
    assert not change.irreproducible


def test_parts_that_come_back_must_bring_their_bits_back() -> None:
    parts = {1: other("engine:mujoco")}
    back = history_of([bits("aa")], [bits("bb")], [bits("aa")], parts=parts)
    assert not any(c.irreproducible for c in news_of(back))
    elsewhere = history_of([bits("aa")], [bits("bb")], [bits("cc")], parts=parts)
    last = news_of(elsewhere)[-1]
    assert last.irreproducible
    assert last.last == elsewhere[0].name


def test_without_digests_nothing_is_called_irreproducible() -> None:
    unknown = tuple(dataclasses.replace(p, digest="") for p in PARTS)
    nights = history_of([bits("aa")], [bits("bb")], parts={0: unknown, 1: unknown})
    (change,) = judged_last(nights).tonight
    assert not change.irreproducible
    assert "not known" in change.reason


def test_a_vanished_figure_is_told_and_one_that_is_measured_now_and_then_is_not() -> None:
    full, less = [error(), verdict()], [verdict()]
    gone = history_of(full, full, less)
    (change,) = judged_last(gone).tonight
    assert change.now.missing
    assert change.direction is Direction.WORSE
    rotating = history_of(full, less, full, less)
    assert judged_last(rotating).tonight == ()
    interrupted = history_of(full, full, less, complete={2: False})
    assert judged_last(interrupted).tonight == ()
