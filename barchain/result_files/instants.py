"""Rows of a file by their instants: rising times, finite numbers, and one row an instant."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.result_files.table import TableError
from barchain.runs.trajectory_checks import TIME_SLACK
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array
    from barchain.result_files.table import Table
    from scenarios import Scene

TIME = "t"
SAME_ROW = 1e-9
"""Difference of two rows of one instant, relative to the largest of each channel, up to which they are the same: an
iteration at an event leaves it"""
FEW_DIGITS = 0.25
"""Half a unit of the instants, relative to their usual distance, from which on rows may share one for want of digits"""
MOST_SIZE = 1e100
"""Largest number that can be judged: its cube is a double"""


def check(table: Table, values: Mapping[str, Array]) -> None:
    """Check that all numbers are finite and of sizes that can be judged, and that times rise from 0 on, or stay.

    Raises
    ------
    TableError
    """
    file, t = table.file, values[TIME]
    for name, numbers in values.items():
        bad = np.flatnonzero(~np.isfinite(numbers))
        if len(bad):
            raise TableError(f"{file}, {table.where(bad[0])}: {name} is no finite number")
        bad = np.flatnonzero(np.abs(numbers) > MOST_SIZE)
        if len(bad):
            size = f"{numbers[bad[0]]:.3g}, allowed: up to {MOST_SIZE:.0e}"
            raise TableError(f"{file}, {table.where(bad[0])}: {name} is {size}; has the run diverged?")
    falls = np.flatnonzero(np.append(t[0] < -TIME_SLACK * t[-1], np.diff(t) < 0.0))
    if len(falls):
        row = int(falls[0])
        raise TableError(f"{file}, {table.where(row)}: the times do not rise from 0 on; t = {t[row]:.9g} s")


def one_row_an_instant(
    table: Table, scene: Scene, values: Mapping[str, Array], half_t_s: Array
) -> tuple[list[int], list[str]]:
    """First rows of all instants, and a note on the others.

    Programs write two or three rows at an event. Where these differ, the first one is the motion before it, as the
    solution's samples are.

    Raises
    ------
    TableError
        If rows of an instant differ where the scene has no event.
    """
    t, slack = values[TIME], TIME_SLACK * scene.run.duration_s
    later = np.flatnonzero(np.diff(t) <= slack) + 1
    if not len(later):
        return list(range(len(t))), []
    kept = np.setdiff1d(np.arange(len(t)), later)
    first = kept[np.searchsorted(kept, later) - 1]
    apart = np.zeros(len(later))
    for name, each in values.items():
        if name != TIME:
            change = np.abs(each[later] - each[first])
            apart = np.maximum(apart, change / max(float(np.abs(each).max()), np.finfo(float).tiny))
    differ = apart > SAME_ROW
    breaks = np.array([*scene.effects.breaks_s, np.inf])
    near = np.abs(breaks - t[later, None]).min(axis=1) <= half_t_s[later] + slack
    edges = scene.effects.solar_pressure is not None and scene.effects.solar_pressure.shadow
    wrong = np.flatnonzero(differ & ~near & (not edges))
    if len(wrong):
        one, two = int(first[wrong[0]]), int(later[wrong[0]])
        lines = f"lines {table.lines[one]} and {table.lines[two]} have one time, t = {t[one]:.9g} s, and differ"
        if len(kept) > 1 and half_t_s[two] >= FEW_DIGITS * float(np.median(np.diff(t[kept]))):
            raise TableError(f"{table.file}: {lines}; write more digits of the times")
        raise TableError(f"{table.file}: {lines}; allowed: one row an instant, or some at an event of the scene")
    notes = []
    if not differ.all():
        notes.append(f"{plural(int((~differ).sum()), 'row')} with the time and the numbers of the row before left out")
    if differ.any():
        count, when = plural(int(differ.sum()), "row"), ", ".join(f"{x:.6g}" for x in np.unique(t[later[differ]])[:5])
        notes.append(
            f"{count} of the motion after an event not judged, first at t = {when} s: the first row shows it before"
        )
    return kept.tolist(), notes
