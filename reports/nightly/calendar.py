"""Calendar of nights: a table a month, with a sign and a colour for the state of each day."""

from __future__ import annotations

import datetime
from calendar import Calendar
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from reports.results.nights.trends import CalendarNight

STATES = {
    "worse": ("▲", "a figure is worse than accepted"),
    "void": ("×", "void"),
    "incomplete": ("◐", "incomplete"),
    "changed": ("△", "changed; nothing is worse, or all that is worse is accepted"),
    "first": ("○", "first night: nothing to compare it with"),
    "quiet": ("·", "nothing changed"),
}
"""Sign and words of each state, the gravest first: of several nights of a day the gravest is shown"""


@dataclass(frozen=True)
class Day:
    """Day of a month."""

    number: int
    state: str = ""
    """Empty without a night"""
    words: str = ""
    """State in words, for a pointer and for readers who don't see the sign"""
    page: str = ""
    """Address of the night's page; empty without one"""


def months(nights: Sequence[CalendarNight], pages: Mapping[str, str]) -> list[tuple[str, list[list[Day | None]]]]:
    """Months with nights, the latest first, by weeks from Monday on; a day of another month is None."""
    own: dict[datetime.date, list[CalendarNight]] = defaultdict(list)
    for night in nights:
        own[datetime.datetime.fromisoformat(night.date).date()].append(night)
    found = []
    for year, month in sorted({(date.year, date.month) for date in own}, reverse=True):
        weeks = Calendar().monthdatescalendar(year, month)
        days = [[day_of(date, own[date], pages) if date.month == month else None for date in week] for week in weeks]
        found.append((f"{weeks[1][0]:%B} {year}", days))
    return found


def day_of(date: datetime.date, nights: Sequence[CalendarNight], pages: Mapping[str, str]) -> Day:
    """Day with its nights."""
    if not nights:
        return Day(date.day)
    gravest = min(nights, key=lambda night: list(STATES).index(night.state))
    many = f"{len(nights)} nights, the gravest: " if len(nights) > 1 else ""
    changes = sum(night.changes for night in nights)
    told = f", {plural(changes, 'change')}" if changes else ""
    words = f"{date.isoformat()}: {many}{STATES[gravest.state][1]}{told}"
    return Day(date.day, gravest.state, words, pages.get(gravest.name, ""))
