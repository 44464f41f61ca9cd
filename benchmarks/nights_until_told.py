"""Nights until a slow-down is told, planted in the real times of a history.

    python benchmarks/nights_until_told.py nights --before 20

The times are those of real nights, with the noise of a real machine. In each of several series, the times from one
night on are multiplied by a factor; all other series stay as they were. The history is then judged night by night.
Without a factor every step that is told is a false alarm.
"""

from __future__ import annotations

import argparse
import dataclasses
from statistics import median
from typing import TYPE_CHECKING

from barchain.nightly.figures.steps import time_changes
from barchain.nightly.history.nights import open_store

if TYPE_CHECKING:
    from barchain.nightly.figures.table import NumberSeries

FACTORS = (1.03, 1.05, 1.1, 1.2)


def slowed(series: NumberSeries, first: int, factor: float) -> NumberSeries:
    """Series with times multiplied from a night on."""
    values = series.table.values.copy()
    values[series.rows[first:], series.at[first:]] *= factor
    return dataclasses.replace(series, table=dataclasses.replace(series.table, values=values))


def nights_until(every: list[NumberSeries], which: int, before: int, factor: float) -> int | None:
    """Nights until a slow-down of one series is told; None if it never is."""
    planted = [slowed(s, before, factor) if k == which else s for k, s in enumerate(every)]
    for night in range(before + 1, len(every[which].at) + 1):
        _, fresh = time_changes([s.within(None, night) for s in planted])
        if any(c.identity == every[which].identity and (c.factor or 0.0) > 1.0 for c in fresh):
            return night - before
    return None


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("history")
    parser.add_argument("--before", type=int, default=20, help="nights before the slow-down")
    parser.add_argument("--kind", choices=["ratio", "memory"], default="ratio")
    asked = parser.parse_args()
    table = open_store(asked.history).numbers()
    found = [table.series(identity) for identity in table.identities if identity.kind == asked.kind]
    every = [one for one in found if len(one.at) > asked.before + 2]
    if not every:
        parser.error(f"no series of {asked.kind} has more than {asked.before + 2} nights with a number")
    nights = min(len(one.at) for one in every)
    every = [one.within(None, nights) for one in every]
    print(f"{len(every)} series, {nights} nights, {asked.before} of them before the slow-down")
    alarms = sum(
        len(time_changes([s.within(None, night) for s in every])[1]) for night in range(asked.before, nights + 1)
    )
    print(f"false alarms without a slow-down: {alarms} on {nights - asked.before + 1} nights")
    for factor in FACTORS:
        told = [nights_until(every, k, asked.before, factor) for k in range(len(every))]
        known = [n for n in told if n is not None]
        words = f"median {median(known):g}, largest {max(known)}" if known else ""
        print(f"{factor - 1.0:.0%}: told in {len(known)} of {len(told)} series; nights: {words}")


if __name__ == "__main__":
    main()
