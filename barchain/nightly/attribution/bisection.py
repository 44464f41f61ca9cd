"""Bisection of a figure over the releases of a distribution, or over commits, between two nights."""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from packaging.version import Version

from barchain.nightly.attribution.cells import REPEATS, CellPlace, CellRunner, command_of, middle, shows
from barchain.nightly.attribution.search import EndsError, bisect
from barchain.nightly.attribution.swaps import NightTrees, pins_of, swaps_of
from barchain.nightly.environments.sources import commit_tree
from barchain.nightly.history.changes.model import result_words
from barchain.nightly.history.changes.suspects import differing
from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.model.environment import capture
from barchain.nightly.history.model.figures import STEPPED
from barchain.nightly.releases.index import releases_of
from barchain.runs.environment import one_thread_each, temporary_root
from barchain.studies.study import ignore
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.nightly.attribution.search import Bisected
    from barchain.nightly.attribution.swaps import Swap
    from barchain.nightly.history.model.figures import Figure
    from barchain.nightly.history.model.series_model import NightSummary
    from barchain.nightly.history.store import NightStore

GIT_S = 60.0


@dataclass(frozen=True)
class FoundStep:
    """State of a part since which a figure has its new value."""

    figure: str
    part: str
    last_good: str
    first_bad: str
    skipped: tuple[str, ...]
    tried: int
    between: int

    @property
    def words(self) -> str:
        """Result in one line."""
        skipped = f"; {len(self.skipped)} between them do not run: {', '.join(self.skipped)}" if self.skipped else ""
        return (
            f"{self.figure}: new since {self.part} {self.first_bad}; {self.last_good} still has the old value "
            f"({self.tried} of {self.between} tried){skipped}"
        )


def bisect_nights(
    store: NightStore, figure: str, good: str, bad: str, part: str | None = None, note: Callable[[str], None] = ignore
) -> FoundStep:
    """Bisect a figure between two nights.

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

    Raises
    ------
    HistoryError
        If a night lacks the figure, no single part differs, its states can't be made, or an end is not confirmed.
    """
    was, now = figure_of(store, good, figure), figure_of(store, bad, figure)
    last, since = store.summary(good), store.summary(bad)
    command_of(was.identity)
    depends = tuple(sorted({*was.depends, *now.depends}))
    swaps, fixed = swaps_of(differing(last, since, depends))
    swap = the_one(swaps, fixed, part)
    with one_thread_each(), tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True) as scratch:
        states = releases_between(swap) if swap.distribution else commits_between(last, since, swap)
        walk = Walk(was, now, swap, swaps, states, last, since, depends, Path(scratch), note)
        try:
            found = bisect(len(states), walk.is_bad)
        except EndsError as error:
            raise HistoryError(f"{figure}: {error}") from None
    return told(figure, swap, states, found)


def told(figure: str, swap: Swap, states: list[str], found: Bisected) -> FoundStep:
    """Result with the names of the states."""
    skipped = tuple(states[k] for k in found.skipped)
    return FoundStep(
        figure, swap.name, states[found.last_good], states[found.first_bad], skipped, found.tried, len(states)
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
        if part not in names:
            differ = ", ".join(names) or "none"
            raise HistoryError(
                f"--part {part[:60]}: does not differ{nearest(part, names)}; those that differ: {differ}"
            )
        return names[part]
    if len(swaps) != 1:
        said = ", ".join(names) or "; ".join(fixed) or "none"
        raise HistoryError(f"{len(swaps)} parts differ that can be exchanged ({said}); name one with --part")
    return swaps[0]


def releases_between(swap: Swap) -> list[str]:
    """Releases from the old version to the new one; both are among them."""
    before, after = swap.suspect.before, swap.suspect.after
    assert before is not None
    assert after is not None
    ends = sorted((Version(before.version), Version(after.version)))
    known = [r.version for r in releases_of(swap.distribution) if ends[0] < r.version < ends[1]]
    found = [str(v) for v in (ends[0], *known, ends[1])]
    return found if Version(before.version) < Version(after.version) else found[::-1]


def commits_between(last: NightSummary, since: NightSummary, swap: Swap) -> list[str]:
    """Commits that touch a part's packages, from that of the good night to that of the bad one."""
    if not last.commit or not since.commit or "+" in last.commit + since.commit:
        raise HistoryError(
            f"{swap.name}: a night without a commit, or with changes that no commit has, can't be bisected"
        )
    folder = Path(__file__).parent
    paths = [name.replace(".", "/") for name in swap.packages]

    def git(*arguments: str, place: str = str(folder)) -> str:
        line = ["git", "-C", place, *arguments]
        try:
            return subprocess.run(line, capture_output=True, text=True, check=True, timeout=GIT_S).stdout.strip()
        except (OSError, subprocess.SubprocessError):
            raise HistoryError(f"{swap.name}: Git gives no commits between {last.commit} and {since.commit}") from None

    top = git("rev-parse", "--show-toplevel")
    given = git("rev-list", "--reverse", f"{last.commit}..{since.commit}", "--", *paths, place=top)
    return [last.commit, *given.split()] if given else [last.commit, since.commit]


@dataclass
class Walk:
    """Figure at each state of one part; all other parts that differ have the good night's state."""

    was: Figure
    now: Figure
    swap: Swap
    swaps: list[Swap]
    states: list[str]
    last: NightSummary
    since: NightSummary
    depends: tuple[str, ...]
    scratch: Path
    note: Callable[[str], None]

    def __post_init__(self) -> None:
        """Take what all states share."""
        self.runner = CellRunner(self.was.identity, self.scratch / "cells")
        self.trees = NightTrees(self.scratch / "trees", self.last, self.since, self.depends)
        self.base: Figure | None = None

    def is_bad(self, k: int) -> bool | None:
        """Whether a state has the new value; None if it does not run. The first state gives the old value."""
        found = self.measured(k)
        self.note(
            f"{self.swap.name} {self.states[k]}: {result_words(found)}{f' ({found.reason})' if found.missing else ''}"
        )
        if found.missing and not self.now.missing:
            return None
        factor = self.now.value / self.was.value if self.now.value and self.was.value else None
        if self.base is None:
            self.base = found
            return self.comparable and shows(self.was.identity, self.was, found, factor)
        return shows(self.was.identity, self.base, found, factor)

    @property
    def comparable(self) -> bool:
        """Whether the good night's figure should be found again here: on its machine class, and not a time."""
        here = capture().machine_class == self.last.environment.machine_class
        return here and self.was.identity.kind not in STEPPED

    def measured(self, k: int) -> Figure:
        """Figure at a state."""
        place = self.place(k)
        repeats = REPEATS if self.was.identity.kind in STEPPED else 1
        return middle([self.runner.figure(place, self.was.identity, repeat) for repeat in range(repeats)])

    def place(self, k: int) -> CellPlace:
        """Environment and sources of a state."""
        old: frozenset[str] = frozenset()
        pins = pins_of(old, self.swaps, self.since, self.depends)
        if self.swap.distribution:
            pins = [p for p in pins if not p.startswith(f"{self.swap.distribution}==")]
            return CellPlace((*pins, f"{self.swap.distribution}=={self.states[k]}"), self.trees.tree(old, self.swaps))
        target = self.scratch / "commits" / self.states[k]
        return CellPlace(tuple(pins), target if target.is_dir() else commit_tree(self.states[k], target))
