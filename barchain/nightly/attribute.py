"""Attribution of the changes of a night by real runs in fresh environments, kept in the history."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from barchain.nightly.bisection import AttributionVerdict, find_causes
from barchain.nightly.cells import NO_SCENES, CellError, Cells, middle, shows, swaps_of
from barchain.nightly.changes import Direction, result_words
from barchain.nightly.facts import OWN, suspicion
from barchain.nightly.faults import HistoryError
from barchain.nightly.figures import FigureKind
from barchain.nightly.told import Attribution, keep_attribution
from barchain.runs.environment import scratch_folder
from barchain.studies.study import ignore

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from barchain.nightly.bisection import Causes
    from barchain.nightly.cells import OwnScenes, Swap
    from barchain.nightly.changes import Change, JudgedNight
    from barchain.nightly.figures import Figure, NightSummary
    from barchain.nightly.history import NightStore


ORDER = (FigureKind.ERROR, FigureKind.VERDICT, FigureKind.COUNT, FigureKind.VALUE, FigureKind.BITS, FigureKind.RATIO)


def worth_attributing(judged: JudgedNight, most: int, scenes: OwnScenes = NO_SCENES) -> list[Change]:
    """Changes of a night with suspects that can be exchanged: one for each engine and set of suspects.

    Scenes of files are measured if `scenes` has their files. Errors stand for verdicts and counts, and the largest
    factor for its scenes. Bits and times have a change of their own: another part may have made it.
    """
    nights = {night.name: night for night in (*judged.compared_with, judged.night)}
    found: dict[tuple[str, str, tuple[str, ...]], Change] = {}
    for change in sorted(judged.tonight, key=rank):
        swaps, _ = swaps_of(suspicion(change, nights).suspects, scenes)
        unmeasured = why_not_measured(change, swaps, nights, scenes)
        if swaps and not unmeasured and not change.irreproducible:
            own = str(change.identity.kind) if change.identity.kind in OWN else ""
            found.setdefault((change.identity.engine, own, tuple(swap.name for swap in swaps)), change)
    return list(found.values())[:most]


def reasons_against(judged: JudgedNight, scenes: OwnScenes = NO_SCENES) -> list[str]:
    """Why the changes of a night can't be attributed: a line for each reason, without repetitions."""
    nights = {night.name: night for night in (*judged.compared_with, judged.night)}
    found: list[str] = []
    for change in judged.tonight:
        swaps, fixed = swaps_of(suspicion(change, nights).suspects, scenes)
        if unmeasured := why_not_measured(change, swaps, nights, scenes):
            found.append(unmeasured)
        elif change.irreproducible:
            found.append("a run is not reproducible: equal parts gave other bits")
        else:
            found += fixed or ["no part is known to differ"]
    return list(dict.fromkeys(found))


def rank(change: Change) -> tuple[bool, int, float]:
    """Order of changes: for the worse first, errors first, large factors first."""
    kind = change.identity.kind
    place = ORDER.index(kind) if kind in ORDER else len(ORDER)
    return change.direction is not Direction.WORSE, place, -abs((change.factor or 1.0) - 1.0)


def why_not_measured(change: Change, swaps: list[Swap], nights: Mapping[str, NightSummary], scenes: OwnScenes) -> str:
    """Why no command measures a figure by itself; empty if one does."""
    try:
        Cells(change.was, change.now, nights[change.last], nights[change.since], swaps, scenes, Path())
    except CellError as error:
        return str(error).partition(": ")[2]
    return ""


@dataclass(frozen=True)
class Attributed:
    """Attribution of one change with its cells in words."""

    attribution: Attribution
    cells: tuple[tuple[str, str], ...]
    """New parts of each cell, and the figure's result there"""
    fixed: tuple[str, ...] = ()
    """Why some suspects could not be exchanged"""


def ignore_attributed(one: Attributed) -> None:
    """Do nothing."""
    del one


