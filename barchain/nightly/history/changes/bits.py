"""Rule of bits: the same parts on the same class of machine must give the same trajectory.

If they do not, the run is not reproducible: no figure of it means much, so that this is told first. Other parts may
give other bits; errors then say whether that matters.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Change, Direction

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import Figure
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary

State = tuple[tuple[str, str, str], ...]
NOT_REPRODUCIBLE = "not reproducible: the same parts on the same class of machine gave other bits"
OTHER_PARTS = "other bits from other parts"
UNKNOWN_PARTS = "other bits; whether a part changed is not known, as parts have no digests"


def bit_changes(series: FigureSeries) -> tuple[Change, ...]:
    """Changes of a trajectory's bits over the nights.

    Each night is compared with the one before, and with the last one of the same parts.
    """
    found: list[Change] = []
    seen: dict[State, tuple[NightSummary, Figure]] = {}
    earlier: tuple[NightSummary, Figure] | None = None
    for night, figure in zip(series.nights, series.figures, strict=True):
        if not figure.word:
            continue
        state = state_of(night, figure)
        alike = seen.get(state) if state is not None else None
        if alike is not None and alike[1].word != figure.word:
            found.append(changed(series, alike, (night, figure), NOT_REPRODUCIBLE, irreproducible=True))
        elif earlier is not None and earlier[1].word != figure.word:
            found.append(changed(series, earlier, (night, figure), UNKNOWN_PARTS if state is None else OTHER_PARTS))
        if state is not None:
            seen[state] = (night, figure)
        earlier = (night, figure)
    return tuple(found)


def changed(
    series: FigureSeries, was: tuple[NightSummary, Figure], now: tuple[NightSummary, Figure], reason: str,
    *, irreproducible: bool = False,
) -> Change:  # fmt: skip
    """Change of bits between two nights."""
    direction = Direction.WORSE if irreproducible else Direction.CHANGED
    return Change(
        series.identity, was[1], now[1], was[0].name, now[0].name, direction, reason, irreproducible=irreproducible
    )


def state_of(night: NightSummary, figure: Figure) -> State | None:
    """Parts that a figure depends on, with their digests; None if a digest is unknown."""
    named = night.part_named
    parts = [named[name] for name in figure.depends if name in named]
    if len(parts) < len(figure.depends) or not parts or not all(part.digest for part in parts):
        return None
    return tuple((part.name, "", part.digest) for part in parts)
