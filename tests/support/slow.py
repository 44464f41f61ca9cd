"""Parameters of which the default run tries some, the slow tests more, and the exhaustive ones the rest."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from _pytest.mark import ParameterSet

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable


def slow_but(values: Iterable[Any], quick: Collection[Any]) -> list[Any]:
    """Parameters; all but the quick ones are slow. Raises ValueError if a quick one is not among them."""
    return marked_but(pytest.mark.slow, values, quick)


def exhaustive_but(values: Iterable[Any], kept: Collection[Any]) -> list[Any]:
    """Parameters; all but the kept ones are exhaustive. Raises ValueError if a kept one is not among them."""
    return marked_but(pytest.mark.exhaustive, values, kept)


def marked_but(mark: pytest.MarkDecorator, values: Iterable[Any], kept: Collection[Any]) -> list[Any]:
    """Parameters; all but the kept ones have a mark."""
    found = list(values)
    missing = [each for each in kept if each not in found]
    if missing:
        raise ValueError(f"{missing} given as kept, allowed: {found}")
    return [each if each in kept else pytest.param(each, marks=mark) for each in found]


def one_in(share: int, values: Iterable[Any], name: Callable[[Any], str] | None = None) -> list[Any]:
    """Parameters of which every one in `share`, from the first on, is tried by the default run; the rest is slow.

    `name` gives the parameter's id. Parameters that have marks already keep them.
    """
    found = []
    for k, each in enumerate(values):
        marks = [pytest.mark.slow] if k % share else []
        given = each if isinstance(each, ParameterSet) else pytest.param(each, id=name(each) if name else None)
        found.append(pytest.param(*given.values, id=given.id, marks=[*given.marks, *marks]))
    return found


def thinned(share: int, parameters: Iterable[Any]) -> list[Any]:
    """Parameters; of the slow ones every one in `share`, from the first on, stays slow, and the rest is exhaustive."""
    found, count = [], 0
    for each in parameters:
        slow = isinstance(each, ParameterSet) and any(mark.name == "slow" for mark in each.marks)
        if slow and count % share:
            marks = [mark for mark in each.marks if mark.name != "slow"]
            found.append(pytest.param(*each.values, id=each.id, marks=[*marks, pytest.mark.exhaustive]))
        else:
            found.append(each)
        count += slow
    return found
