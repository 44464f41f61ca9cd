"""Steps of times: found when they are there, and hardly ever told when they are not."""

from __future__ import annotations

import math
import statistics

import numpy as np
import pytest
from scipy.stats import mannwhitneyu

from barchain.nightly.figures.rank_test import (
    FEWEST_NEW,
    LEVEL_NIGHTS,
    autocorrelations,
    split_levels,
    two_sided,
    upper_tail,
)
from barchain.nightly.figures.steps import FALSE_ALARMS, LEAST_EFFECT, find_steps
from tests.nightly.history.noise import alarms, nights_until_found, noise, told
from tests.support.slow import exhaustive_but


@pytest.mark.parametrize(("old", "new"), [(10, 2), (30, 4), (60, 6), (12, 30), (150, 12)])
def test_the_statistic_has_mann_and_whitneys_exact_distribution(old: int, new: int) -> None:
    random = np.random.default_rng(old)
    a, b = random.normal(size=old), random.normal(size=new) + 0.8
    excess = float(np.sum(b[:, None] > a[None, :]))
    own = two_sided(np.array([excess]), np.array([float(old)]), np.array([float(new)]))[0]
    assert own == pytest.approx(mannwhitneyu(b, a, method="exact").pvalue, rel=1e-9)


def test_the_smallest_probability_is_one_over_the_number_of_choices() -> None:
    for small, large in ((2, 30), (6, 60), (12, 200)):
        tail = upper_tail(small, large)
        assert tail[-1] == pytest.approx(1.0 / math.comb(small + large, small), rel=1e-9)
        assert tail[0] == pytest.approx(1.0)


def test_two_larger_groups_have_a_normal_tail_that_is_no_narrower() -> None:
    for size in (13, 16, 20):
        exact = mannwhitneyu(np.arange(size) + 100.0, np.arange(size), method="exact").pvalue
        ends = np.array([float(size)])
        assert two_sided(np.array([float(size * size)]), ends, ends)[0] >= exact


def test_too_few_nights_give_no_step() -> None:
    x = np.array([0.0, 0.001, 0.002] * 4)[: LEVEL_NIGHTS + FEWEST_NEW - 1]
    assert split_levels(x).min() == 1.0
    assert find_steps(x, 1.0) == ()


def test_a_step_after_five_nights_is_told_against_them() -> None:
    x = noise(9, 60, 30, 0.02, 0.3)
    x[:9, 5:] += math.log(1.5)
    found = [sum(bool(steps) for steps in told(x[:, :night])[:9]) for night in range(7, 31)]
    assert found[-1] >= 8
    assert all(steps == () for steps in told(x)[9:])


def test_probabilities_are_those_of_chance_alone() -> None:
    x = noise(1, 2000, 40, 0.02, 0.0)
    least = np.array([split_levels(row).min() for row in x])
    for level in (0.2, 0.05, 0.01):
        assert np.mean(least <= level) <= level + 3.0 * math.sqrt(level / len(x))


def test_the_autocorrelation_of_all_series_is_found_and_no_step_moves_it() -> None:
    x = noise(2, 100, 40, 0.02, 0.5, "normal")
    x[:, 20:] += 0.2
    found = statistics.median(autocorrelations(list(x)))
    assert 0.45 < found < 0.8


@pytest.mark.parametrize("size", [0.05, 0.2, 1.0])
def test_a_step_in_a_short_series_does_not_make_the_series_look_correlated(size: float) -> None:
    """With one disturbed difference left in, a step of 20 % was told later than one of 5 %."""
    x = noise(2, 25, 21, 0.005, 0.3, "normal")
    plain = autocorrelations(list(x))
    x[0, 12:] += size
    assert autocorrelations(list(x)) == pytest.approx(plain, abs=0.1)


@pytest.mark.parametrize("size", [0.1, 0.2, 1.0])
def test_a_larger_step_is_told_no_later(size: float) -> None:
    x = noise(2, 25, 21, 0.005, 0.3, "normal")

    def first_night(step: float) -> int:
        moved = x.copy()
        moved[0, 12:] += step
        return next(night for night in range(14, 22) if told(moved[:, :night])[0])

    assert first_night(size) <= first_night(0.08)


