"""Search for the causes of a change among suspects, in few cells (delta debugging; Zeller and Hildebrandt 2002).

A cell is the set of suspects that have their new state; all others have the old one. A cell *shows* the change if its
figure differs from that of the empty cell as the change says.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    Cell = frozenset[str]

ItemT = TypeVar("ItemT")


class AttributionVerdict(StrEnum):
    """Result of an attribution."""

    CONFIRMED = "confirmed"
    """One suspect alone makes the change, and the others together do not"""
    BOTH = "both"
    """Several suspects make a change, each by itself"""
    INTERACTION = "interaction"
    """Suspects make the change only together"""
    NOT_REPRODUCED = "not reproduced"
    """All suspects together don't make the change in a fresh environment"""


@dataclass(frozen=True)
class Causes:
    """Causes of a change: each a smallest set of suspects that makes the change."""

    verdict: AttributionVerdict
    sets: tuple[frozenset[str], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All suspects that belong to a cause, sorted."""
        return tuple(sorted({name for one in self.sets for name in one}))


def find_causes(suspects: Sequence[str], shows: Callable[[Cell], bool]) -> Causes:
    """Causes of a change among suspects.

    Parameters
    ----------
    suspects : sequence of str
    shows : callable
        Whether a cell shows the change; called once for each cell. Of the empty cell it is false by definition.

    Notes
    -----
    The cell of all suspects is looked at first: without a change there, nothing is to be explained. Then smallest sets
    are taken away one after the other, until the rest shows nothing.
    """
    known: dict[Cell, bool] = {frozenset(): False}

    def seen(cell: Cell) -> bool:
        if cell not in known:
            known[cell] = shows(cell)
        return known[cell]

    rest = frozenset(suspects)
    if not rest or not seen(rest):
        return Causes(AttributionVerdict.NOT_REPRODUCED)
    found: list[frozenset[str]] = []
    while rest and seen(rest):
        smallest = minimal(sorted(rest), seen)
        found.append(smallest)
        rest -= smallest
    if len(found) > 1:
        return Causes(AttributionVerdict.BOTH, tuple(found))
    alone = len(found[0]) == 1
    return Causes(AttributionVerdict.CONFIRMED if alone else AttributionVerdict.INTERACTION, tuple(found))


def minimal(suspects: Sequence[str], shows: Callable[[Cell], bool]) -> frozenset[str]:
    """Smallest set that shows the change: without any one of its members it does not (ddmin)."""
    current, parts = list(suspects), 2
    while len(current) >= 2:
        chunks = split(current, parts)
        smaller = next((chunk for chunk in chunks if shows(frozenset(chunk))), None)
        if smaller is not None:
            current, parts = smaller, 2
            continue
        without = next(
            (rest for chunk in chunks if (rest := [s for s in current if s not in chunk]) and shows(frozenset(rest))),
            None,
        )
        if without is not None:
            current, parts = without, max(parts - 1, 2)
        elif parts < len(current):
            parts = min(len(current), 2 * parts)
        else:
            break
    return frozenset(current)


def split(items: Sequence[str], parts: int) -> list[list[str]]:
    """Items in `parts` pieces of nearly equal sizes."""
    bounds = [round(k * len(items) / parts) for k in range(parts + 1)]
    return [list(items[a:b]) for a, b in itertools.pairwise(bounds) if b > a]


@dataclass(frozen=True)
class Bisected:
    """Step of a figure between two states of an ordered list."""

    last_good: int
    first_bad: int
    skipped: tuple[int, ...] = ()
    """Numbers between both that do not run"""
    tried: int = 0


class EndsError(ValueError):
    """Raised where an end of a bisection is not as it was given; the message is one line."""


def bisect(count: int, is_bad: Callable[[int], bool | None]) -> Bisected:
    """Bisect a list whose first state is good and whose last one is bad; both are confirmed first.

    Parameters
    ----------
    count : int
        Number of states, at least 2.
    is_bad : callable
        Whether a state is bad; None if it does not run. Called once for each state.

    Raises
    ------
    EndsError
        If the first state is not good, or the last one is not bad.
    """
    first, last = is_bad(0), is_bad(count - 1)
    for said, wanted, place in ((first, False, "good"), (last, True, "bad")):
        if said is None:
            raise EndsError(f"the {place} end does not run here")
        if said is not wanted:
            raise EndsError(f"the {place} end is {'bad' if said else 'good'} here: nothing to bisect")
    good, bad, tried = 0, count - 1, 2
    dead: set[int] = set()
    while True:
        between = [k for k in range(good + 1, bad) if k not in dead]
        if not between:
            return Bisected(good, bad, tuple(sorted(k for k in dead if good < k < bad)), tried)
        middle = (good + bad) / 2.0
        k = min(between, key=lambda n: (abs(n - middle), n))
        said, tried = is_bad(k), tried + 1
        if said is None:
            dead.add(k)
        elif said:
            bad = k
        else:
            good = k
