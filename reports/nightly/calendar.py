"""Calendar of nights as SVG: a column a week, one block a year; a sign and a colour for each state."""

from __future__ import annotations

import datetime
from collections import defaultdict
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from reports.results.nights.trends import CalendarNight

CELL, LEFT, TOP = 15.0, 30.0, 16.0
STATES = {
    "worse": ("▲", "a figure is worse than accepted"),
    "void": ("×", "void"),
    "incomplete": ("◐", "incomplete"),
    "changed": ("△", "changed; nothing is worse, or all that is worse is accepted"),
    "quiet": ("·", "nothing changed"),
}
"""Sign and words of each state, the gravest first: of several nights of a day the gravest is shown"""
WEEKDAYS = ("Mon", "", "Wed", "", "Fri", "", "Sun")
MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]


def year_blocks(nights: Sequence[CalendarNight], pages: Mapping[str, str]) -> list[tuple[int, Markup]]:
    """Calendars of all years with nights, the latest first; days of nights with a page are links."""
    days: dict[datetime.date, list[CalendarNight]] = defaultdict(list)
    for night in nights:
        days[datetime.datetime.fromisoformat(night.date).date()].append(night)
    years = sorted({day.year for day in days}, reverse=True)
    return [(year, block({d: n for d, n in days.items() if d.year == year}, pages)) for year in years]


def block(days: dict[datetime.date, list[CalendarNight]], pages: Mapping[str, str]) -> Markup:
    """One year, from the first week with a night to the last."""
    year, first, last = min(days).year, week_of(min(days)), week_of(max(days))
    columns = (last - first).days // 7 + 1
    width, height = max(LEFT + CELL * columns + 4.0, 180.0), TOP + 7 * CELL + 2.0
    linked = any(night.name in pages for own in days.values() for night in own)
    role = "group" if linked else "img"  # what is inside a picture is not read out
    parts = [
        f'<svg class="calendar" viewBox="0 0 {width:g} {height:g}" style="width:{width:g}px" role="{role}">',
        f"<title>Nights of {year}</title><desc>{escape(described(days))}</desc>",
        *(f'<text x="0" y="{TOP + CELL * k + 11:g}">{name}</text>' for k, name in enumerate(WEEKDAYS) if name),
        *month_words(first, columns, year),
    ]
    day = first
    while day <= last + datetime.timedelta(days=6):
        if day.year == year and min(days) <= day <= max(days):
            parts.append(cell(day, (day - first).days, days.get(day, []), pages))
        day += datetime.timedelta(days=1)
    return Markup("".join([*parts, "</svg>"]))


def week_of(day: datetime.date) -> datetime.date:
    """Monday of a day's week."""
    return day - datetime.timedelta(days=day.weekday())


def month_words(first: datetime.date, columns: int, year: int) -> list[str]:
    """Names of months above the week in which each begins; the first column has a name too."""
    found, before, free = [], 0, -1.0
    for column in range(columns):
        day = first + datetime.timedelta(days=7 * column + (0 if column == 0 and first.year == year else 6))
        x = LEFT + CELL * column
        if day.month != before and day.year == year and x >= free:
            found.append(f'<text x="{x:g}" y="{TOP - 5:g}">{MONTHS[day.month - 1]}</text>')
            free = x + 2 * CELL
        before = day.month
    return found


def cell(day: datetime.date, place: int, nights: Sequence[CalendarNight], pages: Mapping[str, str]) -> str:
    """One day."""
    x, y = LEFT + CELL * (place // 7), TOP + CELL * (place % 7)
    box = f'x="{x + 1:g}" y="{y + 1:g}" width="{CELL - 2:g}" height="{CELL - 2:g}" rx="2"'
    if not nights:
        return f'<rect class="none" {box}/>'
    gravest = min(nights, key=lambda night: list(STATES).index(night.state))
    state = gravest.state
    sign, words = STATES[state]
    many = f"{len(nights)} nights, the gravest: " if len(nights) > 1 else ""
    changes = sum(night.changes for night in nights)
    told = f", {plural(changes, 'change')}" if changes else ""
    drawn = (
        f'<g class="{state}"><title>{day.isoformat()}: {many}{words}{told}</title><rect {box}/>'
        f'<text x="{x + CELL / 2:g}" y="{y + CELL / 2 + 4:g}" text-anchor="middle">{sign}</text></g>'
    )
    return f'<a href="{escape(pages[gravest.name])}">{drawn}</a>' if gravest.name in pages else drawn


def described(days: dict[datetime.date, list[CalendarNight]]) -> str:
    """Words on a year for readers who don't see it."""
    nights = [night for own in days.values() for night in own]
    counts = {state: sum(night.state == state for night in nights) for state in STATES}
    return ", ".join(f"{count} {STATES[state][1]}" for state, count in counts.items() if count)
