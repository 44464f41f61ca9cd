"""Figures of several result folders as those of one night: of two of one name, a rule of the kind says which stands."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.verdicts import SCALES
from barchain.nightly.history.model.figures import Figure, FigureKind
from reports.tables.reading import brief

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.nightly.history.model.figures import FigureIdentity

LARGER = frozenset({FigureKind.ERROR, FigureKind.COUNT, FigureKind.RATIO, FigureKind.MEMORY})
"""Kinds of which more is worse: the larger number stands"""


def merged(figures: Iterable[Figure]) -> tuple[Figure, ...]:
    """Figures of one night.

    Parameters
    ----------
    figures : iterable of Figure
        Of all folders, in the order of the plan's parts.

    Returns
    -------
    tuple of Figure
        One of each name.
    """
    found: dict[FigureIdentity, Figure] = {}
    for figure in figures:
        there = found.get(figure.identity)
        found[figure.identity] = figure if there is None else standing(there, figure)
    return tuple(found.values())


def standing(first: Figure, second: Figure) -> Figure:
    """Figure that stands for two of one name.

    One with a result stands for one without. Of two verdicts the graver one stands, of two errors, counts, ratios or
    memories the larger one, of two other numbers the first one: their plan says which part that is. Two digests of one
    trajectory contradict each other, so that the figure is missing.
    """
    if second.missing or (first.value, first.word) == (second.value, second.word):
        return first
    if first.missing:
        return second
    kind = first.identity.kind
    if kind in LARGER:
        return max(first, second, key=number_of)
    if kind is FigureKind.VALUE:
        return first
    return graver(first, second) if kind is FigureKind.VERDICT else contradiction(first, second)


def number_of(figure: Figure) -> float:
    """Number of a figure that has one."""
    return 0.0 if figure.value is None else figure.value


def graver(first: Figure, second: Figure) -> Figure:
    """Graver one of two verdicts; words of no common scale contradict each other."""
    for scale in SCALES:
        if first.word in scale and second.word in scale:
            return max(first, second, key=lambda figure: scale.index(figure.word))
    return contradiction(first, second)


def contradiction(first: Figure, second: Figure) -> Figure:
    """Missing figure: two runs of one night gave different words."""
    said = brief(f"two parts of the night differ: {first.word[:100]}, {second.word[:100]}")
    return Figure(first.identity, reason=said, depends=(*first.depends, *second.depends))
