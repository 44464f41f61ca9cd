"""The data model: what contradicts itself is no night."""

from __future__ import annotations

import datetime
import math

import pytest
from hypothesis import given

from barchain.nightly.figures import Figure, FigureError, FigureIdentity, FigureKind, FigureUnit, Night, NightPart
from tests.nightly.history.synthetic import (
    ENVIRONMENT,
    FIRST,
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


def test_a_missing_figure_has_a_reason() -> None:
    with pytest.raises(FigureError, match="without a reason"):
        Figure(identity())
    assert Figure(identity(), reason="timed out").missing


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: count(1.5), "whole number"),
        (lambda: count(-1.0), "whole number"),
        (lambda: error(-1e-9), "at least 0"),
        (lambda: ratio(0.0), "positive"),
        (lambda: ratio(2.0, low=2.1), "outside its interval"),
        (lambda: error(1.0, tolerance=-1.0), "at least 0"),
        (lambda: Figure(identity("steps", FigureKind.COUNT), 3.0, tolerance=1.0), "tolerance"),
        (lambda: Figure(identity("verdict", FigureKind.VERDICT), 1.0), "a word"),
        (lambda: Figure(identity(), 1.0, word="pass"), "a number"),
        (lambda: identity(unit=FigureUnit.BYTE), "allowed for error"),
        (lambda: identity(anchor="reference"), "anchor"),
        (lambda: identity("time", FigureKind.RATIO, anchor=""), "anchor"),
        (lambda: identity(""), "a name"),
        (lambda: identity("a\nb"), "printable"),
        (lambda: identity("a\x00b"), "printable"),
        (lambda: FigureIdentity("s", "e", "x" * 501, "q", FigureKind.COUNT, FigureUnit.ONE), "at most 500"),
        (lambda: NightPart(""), "no name"),
        (lambda: night(error(), error()), "twice"),
        (lambda: night(error(depends=("engine:other",))), "does not list"),
        (lambda: night(parts=(NightPart("a"), NightPart("a", "2"))), "same name"),
        (lambda: night(parts=(NightPart("machine"),)), "environment"),
        (lambda: night(duration_s=math.nan), "duration"),
        (lambda: Night(FIRST.replace(tzinfo=None), 1.0, "", "", ENVIRONMENT), "UTC"),
    ],
)
def test_what_contradicts_itself_is_rejected_in_one_line(make, said: str) -> None:
    with pytest.raises(FigureError, match=said) as raised:
        make()
    assert "\n" not in str(raised.value)


def test_a_night_is_the_same_in_any_order_of_its_figures() -> None:
    figures = (error(), bits(), verdict(), count(), ratio())
    a, b = night(*figures), night(*reversed(figures))
    assert a == b
    assert a.identity == b.identity


@given(nights())
def test_a_night_is_another_if_any_number_is(made: Night) -> None:
    later = night(*made.figures, count(3.0, "one more"))
    assert later.identity != made.identity


def test_a_digest_counts_before_a_version_and_an_unknown_one_differs_from_none() -> None:
    old = NightPart("adapter:mujoco", "0.6.0", "aa")
    assert not old.differs(NightPart("adapter:mujoco", "0.7.0", "aa"))
    assert old.differs(NightPart("adapter:mujoco", "0.6.0", "bb"))
    assert not old.differs(NightPart("adapter:mujoco", "0.6.0"))
    assert old.differs(NightPart("adapter:mujoco", "0.7.0"))


def test_the_kernel_and_the_packages_are_no_part_of_the_machine_class_and_the_processor_is() -> None:
    import dataclasses

    other = dataclasses.replace(ENVIRONMENT, kernel="Linux 7", python="3.12.1", blas="mkl")
    assert other.machine_class == ENVIRONMENT.machine_class
    for change in ({"cpu": "Other"}, {"cpu_flags": "avx"}, {"cores": 4}, {"libc": "musl"}, {"architecture": "arm"}):
        assert dataclasses.replace(ENVIRONMENT, **change).machine_class != ENVIRONMENT.machine_class


def test_starts_at_other_offsets_are_no_starts() -> None:
    offset = FIRST.astimezone(datetime.timezone(datetime.timedelta(hours=1)))
    with pytest.raises(FigureError, match="UTC"):
        Night(offset, 1.0, "", "", ENVIRONMENT)