def attribute(
    store: NightStore,
    judged: JudgedNight,
    changes: Iterable[Change],
    note: Callable[[str], None] = ignore,
    told: Callable[[Attributed], None] = ignore_attributed,
    scenes: OwnScenes = NO_SCENES,
) -> list[Attributed]:
    """Attribute changes by real runs, and keep each result in the history as soon as it is there.

    Parameters
    ----------
    store : NightStore
    judged : JudgedNight
        Night that tells the changes.
    changes : iterable of Change
    note : callable
        Called with a sentence on each cell.
    told : callable
        Called with each attribution when it is there.
    scenes : dict
        Files of scenes of one's own.

    Raises
    ------
    HistoryError
        If changes can't be attributed, after all others were; the message has a line for each.
    """
    nights = {night.name: night for night in (*judged.compared_with, judged.night)}
    found, faults = [], []
    for change in changes:
        with scratch_folder() as scratch:
            try:
                one = attribute_change(change, nights[change.last], nights[change.since], scratch, note, scenes)
            except HistoryError as error:
                faults.append(str(error))
                continue
        keep_attribution(store, one.attribution)
        told(one)
        found.append(one)
    if faults:
        raise HistoryError("\n".join(faults))
    return found


def attribute_change(
    change: Change, last: NightSummary, since: NightSummary, scratch: Path, note: Callable[[str], None],
    scenes: OwnScenes = NO_SCENES,
) -> Attributed:  # fmt: skip
    """Attribute one change between two nights."""
    identity = change.identity
    swaps, fixed = swaps_of(suspicion(change, {last.name: last, since.name: since}).suspects, scenes)
    cells = Cells(change.was, change.now, last, since, swaps, scenes, scratch)
    if not swaps:
        said = "; ".join(fixed) or "all parts that the figure depends on are the same"
        raise HistoryError(f"{identity.name}: no suspect can be exchanged: {said}")
    factorial = Factorial(change, cells, note)
    causes = find_causes([swap.name for swap in swaps], factorial.shows)
    made = datetime.datetime.now(datetime.UTC)
    attribution = Attribution(
        change.id, identity.name, change.last, change.since, causes.verdict, causes.names, words(causes, swaps), made
    )
    return Attributed(attribution, factorial.told, tuple(fixed))


class Factorial:
    """Cells of one change, measured when they are asked for."""

    def __init__(self, change: Change, cells: Cells, note: Callable[[str], None]) -> None:
        """Take the cells; nothing is measured yet."""
        self.change, self.cells, self.note = change, cells, note
        self.results: dict[frozenset[str], Figure] = {}

    def shows(self, cell: frozenset[str]) -> bool:
        """Whether a cell shows the change; ratios are measured in turns with the cell of the old states."""
        base, found = [], []
        for repeat in range(self.cells.repeats):
            base.append(self.cells.figure(repeat=repeat))
            found.append(self.cells.figure(cell, repeat))
        self.results[frozenset()], self.results[cell] = middle(base), middle(found)
        old = self.results[frozenset()]
        if not as_on_the_night(old, self.change.was):
            raise HistoryError(
                f"{self.change.identity.name}: the old state gives {result_words(old)} in a fresh environment, "
                f"the night had {result_words(self.change.was)}"
            )
        self.note(f"{cell_words(cell)}: {result_words(self.results[cell])}")
        if len(cell) == len(self.cells.swaps) and not as_on_the_night(self.results[cell], self.change.now):
            self.note(f"the night had {result_words(self.change.now)}")
            return False
        return shows(self.change.identity, old, self.results[cell], self.change.factor)

    @property
    def told(self) -> tuple[tuple[str, str], ...]:
        """Cells and results in words, the fewest new parts first."""
        ordered = sorted(self.results, key=lambda cell: (len(cell), sorted(cell)))
        return tuple((cell_words(cell), result_words(self.results[cell])) for cell in ordered)


def as_on_the_night(found: Figure, night: Figure) -> bool:
    """Whether a result in a fresh environment is of the night's sort: a result at all, and the same verdict.

    Numbers and digests may differ from machine to machine: their cells are compared with each other alone.
    """
    if found.missing or night.missing:
        return found.missing is night.missing
    return night.identity.kind is not FigureKind.VERDICT or found.word == night.word


def cell_words(cell: frozenset[str]) -> str:
    """New parts of a cell."""
    return f"new: {', '.join(sorted(cell))}" if cell else "all old"


def words(causes: Causes, swaps: list[Swap]) -> str:
    """Result in words: ``confirmed: engine:mujoco 3.2.7 → 4.0.0``."""
    named = {swap.name: swap.suspect.words for swap in swaps}
    if causes.verdict is AttributionVerdict.NOT_REPRODUCED:
        return str(causes.verdict)
    sets = " and by itself ".join(" together with ".join(named[name] for name in sorted(one)) for one in causes.sets)
    return f"{causes.verdict}: {sets}"
