"""The measured order against the declared one; an error that follows the setting passes, one that stays fails."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from barchain.conform.accuracy import bound_check, falling_check, order_check, request_check
from barchain.conform.checks import CheckState
from barchain.conform.errors_at_settings import Compared, ErrorAtSetting


def errors(order: float, *settings: float, error: float = 1e-4) -> list[ErrorAtSetting]:
    """Errors that fall with an order, from a first one on."""
    made = [Setting(AccuracyParameter.STEPS_PER_ORBIT, s) for s in settings]
    finer = [settings[0] / s for s in settings]
    grows, none = np.array([0.0, 0.5, 1.0]), np.zeros(3)
    return [
        ErrorAtSetting(s, f, {"attitude": error * grows * f**order}, none, True, 0.1, s.value)
        for s, f in zip(made, finer, strict=True)
    ]


@pytest.mark.parametrize(
    ("measured", "steps", "state"),
    [
        (3.6, (100, 200, 400), CheckState.PASSED),
        (3.4, (100, 200, 400), CheckState.FAILED),
        (5.2, (100, 200, 400), CheckState.WARNING),
        (5.2, (100, 200), CheckState.PASSED),  # a pair of coarse settings is no evidence of another method
        (3.4, (100, 200), CheckState.FAILED),
    ],
)
def test_a_lost_order_fails_and_one_too_high_warns(measured: float, steps: tuple[int, ...], state: CheckState) -> None:
    assert order_check(errors(measured, *steps), 4.0, "a/scene").state is state


def test_errors_that_are_too_large_to_fall_do_not_pass() -> None:
    whole = [dataclasses.replace(e, by_quantity={"attitude": np.full(3, 0.27)}) for e in errors(0.0, 100, 200)]
    assert falling_check(whole, 4.0, "a/scene").state is CheckState.WARNING
    assert order_check(whole, 4.0, "a/scene").state is CheckState.WARNING
    assert falling_check(errors(0.0, 100, 200), 4.0, "a/scene").state is CheckState.FAILED
    assert falling_check(errors(4.0, 100, 200), 4.0, "a/scene").state is CheckState.PASSED


def test_the_order_of_large_errors_shows_at_the_start_of_the_scene() -> None:
    early = np.array([0.0, 1e-3, 1.0])
    found = [
        dataclasses.replace(e, by_quantity={"attitude": early / (k + 1)}) for k, e in enumerate(errors(0.0, 100, 200))
    ]
    check = order_check(found, 4.0, "a/scene")
    assert check.state is CheckState.FAILED
    assert check.words.startswith("measured 1.00, declared 4; order 1 is that of Euler's method, or of a force")


def beyond(found: list[ErrorAtSetting], *ratios: float) -> list[ErrorAtSetting]:
    """Errors with other ratios to their bounds."""
    return [dataclasses.replace(e, bound_ratio=r) for e, r in zip(found, ratios, strict=True)]


def test_the_coarsest_steps_may_be_outside_the_asymptotic_range_where_finer_ones_show_the_order() -> None:
    right, low = errors(4.0, 1000, 2000, 4000), errors(1.0, 1000, 2000, 4000)
    found = bound_check(beyond(right, 1.92, 0.3, 0.1), "a/scene", 4.0)
    assert found.state is CheckState.WARNING
    assert "asymptotic" in found.words
    failing = [
        (beyond(right, 1.92, 1.1, 0.1), 4.0),
        (beyond(right, 0.3, 1.1, 0.1), 4.0),
        (beyond(low, 1.92, 0.3, 0.1), 4.0),
        (beyond(right[:2], 1.92, 0.3), 4.0),  # one finer one
        (beyond(right, 1.92, 0.3, 0.1), None),
    ]
    assert all(bound_check(errors_of, "a/scene", order).state is CheckState.FAILED for errors_of, order in failing)


def pair(coarse: float, fine: float, requests: tuple[float, float], *, whole: bool = True) -> Compared:
    one, other = (Setting(AccuracyParameter.RTOL, value) for value in requests)
    return Compared(coarse, fine, (one, other), 81 if whole else 33, requests[0] / requests[1], True, whole)


@pytest.mark.parametrize(
    ("found", "falls"),
    [
        (pair(4.6e-6, 1.07e-6, (1e-5, 1e-7), whole=False), True),  # SciPy's DOP853, the coarse run in its first steps
        (pair(8.1e-10, 1.6e-9, (1e-5, 1e-7), whole=False), True),  # the same with steps that end at the samples
        (pair(1.1e-6, 3.1e-8, (1e-7, 1e-8)), True),
        (pair(2e-6, 1.9e-6, (1e-7, 1e-9)), False),
        (pair(2e-6, 1.9e-6, (1e-5, 1e-7), whole=False), False),
        (pair(3.7e-6, 4.8e-5, (1e-5, 1e-8)), False),  # Drake with caching
    ],
    ids=str,
)
def test_an_error_falls_or_is_below_its_request_and_one_above_its_request_that_stays_fails(
    found: Compared, falls: bool
) -> None:
    assert found.falls(None) is falls


def test_equal_steps_have_to_lower_the_error_by_the_order() -> None:
    steps = (Setting(AccuracyParameter.STEPS_PER_ORBIT, 1000.0), Setting(AccuracyParameter.STEPS_PER_ORBIT, 2000.0))
    assert Compared(1.0e-4, 1.0e-4 / 16.0, steps, 81, 2.0, True, True).falls(4.0)
    assert not Compared(1.0e-4, 0.6e-4, steps, 81, 2.0, True, True).falls(4.0)


def errors_at(*errors: float) -> list[ErrorAtSetting]:
    """Largest errors at 1e-6, 1e-7 and so on, over the whole scene, far above rounding."""
    return [
        ErrorAtSetting(
            Setting(AccuracyParameter.RTOL, request), request, {"attitude": np.full(5, e)}, np.full(5, 1e-16), True, 0.1
        )
        for request, e in zip((1e-6, 1e-7, 1e-8, 1e-9), errors, strict=False)
    ]


def test_chosen_steps_are_not_accused_from_two_settings_where_a_third_falls() -> None:
    """SciPy's DOP853 with samples by dense output: the errors of steps cancel at one setting and not at the next."""
    irregular, stuck = errors_at(2.3e-6, 1.6e-6, 4.3e-8, 8.5e-10), errors_at(2.3e-6, 1.6e-6, 1.5e-6, 1.5e-6)
    assert falling_check(irregular, None, "x").state is CheckState.PASSED
    assert falling_check(stuck, None, "x").state is CheckState.FAILED
    assert falling_check(errors_at(2.3e-6, 4.3e-8, 4.2e-8), None, "x").state is CheckState.FAILED  # the finest stays


def test_errors_that_keep_some_requests_and_not_others_ask_for_what_a_rejected_step_leaves() -> None:
    """A stale stage spoils the steps after a rejection alone: at some settings none is rejected."""
    stale, loose = (
        [dataclasses.replace(each, kept_ratio=20.0) for each in errors_at(*errors)]
        for errors in ((4.8e-6, 2.2e-6, 1.9e-6, 1.1e-9), (5e-5, 5e-6, 5e-7, 5e-8))
    )
    assert "rejected" in request_check(stale, "x").words
    assert "whole run" in request_check(loose, "x").words
