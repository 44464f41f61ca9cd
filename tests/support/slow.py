"""Parameters of which the default run tries some, the slow tests more, and the exhaustive ones the rest."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import pytest
from _pytest.mark import ParameterSet

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Sequence


CI_SHARE = 8
"""Of the parameters that the default run leaves out, the slow tests try one in so many, from the first on"""


def slow_but(values: Iterable[Any], quick: Collection[Any]) -> list[Any]:
    """Parameters; the default run tries the quick ones. Raises ValueError if a quick one is not among them."""
    return left_to_later((pytest.param(each), each in quick) for each in among(values, quick))


def one_in(share: int, values: Iterable[Any], name: Callable[[Any], str] | None = None) -> list[Any]:
    """Parameters of which the default run tries every one in `share`, from the first on.

    `name` gives the parameter's id. Parameters that have marks already keep them.
    """
    found = [
        each if isinstance(each, ParameterSet) else pytest.param(each, id=name(each) if name else None)
        for each in values
    ]
    return left_to_later((each, k % share == 0) for k, each in enumerate(found))


def rows(values: Iterable[Sequence[Any]]) -> list[ParameterSet]:
    """Parameters of a test that takes several at once."""
    return [pytest.param(*each) for each in values]


def left_to_later(parameters: Iterable[tuple[ParameterSet, bool]]) -> list[ParameterSet]:
    """Parameters; those that are not quick are slow or exhaustive."""
    found, left = [], itertools.count()
    for each, quick in parameters:
        marks = [] if quick else [pytest.mark.exhaustive if next(left) % CI_SHARE else pytest.mark.slow]
        found.append(pytest.param(*each.values, id=each.id, marks=[*each.marks, *marks]))
    return found


def exhaustive_but(values: Iterable[Any], kept: Collection[Any]) -> list[Any]:
    """Parameters; all but the kept ones are exhaustive. Raises ValueError if a kept one is not among them."""
    return [each if each in kept else pytest.param(each, marks=pytest.mark.exhaustive) for each in among(values, kept)]


def among(values: Iterable[Any], kept: Collection[Any]) -> list[Any]:
    """Values as a list. Raises ValueError if one that is to be kept is not among them."""
    found = list(values)
    missing = [each for each in kept if each not in found]
    if missing:
        raise ValueError(f"{missing} given as kept, allowed: {found}")
    return found