def test_constant_series_have_no_steps_and_a_constant_that_jumps_has_one() -> None:
    assert find_steps(np.zeros(60), 1e-3) == ()
    jumped = np.where(np.arange(60) < 50, 0.0, np.log(1.2))
    (step,) = find_steps(jumped, 1e-3)
    assert step.place == 50
    assert step.factor == pytest.approx(1.2)


def test_two_steps_are_told_apart() -> None:
    x = noise(3, 1, 90, 0.01, 0.2)[0]
    x[30:] += 0.2
    x[60:] -= 0.1
    found = find_steps(x, 1e-4, 0.3)
    assert [step.place for step in found] == pytest.approx([30, 60], abs=2)
    assert [step.factor for step in found] == pytest.approx([math.exp(0.2), math.exp(-0.1)], rel=0.03)
    assert all(step.low <= step.factor <= step.high for step in found)


def test_a_step_below_the_least_effect_is_not_told() -> None:
    x = noise(4, 1, 120, 0.002, 0.0)[0]
    x[60:] += np.log1p(LEAST_EFFECT) - 0.01
    assert split_levels(x).min() < 1e-6
    assert find_steps(x, 1e-4) == ()


def test_a_place_at_which_a_part_changed_is_preferred_among_places_that_fit_as_well() -> None:
    x = noise(5, 1, 60, 0.02, 0.0)[0]
    x[50:] += 0.1
    x[49] += 0.09  # an outlier before the step
    assert [step.place for step in find_steps(x, 1e-3)] == [49]
    assert [step.place for step in find_steps(x, 1e-3, likely={50})] == [50]
    assert [step.place for step in find_steps(x, 1e-3, likely={30})] == [49]


def test_a_step_after_too_few_nights_for_its_place_is_that_of_the_part_that_changed() -> None:
    x = noise(6, 1, 16, 0.01, 0.0)[0]
    x[9:] += 0.4  # places are tried from the tenth night on
    assert [step.place for step in find_steps(x, 0.01)] == [10]
    assert [step.place for step in find_steps(x, 0.01, likely={9})] == [9]
    assert [step.place for step in find_steps(x, 0.01, likely={8})] == [10]


def test_sixty_nights_without_a_step_ring_no_alarm() -> None:
    assert alarms(noise(0, 100, 72, 0.03, 0.5), 13) == []


def test_a_single_outlier_rings_no_alarm_however_large() -> None:
    x = noise(6, 50, 40, 0.02, 0.0)
    x[:, -1] += 3.0  # all series at once: the machine was busy
    assert all(steps == () for steps in told(x))


def test_a_slow_down_by_a_fifth_is_found_within_six_nights() -> None:
    found = [nights_until_found(seed, 0.2, 0.02, 60, 50, most=8) for seed in range(3)]
    assert all(n is not None and n <= 6 for n in found)


@pytest.mark.slow
@pytest.mark.parametrize("tails", exhaustive_but(["student", "normal", "outliers"], ["student"]))
@pytest.mark.parametrize("rho", exhaustive_but([0.0, 0.3, 0.6], [0.6]))
def test_false_alarms_over_sixty_nights_of_three_hundred_series_are_as_rare_as_derived(tails: str, rho: float) -> None:
    rung = len(set(alarms(noise(0, 300, 72, 0.03, rho, tails), 13)))
    expected = 60 * FALSE_ALARMS
    assert rung <= expected + math.sqrt(expected)  # one


@pytest.mark.exhaustive
def test_false_alarms_stay_rare_where_all_series_share_the_nights_noise() -> None:
    x = noise(7, 300, 72, 0.02, 0.3) + noise(8, 1, 72, 0.03, 0.5)
    assert len(set(alarms(x, 13))) <= 1


@pytest.mark.exhaustive
def test_nights_until_a_step_is_found() -> None:
    """Table of docs/howto/history.md: median nights of twelve histories, 300 series, noise of 2 %."""
    table = {}
    for size in (0.03, 0.05, 0.10, 0.20):
        found = [nights_until_found(seed, size, 0.02, 60, 300) for seed in range(12)]
        known = sorted(n for n in found if n is not None)
        table[size] = (len(known), statistics.median(known) if known else math.inf)
    assert table[0.03][0] <= 1
    assert table[0.10] == (12, pytest.approx(5, abs=1))
    assert table[0.20] == (12, pytest.approx(5, abs=1))
    assert table[0.05][0] >= 6
