"""Choice of the changes that are worth real runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.attribution.cells import CellError, command_of
from barchain.nightly.attribution.swaps import swaps_of
from barchain.nightly.history.changes.model import Direction
from barchain.nightly.history.changes.suspects import suspicion
from barchain.nightly.history.model.figures import FigureKind
from barchain.nightly.telling.facts import OWN

if TYPE_CHECKING:
    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.changes.model import Change

ORDER = (FigureKind.ERROR, FigureKind.VERDICT, FigureKind.COUNT, FigureKind.VALUE, FigureKind.BITS, FigureKind.RATIO)


def worth_attributing(judged: JudgedNight, most: int) -> list[Change]:
    """Changes of a night with suspects that can be exchanged: one for each engine and set of suspects.

    Errors stand for verdicts and counts, and the largest factor for its scenes. Bits and times have a change of their
    own: another part may have made it.
    """
    nights = {night.name: night for night in (*judged.compared_with, judged.night)}
    found: dict[tuple[str, str, tuple[str, ...]], Change] = {}
    for change in sorted(judged.tonight, key=rank):
        swaps, _ = swaps_of(suspicion(change, nights).suspects)
        if swaps and measurable(change) and not change.irreproducible:
            own = str(change.identity.kind) if change.identity.kind in OWN else ""
            found.setdefault((change.identity.engine, own, tuple(swap.name for swap in swaps)), change)
    return list(found.values())[:most]


def reasons_against(judged: JudgedNight) -> list[str]:
    """Why the changes of a night can't be attributed: a line for each reason, without repetitions."""
    nights = {night.name: night for night in (*judged.compared_with, judged.night)}
    found: list[str] = []
    for change in judged.tonight:
        try:
            command_of(change.identity)
        except CellError as error:
            found.append(str(error).partition(": ")[2])
            continue
        if change.irreproducible:
            found.append("a run is not reproducible: equal parts gave other bits")
        else:
            found += swaps_of(suspicion(change, nights).suspects)[1] or ["no part is known to differ"]
    return list(dict.fromkeys(found))


def rank(change: Change) -> tuple[bool, int, float]:
    """Order of changes: for the worse first, errors first, large factors first."""
    kind = change.identity.kind
    place = ORDER.index(kind) if kind in ORDER else len(ORDER)
    return change.direction is not Direction.WORSE, place, -abs((change.factor or 1.0) - 1.0)


def measurable(change: Change) -> bool:
    """Whether a command measures the figure by itself."""
    try:
        command_of(change.identity)
    except CellError:
        return False
    return True
