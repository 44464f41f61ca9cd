"""Rates of false alarms and of missed faults, each with a 95 % interval."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from scipy.stats import binomtest

from barchain.studies.selftest.campaign.cells import TRIED, UNMODIFIED
from reports.tables.faults.campaign import ALL, CellClass

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.studies.selftest.campaign.cells import CampaignCell

CONFIDENCE = 0.95
MOST_FALSE_ALARMS = 0.005
"""Share of verdicts on unmodified engines that may be false alarms"""


@dataclass(frozen=True)
class Rate:
    """Rate of an event, of n times that it could happen."""

    what: str
    by: str
    """``engine``, ``fault`` or ``outcome``"""
    name: str
    n: int
    count: int

    @property
    def rate(self) -> float:
        """Share; not a number of nothing."""
        return self.count / self.n if self.n else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval: it covers its confidence on average, and holds for counts of zero."""
        if not self.n:
            return 0.0, 1.0
        found = binomtest(self.count, self.n).proportion_ci(CONFIDENCE, method="wilson")
        return float(found.low), float(found.high)

    def row(self) -> dict[str, Any]:
        """Row of the table."""
        low, high = self.interval
        return asdict(self) | {"rate": self.rate, "low": low, "high": high}


def rates(cells: list[CampaignCell]) -> list[Rate]:
    """All rates, those over everything first."""
    unmodified = [c for c in cells if not c.fault and c.kind in UNMODIFIED]
    tried = [c for c in cells if c.fault and c.kind in TRIED]
    faulty = [c for c in cells if c.fault and c.kind in (*TRIED, CellClass.BELOW, CellClass.BEYOND)]
    found = [Rate(str(CellClass.FALSE_ALARM), ALL, ALL, len(unmodified), count(unmodified, CellClass.FALSE_ALARM))]
    found.append(Rate(str(CellClass.MISSED), ALL, ALL, len(tried), count(tried, CellClass.MISSED)))
    alarms = {c.outcome: None for c in unmodified if c.kind is CellClass.FALSE_ALARM}
    found += [
        Rate(str(CellClass.FALSE_ALARM), "outcome", o, len(unmodified), sum(c.outcome == o for c in unmodified))
        for o in alarms
    ]
    found += each(unmodified, CellClass.FALSE_ALARM, "engine", lambda c: c.engine)
    found += each(unmodified, CellClass.LIMITED, "engine", lambda c: c.engine)
    found += each(tried, CellClass.MISSED, "engine", lambda c: c.engine)
    found += each(tried, CellClass.MISSED, "fault", lambda c: c.fault)
    found += each(faulty, CellClass.BELOW, "fault", lambda c: c.fault)
    return found + each(faulty, CellClass.BEYOND, "fault", lambda c: c.fault)


def each(cells: list[CampaignCell], kind: CellClass, by: str, key: Callable[[CampaignCell], str]) -> list[Rate]:
    """Rate of a class for each engine or fault, in the order in which they come."""
    names = dict.fromkeys(map(key, cells))
    groups = {name: [c for c in cells if key(c) == name] for name in names}
    return [Rate(str(kind), by, name, len(group), count(group, kind)) for name, group in groups.items()]


def count(cells: list[CampaignCell], kind: CellClass) -> int:
    """Cells of a class."""
    return sum(c.kind is kind for c in cells)


def passed(cells: list[CampaignCell]) -> bool:
    """Whether no fault above its detection limit is missed, and false alarms are as rare as they have to be."""
    false, missed = rates(cells)[:2]
    return missed.count == 0 and false.count <= math.ceil(MOST_FALSE_ALARMS * false.n)
