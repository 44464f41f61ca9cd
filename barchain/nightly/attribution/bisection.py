"""Search for causes and for the release or commit that changed a figure, in few runs."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from packaging.version import Version

from barchain.nightly.attribution.releases import releases_of
from barchain.nightly.attribution.trials import NO_SCENES, Cells, middle, shows, swaps_of
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import result_words
from barchain.nightly.figures.dependencies import capture
from barchain.nightly.figures.figure import STEPPED
from barchain.nightly.figures.package_origins import AT, state_words, states_between
from barchain.nightly.figures.suspects import differing
from barchain.nightly.history.news import AttributionVerdict
from barchain.runs.environment import scratch_folder
from barchain.runs.processes import GitError, git
from barchain.studies.study import ignore
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.nightly.attribution.trials import OwnScenes, Swap
    from barchain.nightly.figures.figure import Figure, NightSummary
    from barchain.nightly.history.nights import NightStore

    Cell = frozenset[str]


def find_causes(
    suspects: Sequence[str], shows: Callable[[Cell], bool]
) -> tuple[AttributionVerdict, tuple[frozenset[str], ...]]:
    """Causes of a change among suspects: the verdict, and the smallest sets of suspects that make the change.

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

    rest, found = frozenset(suspects), list[frozenset[str]]()
    while seen(rest):
        found.append(minimal(sorted(rest), seen))
        rest -= found[-1]
    if not found:
        return AttributionVerdict.NOT_REPRODUCED, ()
    if len(found) > 1:
        return AttributionVerdict.BOTH, tuple(found)
    alone = len(found[0]) == 1
    return AttributionVerdict.CONFIRMED if alone else AttributionVerdict.INTERACTION, tuple(found)


def minimal(suspects: Sequence[str], shows: Callable[[Cell], bool]) -> frozenset[str]:
    """Smallest set that shows the change: without any one of its members it does not (ddmin)."""
    current, parts = list(suspects), 2
    while len(current) >= 2:
        bounds = [round(k * len(current) / parts) for k in range(parts + 1)]
        chunks = [current[a:b] for a, b in itertools.pairwise(bounds) if b > a]
        smaller = next((chunk for chunk in chunks if shows(frozenset(chunk))), None)
        if smaller is not None:
            current, parts = smaller, 2
            continue
        without = ([s for s in current if s not in chunk] for chunk in chunks)
        fewer = next((rest for rest in without if rest and shows(frozenset(rest))), None)
        if fewer is not None:
            current, parts = fewer, max(parts - 1, 2)
        elif parts < len(current):
            parts = min(len(current), 2 * parts)
        else:
            break
    return frozenset(current)


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
        k = min(between, key=lambda n: (abs(n - (good + bad) / 2.0), n))  # called at once
        said, tried = is_bad(k), tried + 1
        if said is None:
            dead.add(k)
        elif said:
            bad = k
        else:
            good = k


def bisect_nights(
    store: NightStore, figure: str, good: str, bad: str, part: str | None = None, note: Callable[[str], None] = ignore,
    scenes: OwnScenes = NO_SCENES,
) -> str:  # fmt: skip
    """Bisect a figure between two nights; the state of a part since which it has its new value, in one line.

    Parameters
    ----------
    store : NightStore
    figure : str
        Name of a figure that both nights have.
    good, bad : str
        Nights.
    part : str, optional
        Part whose states are walked; by default the only one that differs.
    note : callable
        Called with a sentence on each state.
    scenes : dict
        Files of scenes of one's own.

    Raises
    ------
    HistoryError
        If a night lacks the figure, no single part differs, its states can't be made, or an end is not confirmed.
    """
    was, now = figure_of(store, good, figure), figure_of(store, bad, figure)
    last, since = store.summary(good), store.summary(bad)
    swaps, fixed = swaps_of(differing(last, since, {*was.depends, *now.depends}), scenes)
    swap = the_one([one for one in swaps if not one.scenes], fixed, part)
    with scratch_folder() as scratch:
        cells = Cells(was, now, last, since, swaps, scenes, scratch, note)
        states = releases_between(swap, scratch) if swap.distribution else commits_between(last, since, swap)
        try:
            found = bisect(len(states), walk(was, now, swap, states, cells, note))
        except EndsError as error:
            raise HistoryError(f"{figure}: {error}") from None
    words = [state_words(state) for state in states]
    skipped = [words[k] for k in found.skipped]
    dead = f"; {len(skipped)} between them do not run: {', '.join(skipped)}" if skipped else ""
    return (
        f"{figure}: new since {swap.name} {words[found.first_bad]}; {words[found.last_good]} still has the old value "
        f"({found.tried} of {len(states)} tried){dead}"
    )


