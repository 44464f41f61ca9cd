"""Samples of a file beside the solution at the instants of its rows, and the error of the digits that were written."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.trajectory import Trajectory
from barchain.metrics.quantities import components
from barchain.result_files.table import TableError
from barchain.runs.trajectory_checks import TIME_SLACK
from barchain.solutions.at_times import solution_at
from scenarios.channels import COMPARED
from scenarios.plural import plural

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array
    from barchain.result_files.channels import Channels
    from barchain.solutions.reference import ReferenceSolution

CLOSE = 0.1
"""Largest half unit of written instants, relative to the distance of the scene's samples, that may be rounded ones"""
EXACT = 1e-6
"""Largest departure of exact instants from a grid, relative to half a unit in the last place written"""
SUMMED = 1e-12
"""Largest departure of an instant from a sample of the scene, over its time: 1e4 roundings of a sum of steps"""
FEWEST_ROWS = 5
"""Least rows of a file whose mistakes are sought: few numbers fit by chance"""
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}
"""Units of times that a file may mean, and their sizes, s"""
SAME_END = 1e-3
"""Relative difference of two ends that are the same"""
TWICE = 2.0
"""Largest size of a value relative to the largest right one at which it has the digits of a right one"""


FAR_FEWER = 100.0
"""Error bar of a column over that of the finest one beside it, from which on it has far fewer digits"""


@dataclass(frozen=True)
class Samples:
    """A file's samples beside the solution that judges them, n instants."""

    trajectory: Trajectory
    solution: ReferenceSolution
    written: dict[str, Array]
    """(n,) error of writing of each quantity, in its unit"""
    judged: frozenset[str]
    """Quantities of which the file has a part"""
    whole: frozenset[str]
    """Quantities that the file has in all parts"""
    starts_late: bool = False
    """Whether the first row is the scene's start, which the file lacks"""
    absent: dict[str, NDArray[np.bool_]] = field(default_factory=dict)
    """Parts that the file lacks of arrays of which it has others, of the shape of a sample"""
    notes: list[str] = field(default_factory=list)
    """What was done with the file, in sentences"""
    bars: int = 0
    """Number of bars of a file with every channel of such a chain; 0 of another one"""
    other_time: str = ""
    """Question whether the times have another unit; empty without a reason for it"""
    too_few_digits: str = ""
    """Quantities that are in the file and say nothing, as their last digit exceeds all right values; empty without"""
    kept: dict[str, Any] = field(default_factory=dict)
    """What one diagnosis keeps for the next one, with other tolerances"""

    @property
    def enough(self) -> bool:
        """Whether there are enough rows for a mistake to be told from another."""
        return len(self.trajectory.t_s) >= FEWEST_ROWS

    @property
    def other_chain(self) -> str:
        """Sentence on a file that is of a chain of fewer bars; empty of any other."""
        if not 0 < self.bars < self.solution.scene.bars:
            return ""
        return f"the file has columns of {plural(self.bars, 'bar')}, the scene has {self.solution.scene.bars}"

    @property
    def complete(self) -> bool:
        """Whether invariants can be computed."""
        return self.whole >= {"attitude", "rate", "com", "com_velocity"}


