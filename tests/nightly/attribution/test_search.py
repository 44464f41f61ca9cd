"""The search for causes: every truth table of few suspects, smallest sets of many, bisection with dead states."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from barchain.nightly.attribution.bisection import EndsError, bisect, find_causes, minimal
from barchain.nightly.history.news import AttributionVerdict


def test_three_suspects_are_explained_in_every_truth_table() -> None:
    names = ["a", "b", "c"]
    cells = [frozenset(c) for n in range(1, 4) for c in itertools.combinations(names, n)]
    for values in itertools.product([False, True], repeat=len(cells)):
        shown = dict(zip(cells, values, strict=True)) | {frozenset(): False}
        told, sets = find_causes(names, shown.__getitem__)
        if not shown[frozenset(names)]:
            assert told is AttributionVerdict.NOT_REPRODUCED
            continue
        assert all(shown[cause] for cause in sets)
        rest = frozenset(names).difference(*sets)
        assert not shown[rest]


@given(st.sets(st.integers(0, 15), min_size=1, max_size=4), st.integers(0, 15))
def test_a_set_of_causes_that_act_together_is_found_among_many_suspects(cause: set[int], more: int) -> None:
    names = [f"part-{k:02d}" for k in range(max(cause) + more + 1)]
    wanted = frozenset(f"part-{k:02d}" for k in cause)
    told, sets = find_causes(names, lambda cell: wanted <= cell)
    assert sets == (wanted,)
    assert told == ("confirmed" if len(wanted) == 1 else "interaction")


def test_one_cause_among_sixty_four_suspects_takes_few_cells() -> None:
    names, asked = [f"{k:02d}" for k in range(64)], []

    def shows(cell: frozenset[str]) -> bool:
        asked.append(cell)
        return "37" in cell

    assert minimal(names, shows) == frozenset({"37"})
    assert len(asked) <= 2 * 6  # two halves a level


def test_two_causes_that_act_alone_are_told_both_and_no_cell_is_measured_twice() -> None:
    asked: list[frozenset[str]] = []

    def shows(cell: frozenset[str]) -> bool:
        asked.append(cell)
        return "a" in cell or "b" in cell

    assert find_causes(["a", "b", "c", "d"], shows) == ("both", (frozenset("a"), frozenset("b")))
    assert len(asked) == len(set(asked))


@given(st.integers(2, 200), st.data())
def test_bisection_finds_the_first_bad_state(count: int, data: st.DataObject) -> None:
    first = data.draw(st.integers(1, count - 1))
    found = bisect(count, lambda k: k >= first)
    assert (found.last_good, found.first_bad, found.skipped) == (first - 1, first, ())
    assert found.tried <= 3 + count.bit_length()


@given(st.integers(3, 60), st.data())
def test_bisection_names_the_states_between_that_do_not_run(count: int, data: st.DataObject) -> None:
    first = data.draw(st.integers(1, count - 1))
    dead = data.draw(st.sets(st.integers(1, count - 2)))
    assume(0 not in dead and count - 1 not in dead)
    found = bisect(count, lambda k: None if k in dead else k >= first)
    assert found.last_good < first <= found.first_bad or found.first_bad == first
    assert set(found.skipped) == set(range(found.last_good + 1, found.first_bad)) <= dead


@pytest.mark.parametrize(
    ("first", "last", "said"),
    [(True, True, "good end is bad"), (False, False, "bad end is good"), (None, True, "good end does not run"),
     (False, None, "bad end does not run")],
)  # fmt: skip
def test_both_ends_are_confirmed_before_anything_else_is_tried(
    first: bool | None, last: bool | None, said: str
) -> None:
    asked = []

    def is_bad(k: int) -> bool | None:
        asked.append(k)
        return first if k == 0 else last

    with pytest.raises(EndsError, match=said):
        bisect(10, is_bad)
    assert asked == [0, 9]
