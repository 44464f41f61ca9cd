"""The smallest detected size of each continuous fault, by bisection over powers of two."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from barchain.studies.selftest.check_results import tried
from barchain.studies.selftest.trial import Trial
from barchain.studies.selftest.trial_runner import untold
from reports.tables.faults.selftest import CAUGHT, MISSED, FaultOutcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from barchain.faults.fault import Fault, Size
    from barchain.studies.selftest.check_results import FaultCell, Reading
    from barchain.studies.selftest.trial_runner import TrialRunner
    from reports.tables.rows import Rows
    from scenarios import Scene

OCTAVES = 44  # below the natural size: 6e-14 of it, with the natural 1 % less than a rounding of the faulty value


@dataclass(frozen=True)
class Bracket:
    """Bracket of one fault's detection limit in one scene; sizes are powers of two of the natural one."""

    scene: Scene
    host: str
    fault: Fault
    caught: int | None = None
    """Smallest known to be caught"""
    missed: int | None = None
    """Largest known to be missed"""
    by: Reading | None = None
    """Check that caught it"""

    @property
    def size(self) -> Size:
        """Its size, which it has."""
        assert self.fault.size is not None
        return self.fault.size

    @property
    def highest(self) -> int:
        """Largest power that is tried."""
        if self.size.most is None:
            return 0
        return max(0, round(math.log2((self.size.most - self.size.none) / (self.size.natural - self.size.none))))

    @property
    def next(self) -> int | None:
        """Power to be tried next: the natural size, the largest, then between; None where it is settled."""
        if self.caught is None:
            untried = [k for k in (0, self.highest) if self.missed is None or k > self.missed]
            return untried[0] if untried else None
        low = -OCTAVES - 1 if self.missed is None else self.missed
        return None if self.caught - low <= 1 else (self.caught + low) // 2

    def at(self, power: int) -> float:
        """Size of a power."""
        return self.size.none + (self.size.natural - self.size.none) * 2.0**power

    def trial(self, power: int) -> Trial:
        """Trial at the size of a power."""
        return Trial(self.scene, self.host, self.fault.name, self.at(power))

    def told(self, power: int, by: Reading | None) -> Bracket:
        """Bracket narrowed by the outcome at a power."""
        return replace(self, missed=power) if by is None else replace(self, caught=power, by=by)

    def add_rows(self, found: Rows) -> None:
        """Add a row for each of the two sizes that is known."""
        where: dict[str, Any] = {"scene": self.scene.name, "engine": self.host, "fault": self.fault.name}
        if self.caught is not None:
            found.add(CAUGHT, self.at(self.caught), text=self.by.quantity if self.by else "", **where)
        if self.missed is not None:
            found.add(MISSED, self.at(self.missed), **where)


def brackets(cells: Iterable[FaultCell], scenes: Iterable[Scene], host: str) -> list[Bracket]:
    """Pairs of a continuous fault and a scene in which it was inserted, with the outcome at its natural size."""
    named = {scene.name: scene for scene in scenes}
    tried = [c for c in cells if c.fault.size and c.readings]
    return [
        Bracket(named[c.scene], host, c.fault).told(0, c.worst if c.fate is FaultOutcome.KILLED else None)
        for c in tried
    ]


def most_trials(pairs: list[Bracket]) -> int:
    """Largest number of trials that :func:`settled` may take."""
    return sum(math.ceil(math.log2(OCTAVES + 1 + max(1, p.highest))) for p in pairs)


def settled(pairs: list[Bracket], runner: TrialRunner, done: Callable[[int], None] = untold) -> list[Bracket]:
    """Brackets narrowed to a factor of two, in rounds of one trial each."""
    open_pairs = {(p.fault.name, p.scene.name): p for p in pairs}
    while True:
        asked = {name: k for name, p in open_pairs.items() if (k := p.next) is not None}
        if not asked:
            return list(open_pairs.values())
        trials = [open_pairs[name].trial(power) for name, power in asked.items()]
        for one in tried(trials, runner):
            name = one.fault.name, one.scene
            by = one.worst if one.fate is FaultOutcome.KILLED else None
            open_pairs[name] = open_pairs[name].told(asked[name], by)
            done(1)