def figure_of(store: NightStore, night: str, name: str) -> Figure:
    """Figure of a night by its name."""
    figures = {figure.identity.name: figure for figure in store.night(night).figures}
    if name not in figures:
        raise HistoryError(f"{name[:80]}: night {night} has no such figure{nearest(name, figures)}")
    return figures[name]


def the_one(swaps: list[Swap], fixed: list[str], part: str | None) -> Swap:
    """Part whose states are walked."""
    names = {swap.name: swap for swap in swaps}
    if part is not None:
        if part in names:
            return names[part]
        why = next((words for words in fixed if words.startswith(part)), "")
        if why:
            raise HistoryError(f"--part {why}")
        said = f"--part {part[:60]}: does not differ{nearest(part, names)}"
        raise HistoryError(f"{said}; those that differ and can be exchanged: {', '.join(names) or 'none'}")
    if not swaps:
        raise HistoryError(f"no part that differs can be exchanged: {'; '.join(fixed) or 'none differs'}")
    if len(swaps) > 1:
        raise HistoryError(
            f"{len(swaps)} parts differ that can be exchanged ({', '.join(names)}); name one with --part"
        )
    return swaps[0]


def releases_between(swap: Swap, scratch: Path) -> list[str]:
    """Releases from the old version to the new one, or commits of a distribution of a repository; both are among them.

    Raises
    ------
    HistoryError
        If the states have no order, or the repository can't be had.
    """
    before, after = swap.states
    if AT in before + after:
        try:
            states = states_between(before, after, scratch)
        except GitError as error:
            raise HistoryError(f"{swap.name}: {error}") from None
        if states is None:
            raise HistoryError(f"{swap.name}: its states on both nights are no commits of one repository")
        return states
    first, last = sorted((Version(before), Version(after)))
    known = [r.version for r in releases_of(swap.distribution) if first < r.version < last]
    found = [str(v) for v in (first, *known, last)]
    return found if Version(before) == first else found[::-1]


def commits_between(last: NightSummary, since: NightSummary, swap: Swap) -> list[str]:
    """Commits that touch a part's packages, from that of the good night to that of the bad one."""
    if not last.commit or not since.commit or "+" in last.commit + since.commit:
        raise HistoryError(
            f"{swap.name}: a night without a commit, or with changes that no commit has, can't be bisected"
        )
    paths = [name.replace(".", "/") for name in swap.packages]
    try:
        top = Path(git(Path(__file__).parent, "rev-parse", "--show-toplevel").decode().strip())
        given = git(top, "rev-list", "--reverse", f"{last.commit}..{since.commit}", "--", *paths).decode()
    except GitError:
        raise HistoryError(f"{swap.name}: Git gives no commits between {last.commit} and {since.commit}") from None
    return [last.commit, *given.split()] if given else [last.commit, since.commit]


def walk(
    was: Figure, now: Figure, swap: Swap, states: list[str], cells: Cells, note: Callable[[str], None]
) -> Callable[[int], bool | None]:
    """Whether a state of one part has the new value, None if it does not run; the first state gives the old value.

    All other parts that differ have the good night's state. The good night's own figure should be found again only on
    its machine class, and if it is not a time.
    """
    factor = now.value / was.value if now.value and was.value else None
    alike = capture().machine_class == cells.last.environment.machine_class and was.identity.kind not in STEPPED
    base: list[Figure] = []

    def is_bad(k: int) -> bool | None:
        found = middle([cells.figure(repeat=repeat, walked=(swap, states[k])) for repeat in range(cells.repeats)])
        why = f" ({found.reason})" if found.missing else ""
        note(f"{swap.name} {state_words(states[k])}: {result_words(found)}{why}")
        if found.missing and not now.missing:
            return None
        if not base:
            base.append(found)
            return alike and shows(was.identity, was, found, factor)
        return shows(was.identity, base[0], found, factor)

    return is_bad
