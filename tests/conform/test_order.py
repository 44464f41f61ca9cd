"""The measured order against the declared one, and the steps that were taken."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from barchain.conform.accuracy import bound_check, falling_check, order_check
from barchain.conform.checks import CheckState
from barchain.conform.errors_at_settings import ErrorAtSetting


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
    ("measured", "state"),
    [(4.0, CheckState.PASSED), (3.6, CheckState.PASSED), (3.4, CheckState.FAILED), (5.2, CheckState.WARNING)],
)
def test_a_lost_order_fails_and_one_too_high_warns(measured: float, state: CheckState) -> None:
    assert order_check(errors(measured, 100, 200, 400), 4.0, "a/scene").state is state


def test_one_pair_of_coarse_settings_is_no_evidence_of_another_method() -> None:
    assert order_check(errors(5.2, 100, 200), 4.0, "a/scene").state is CheckState.PASSED
    assert order_check(errors(3.4, 100, 200), 4.0, "a/scene").state is CheckState.FAILED


def test_steps_that_samples_do_not_divide_are_told() -> None:
    setting = Setting(AccuracyParameter.STEPS_PER_ORBIT, 1000)
    rounded, exact = (
        ErrorAtSetting(setting, 0.25, {"attitude": np.array([1e-6])}, np.zeros(1), True, 0.1, taken)
        for taken in (1465.0, 1000.0)
    )
    assert str(rounded) == "1.0e-06 at steps_per_orbit=1000 (1465 per orbit taken)"
    assert str(exact) == "1.0e-06 at steps_per_orbit=1000"


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
    right = errors(4.0, 1000, 2000, 4000)
    found = bound_check(beyond(right, 1.92, 0.3, 0.1), "a/scene", 4.0)
    assert found.state is CheckState.WARNING
    assert "asymptotic" in found.words
    assert bound_check(beyond(right, 1.92, 1.1, 0.1), "a/scene", 4.0).state is CheckState.FAILED
    assert bound_check(beyond(right, 0.3, 1.1, 0.1), "a/scene", 4.0).state is CheckState.FAILED
    assert bound_check(beyond(errors(1.0, 1000, 2000, 4000), 1.92, 0.3, 0.1), "a/scene", 4.0).state is CheckState.FAILED
    assert bound_check(beyond(right[:2], 1.92, 0.3), "a/scene", 4.0).state is CheckState.FAILED  # one finer one
    assert bound_check(beyond(right, 1.92, 0.3, 0.1), "a/scene", None).state is CheckState.FAILED