def placed(channels: Channels, solution: ReferenceSolution) -> Samples:
    """Samples of a file at the instants of its rows, and the solution there.

    Parts that are not in the file hold the solution's values, and are not judged. So does a row at t = 0, where the
    file has none.

    Raises
    ------
    TableError
        If no row is inside the scene.
    """
    end_s, notes = float(solution.trajectory.t_s[-1]), list(channels.notes)
    asked = other_unit_of_time(channels, end_s, solution.scene.period_s)
    exact_s = TIME_SLACK * solution.scene.run.duration_s
    slack_s = channels.half_t_s + exact_s
    inside = channels.t_s <= end_s + exact_s
    after = int(np.count_nonzero(inside))
    ended = after > 0 and channels.t_s[after - 1] >= end_s - exact_s
    later = channels.t_s[after:] - slack_s[after:]
    inside[after : after + 1] = not ended and later[:1] <= end_s  # the end, as it was written
    if not inside.any() or (np.count_nonzero(inside) == 1 and channels.t_s[0] <= exact_s):
        ends = f"no row from t > 0 to {end_s:.6g} s, the end of {solution.scene.name}"
        begins = f"the first row is at t = {channels.t_s[0]:.9g} s; do its times count from the scene's start?"
        asked = asked or (begins if channels.t_s[0] > end_s else "")
        raise TableError("; ".join(filter(None, [f"{channels.file}: {ends}", asked])))
    if not inside.all():
        notes.append(f"{plural(int((~inside).sum()), 'row')} after the scene's end, t = {end_s:.6g} s, not judged")
    t, half_t = np.minimum(channels.t_s[inside], end_s), channels.half_t_s[inside]
    own = solution.trajectory.t_s
    above = np.clip(np.searchsorted(own, t), 1, len(own) - 1)
    nearest = np.where(own[above] - t < t - own[above - 1], own[above], own[above - 1]) if len(t) <= len(own) else t
    rounded = np.all(np.abs(nearest - t) <= half_t + SUMMED * t) and np.all(np.diff(nearest) > 0.0)
    if rounded and half_t.max() <= CLOSE * float(np.diff(own).min()):
        t, half_t = nearest, np.where(half_t > SUMMED * t, 0.0, np.abs(nearest - t))
    elif regular(t, slack_s[inside]):
        half_t = np.zeros(len(t))
    first = bool(t[0] > 0.0)
    if first:
        t, half_t = np.append(0.0, t), np.append(0.0, half_t)
        notes.append("no row at t = 0: the scene's start stands there")
    if not np.array_equal(t, own):
        notes.append(f"{plural(len(t) - first, 'row')}, up to t = {t[-1]:.6g} of {end_s:.6g} s")
        solution = solution_at(solution, t)
    return dataclasses.replace(filled(channels, solution, inside, half_t, notes), starts_late=first, other_time=asked)


def other_unit_of_time(channels: Channels, end_s: float, period_s: float) -> str:
    """Question of a last instant that is a scene's end in another unit than the file's; empty of any other."""
    last, given = float(channels.t_s[-1]) / channels.time_unit_s, channels.time_unit
    for unit, size_s in (TIME_UNITS | {"orbits": period_s}).items():
        if math.isclose(last * size_s, end_s, rel_tol=SAME_END) and size_s != channels.time_unit_s:
            return (
                f"the last row is at t = {last:.6g} {given}, and {last:.6g} {unit} are the scene's end: time [{unit}]?"
            )
    return ""


def regular(t_s: Array, slack_s: Array) -> bool:
    """Whether instants are multiples of their distance, and so exact however few digits they have."""
    if len(t_s) == 1:
        return False
    every = t_s[1] - t_s[0]
    return bool(np.all(np.abs(t_s - np.round(t_s / every) * every) <= EXACT * slack_s))


