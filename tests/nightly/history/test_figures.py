"""The data model: what contradicts itself is no night."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given, settings

from barchain.nightly.figures.figure import Figure, FigureError, Night, NightPart
from tests.nightly.history.synthetic import (
    ENVIRONMENT,
    bits,
    count,
    error,
    identity,
    night,
    nights,
    ratio,
    verdict,
)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_none_is_not_stored(value: float) -> None:
    with pytest.raises(FigureError, match="a finite number"):
        error(value)
    with pytest.raises(FigureError, match="without a reason"):
        Figure(identity())


def test_a_night_is_the_same_in_any_order_of_its_figures() -> None:
    figures = (error(), bits(), verdict(), count(), ratio())
    a, b = night(*figures), night(*reversed(figures))
    assert a == b
    assert a.name == b.name


@settings(max_examples=20, deadline=None)
@given(nights())
def test_a_night_is_another_if_any_number_is(made: Night) -> None:
    later = night(*made.figures, count(3.0, "one more"))
    assert later.name != made.name


def test_a_digest_counts_before_a_version_and_an_unknown_one_differs_from_none() -> None:
    old = NightPart("adapter:mujoco", "0.6.0", "aa")
    assert not old.differs(NightPart("adapter:mujoco", "0.7.0", "aa"))
    assert old.differs(NightPart("adapter:mujoco", "0.6.0", "bb"))
    assert not old.differs(NightPart("adapter:mujoco", "0.6.0"))
    assert old.differs(NightPart("adapter:mujoco", "0.7.0"))


def test_the_kernel_and_the_packages_are_no_part_of_the_machine_class_and_the_processor_is() -> None:
    other = dataclasses.replace(ENVIRONMENT, kernel="Linux 7", python="3.12.1", blas="mkl")
    assert other.machine_class == ENVIRONMENT.machine_class
    for change in ({"cpu": "Other"}, {"cpu_flags": "avx"}, {"cores": 4}, {"libc": "musl"}, {"architecture": "arm"}):
        assert dataclasses.replace(ENVIRONMENT, **change).machine_class != ENVIRONMENT.machine_class
