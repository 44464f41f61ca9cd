"""The data model: what contradicts itself is no night; a rule of its kind says which of two results stands."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from barchain.nightly.figures.changes import SCALES
from barchain.nightly.figures.figure import Figure, FigureError, FigureKind, Night, NightPart
from barchain.nightly.figures.results import figures_of, merged, preferred
from reports.results.comparison import FOLLOWED
from reports.results.rows import Rows
from reports.results.scaling import FOLLOWED as SCALING
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

if TYPE_CHECKING:
    from collections.abc import Callable


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


@given(st.sampled_from(SCALES).flatmap(lambda scale: st.tuples(st.just(scale), *2 * [st.sampled_from(scale)])))
def test_of_two_verdicts_of_one_name_the_graver_one_stands(drawn: tuple[tuple[str, ...], str, str]) -> None:
    scale, first, second = drawn
    both = {preferred(verdict(a), verdict(b)).word for a, b in ((first, second), (second, first))}
    assert both == {max(first, second, key=scale.index)}


@pytest.mark.parametrize("made", [error, count, ratio])
def test_of_two_numbers_of_which_more_is_worse_the_larger_one_stands(made: Callable[[float], Figure]) -> None:
    assert merged([made(2.0), made(3.0)]) == (made(3.0),)
    assert merged([made(3.0), made(2.0)]) == (made(3.0),)


def test_of_two_other_numbers_that_of_the_plan_s_first_part_stands() -> None:
    rates = [Figure(identity("rate", FigureKind.VALUE), value) for value in (0.2, 0.1)]
    assert merged(rates) == (rates[0],)


def test_two_digests_of_one_trajectory_contradict_each_other() -> None:
    (figure,) = merged([bits("00ff"), bits("00aa")])
    assert figure.missing
    assert figure.reason == "two parts of the night differ: 00ff, 00aa"
    assert merged([bits("00ff"), bits("00ff")]) == (bits("00ff"),)


def test_a_result_stands_for_a_missing_one() -> None:
    missing = Figure(identity(), reason="not run")
    present = Figure(identity(), 1e-5)
    assert merged([missing, present]) == (present,)
    assert merged([present, missing]) == (present,)


def test_an_engine_at_two_settings_of_one_folder_has_its_graver_verdict() -> None:
    rows = Rows("comparison", "paper/fig05")
    for setting, outcome in (("rtol=1e-6", "pass"), ("rtol=1e-9", "timed_out"), ("rtol=1e-12", "pass")):
        rows.add("verdict", engine="mujoco", setting=setting, outcome=outcome)
    assert [figure.word for figure in figures_of(rows.frame(), FOLLOWED)] == ["timed_out"]


def test_a_memory_of_a_few_pages_counts_as_the_least_one_and_is_never_gone() -> None:
    """77824 B, one page below the least that is told apart, and one above: no figure goes and comes."""
    found = []
    for memory_B in (77_824.0, 81_920.0, 0.0, 163_840.0):
        rows = Rows("scaling", "paper/fig13")
        rows.add("memory", memory_B, "B", engine="mujoco", bars=20)
        found += [figure.value for figure in figures_of(rows.frame(), SCALING)]
    assert found == [81_920.0, 81_920.0, 81_920.0, 163_840.0]