def filled(channels: Channels, solution: ReferenceSolution, inside: Any, half_t_s: Array, notes: list[str]) -> Samples:
    """Arrays of a file's channels, and the error of their digits."""
    seen, scene, n = solution.trajectory, solution.scene, len(solution.trajectory.t_s)
    rows = slice(n - int(np.count_nonzero(inside)), n)
    arrays, written, judged, whole, missing, few = {}, {}, set[str](), set[str](), list[str](), list[str]()
    absent: dict[str, NDArray[np.bool_]] = {}
    rounded: list[str] = []
    for channel in COMPARED:
        array, quantity = channel.array, channel.name
        right = getattr(seen, array)
        if right is None or not right.size:
            continue
        values_right = np.array(right).reshape(n, -1)
        values, error = values_right.copy(), np.zeros((n, right[0].size))
        names = channel.names(scene)
        there = [name in channels.values for name in names]
        for k, name in enumerate(names):
            if there[k]:
                values[rows, k] = channels.values[name][inside]
                error[rows, k] = of_right_size(channels.half_units[name][inside], values[rows, k], values_right[:, k])
        coarse = within_digits(values[rows], error[rows], values_right[rows], np.array(there))
        rounded += [names[k] for k in coarse]
        by_part = np.linalg.norm(error.reshape(n, -1, len(channel.stems)), axis=-1)
        written[quantity] = by_part.max(axis=-1) + half_t_s * speed(solution, quantity)
        missing += [name for name, found in zip(names, there, strict=True) if not found]
        size = np.linalg.norm(right.reshape(n, -1, len(channel.stems)), axis=-1).max()
        if any(there) and written[quantity].max() > size > solution.error[quantity].max():
            few.append(f"{quantity}: half a unit of its last digit exceeds all right values, {size:.2g} {channel.unit}")
            continue
        if any(there):
            judged.add(quantity)
            arrays[array] = values.reshape(right.shape)
            if not all(there):
                absent[array] = ~np.array(there).reshape(right.shape[1:])
        if all(there):
            whole.add(quantity)
    if missing:
        notes.append(f"not in the file, and not judged: {', '.join(missing)}")
    if rounded:
        notes.append(
            f"fewer digits than columns beside it: {', '.join(rounded)}; what its digits leave open is no error"
        )
    if channels.ignored:
        notes.append(f"columns that are not judged: {', '.join(channels.ignored)}")
    arrays = {array: getattr(seen, array) for array in ("com_m", "com_velocity_m_s")} | arrays
    turned = tuple(law.bar for law in scene.effects.prescribed_rotation)
    trajectory = Trajectory(seen.t_s, **arrays, ended=seen.ended, torque_bars=turned)  # type: ignore[arg-type]
    return Samples(
        trajectory, solution, written, frozenset(judged), frozenset(whole), absent=absent, notes=notes,
        bars=channels.bars, too_few_digits="; ".join(few),
    )  # fmt: skip


def within_digits(values: Array, error: Array, right: Array, there: NDArray[np.bool_]) -> list[int]:
    """Replace values of far fewer digits than those beside them by the nearest to the right ones that were written so.

    One error bar for all columns of a quantity would hide errors of the others.

    Parameters
    ----------
    values, error : ndarray, shape (n, k)
        Columns of a quantity and half a unit in the last place of each value; changed in place.
    right : ndarray, shape (n, k)
    there : ndarray of bool, shape (k,)
        Columns that the file has.

    Returns
    -------
    list of int
        Numbers of the columns that were changed.
    """
    size = error.max(axis=0)
    told = there & (np.ptp(values, axis=0) > 0.0)  # one value alone tells nothing of its digits
    finest = float(size[told].min(initial=np.inf))
    coarse = np.flatnonzero(there & (size > FAR_FEWER * finest))
    for k in coarse:
        values[:, k] = np.clip(right[:, k], values[:, k] - error[:, k], values[:, k] + error[:, k])
        error[:, k] = np.minimum(error[:, k], finest)
    return coarse.tolist()


def of_right_size(half_unit: Array, values: Array, right: Array) -> Array:
    """Half units in the last place of a column, (m,), none larger than those of values of the right size.

    A value that is far too large shows few digits, which are no error bar.
    """
    usual = np.abs(values) <= TWICE * float(np.abs(right).max())
    found: Array = np.minimum(half_unit, half_unit[usual].max(initial=0.0))
    return found


def speed(solution: ReferenceSolution, quantity: str) -> Array:
    """Rate of change of a quantity at the samples, (n,), in its unit a second, of its fastest part."""
    fine = solution.fine
    values = components(fine)[quantity]
    changing = np.linalg.norm(np.gradient(values, fine.t_s, axis=0), axis=-1).max(axis=-1)
    found: Array = np.interp(solution.trajectory.t_s, fine.t_s, changing)
    return found
