"""Attribution of the changes of a night by real runs in fresh environments, kept in the history."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from barchain.nightly.attribution.bisection import find_causes
from barchain.nightly.attribution.trials import NO_SCENES, CellError, Cells, middle, shows, swaps_of
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import Direction, result_words
from barchain.nightly.figures.figure import MOST_TEXT, FigureKind
from barchain.nightly.figures.suspects import suspects_of
from barchain.nightly.history.news import ATTRIBUTED, AttributionVerdict
from barchain.nightly.history.nights import now
from barchain.nightly.telling.document import OWN
from barchain.runs.environment import scratch_folder
from barchain.studies.study import ignore

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.nightly.attribution.trials import OwnScenes, Swap
    from barchain.nightly.figures.changes import Change
    from barchain.nightly.figures.figure import Figure, NightSummary
    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore


ORDER = (FigureKind.ERROR, FigureKind.VERDICT, FigureKind.COUNT, FigureKind.VALUE, FigureKind.BITS, FigureKind.RATIO)


@dataclass(frozen=True)
class Attribution:
    """Result of the real runs behind one change."""

    change: str
    """Id of the change"""
    figure: str
    last: str
    since: str
    verdict: str
    """``confirmed``, ``both``, ``interaction`` or ``not reproduced``"""
    culprits: tuple[str, ...]
    """Parts that make the change"""
    words: str
    """Verdict with the states of the parts"""
    cells: tuple[tuple[str, str], ...] = ()
    """New parts of each cell, and the figure's result there"""
    fixed: tuple[str, ...] = ()
    """Why some suspects could not be exchanged"""


def worth_attributing(judged: JudgedNight, most: int, scenes: OwnScenes = NO_SCENES) -> list[Change]:
    """Changes of a night with suspects that can be exchanged: one for each engine and set of suspects.

    Scenes of files are measured if `scenes` has their files. Errors stand for verdicts and counts, and the largest
    factor for its scenes. Bits and times have a change of their own: another part may have made it.
    """
    found: dict[tuple[str, str, tuple[str, ...]], Change] = {}
    for change, swaps, reasons in sorted(looked_at(judged, scenes), key=lambda each: rank(each[0])):
        if swaps and not reasons:
            own = str(change.identity.kind) if change.identity.kind in OWN else ""
            found.setdefault((change.identity.engine, own, tuple(swap.name for swap in swaps)), change)
    return list(found.values())[:most]


def reasons_against(judged: JudgedNight, scenes: OwnScenes = NO_SCENES) -> list[str]:
    """Why the changes of a night can't be attributed: a line for each reason, without repetitions."""
    found: list[str] = []
    for change, _, reasons in looked_at(judged, scenes):
        fixed = swaps_of(suspects_of(change, judged.by_name), scenes)[1]
        found += reasons or fixed or ["no part is known to differ"]
    return list(dict.fromkeys(found))


def rank(change: Change) -> tuple[bool, int, float]:
    """Order of changes: for the worse first, errors first, large factors first."""
    kind = change.identity.kind
    place = ORDER.index(kind) if kind in ORDER else len(ORDER)
    return change.direction is not Direction.WORSE, place, -abs((change.factor or 1.0) - 1.0)


def looked_at(judged: JudgedNight, scenes: OwnScenes) -> Iterator[tuple[Change, list[Swap], list[str]]]:
    """Changes of a night with the exchanges of their suspects, and why real runs can tell nothing of a change."""
    nights = judged.by_name
    for change in judged.tonight:
        swaps, _ = swaps_of(suspects_of(change, nights), scenes)
        reasons = ["a run is not reproducible: equal parts gave other bits"] if change.irreproducible else []
        if change.last not in nights:
            reasons = [f"{change.last}: the night with the earlier value has been removed"]
        else:
            try:
                Cells(change.was, change.now, nights[change.last], nights[change.since], swaps, scenes, Path())
            except CellError as error:
                reasons = [str(error).partition(": ")[2]]
        yield change, swaps, reasons


def attribute(
    store: NightStore,
    judged: JudgedNight,
    changes: Iterable[Change],
    note: Callable[[str], None] = ignore,
    told: Callable[[Attribution], None] = ignore,
    scenes: OwnScenes = NO_SCENES,
) -> list[Attribution]:
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
    found, faults = [], []
    for change in changes:
        with scratch_folder() as scratch:
            try:
                one = attribute_change(change, judged.by_name, scratch, note, scenes)
            except HistoryError as error:
                faults.append(str(error))
                continue
        keep_attribution(store, one)
        told(one)
        found.append(one)
    if faults:
        raise HistoryError("\n".join(faults))
    return found


def keep_attribution(store: NightStore, found: Attribution) -> None:
    """Keep an attribution; an earlier one of the same change is replaced."""
    content = asdict(found) | {"made": now(), "words": found.words[:MOST_TEXT]}
    store.place.write(f"{ATTRIBUTED}/{found.change}.json", json.dumps(content, indent=1, ensure_ascii=False).encode())


def attribute_change(
    change: Change, nights: dict[str, NightSummary], scratch: Path, note: Callable[[str], None], scenes: OwnScenes
) -> Attribution:
    """Attribute one change; `nights` holds its two nights by name."""
    name = change.identity.name
    swaps, fixed = swaps_of(suspects_of(change, nights), scenes)
    if not swaps:
        said = "; ".join(fixed) or "all parts that the figure depends on are the same"
        raise HistoryError(f"{name}: no suspect can be exchanged: {said}")
    cells = Cells(change.was, change.now, nights[change.last], nights[change.since], swaps, scenes, scratch, note)
    results: dict[frozenset[str], Figure] = {}

    def shown_in(cell: frozenset[str]) -> bool:
        """Whether a cell shows the change; ratios are measured in turns with the cell of the old states."""
        base, found = [], []
        for repeat in range(cells.repeats):
            base.append(cells.figure(repeat=repeat))
            found.append(cells.figure(cell, repeat))
        old = results[frozenset()] = middle(base)
        new = results[cell] = middle(found)
        if not as_on_the_night(old, change.was):
            raise HistoryError(
                f"{name}: the old state gives {result_words(old)} in a fresh environment, "
                f"the night had {result_words(change.was)}"
            )
        note(f"{cell_words(cell)}: {result_words(new)}")
        if len(cell) == len(swaps) and not as_on_the_night(new, change.now):
            note(f"the night had {result_words(change.now)}")
            return False
        return shows(change.identity, old, new, change.factor)

    verdict, sets = find_causes([swap.name for swap in swaps], shown_in)
    words = str(verdict)
    if verdict is not AttributionVerdict.NOT_REPRODUCED:
        named = {swap.name: swap.suspect.words for swap in swaps}
        causes = (" together with ".join(named[each] for each in sorted(one)) for one in sets)
        words = f"{verdict}: {' and by itself '.join(causes)}"
    ordered = sorted(results, key=lambda cell: (len(cell), sorted(cell)))
    return Attribution(
        change.id, name, change.last, change.since, str(verdict), tuple(sorted({each for one in sets for each in one})),
        words, tuple((cell_words(cell), result_words(results[cell])) for cell in ordered), tuple(fixed),
    )  # fmt: skip


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
