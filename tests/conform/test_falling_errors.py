"""An error that follows the setting passes, whatever part of a scene shows it; one that stays fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from barchain.conform.accuracy import falling_check, request_check
from barchain.conform.checks import CheckState
from barchain.conform.errors_at_settings import Compared, ErrorAtSetting

RTOL, STEPS = AccuracyParameter.RTOL, AccuracyParameter.STEPS_PER_ORBIT


def pair(coarse: float, fine: float, requests: tuple[float, float], *, whole: bool = True) -> Compared:
    one, other = (Setting(RTOL, value) for value in requests)
    return Compared(coarse, fine, (one, other), 81 if whole else 33, requests[0] / requests[1], True, whole)


@pytest.mark.parametrize(
    "right",
    [
        pair(4.6e-6, 1.07e-6, (1e-5, 1e-7), whole=False),  # SciPy's DOP853, the coarse run in its first steps
        pair(8.1e-10, 1.6e-9, (1e-5, 1e-7), whole=False),  # the same with steps that end at the samples
        pair(1.1e-6, 3.1e-8, (1e-7, 1e-8)),
    ],
    ids=str,
)
def test_an_error_that_falls_or_is_below_its_request_passes(right: Compared) -> None:
    assert right.falls(None)


@pytest.mark.parametrize(
    "wrong",
    [
        pair(2e-6, 1.9e-6, (1e-7, 1e-9)),
        pair(2e-6, 1.9e-6, (1e-5, 1e-7), whole=False),
        pair(3.7e-6, 4.8e-5, (1e-5, 1e-8)),  # Drake with caching
    ],
    ids=str,
)
def test_an_error_above_its_request_that_stays_fails(wrong: Compared) -> None:
    assert not wrong.falls(None)


def test_equal_steps_have_to_lower_the_error_by_the_order() -> None:
    steps = (Setting(STEPS, 1000.0), Setting(STEPS, 2000.0))
    assert Compared(1.0e-4, 1.0e-4 / 16.0, steps, 81, 2.0, True, True).falls(4.0)
    assert not Compared(1.0e-4, 0.6e-4, steps, 81, 2.0, True, True).falls(4.0)
    assert str(Compared(1.0e-4, 0.6e-4, steps, 33, 2.0, True, False)).endswith("up to sample 33")


def errors_at(*errors: float) -> list[ErrorAtSetting]:
    """Largest errors at 1e-6, 1e-7 and so on, over the whole scene, far above rounding."""
    return [
        ErrorAtSetting(Setting(RTOL, request), request, {"attitude": np.full(5, e)}, np.full(5, 1e-16), True, 0.1)
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
        [replace(each, kept_ratio=20.0) for each in errors_at(*errors)]
        for errors in ((4.8e-6, 2.2e-6, 1.9e-6, 1.1e-9), (5e-5, 5e-6, 5e-7, 5e-8))
    )
    assert "rejected" in request_check(stale, "x").words
    assert "whole run" in request_check(loose, "x").words
