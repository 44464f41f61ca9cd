"""Charts of runs over time: the curves of channels, and the unit of time."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from reports.plotting.series import numbered
from scenarios.channels import CHANNELS, CLOCK, STORED, TIME, Of
from scenarios.derived_channels import DERIVED
from scenarios.effect_types import Gravity

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    import pandas as pd

    from reports.plotting.series import Array
    from scenarios.scene import Scene

SHOWN = (*CHANNELS["attitude"].columns, *CHANNELS["reaction"].columns)
"""Columns of angles, and of both components of reactions"""
ALL_CHANNELS = {channel.name: channel for channel in (*STORED, *DERIVED)}
"""Channels that a table may hold"""
OF_EFFECTS = "effect_"
"""Begin of stems in whose columns the name of an effect stands"""
WORDS = {Of.BARS: "bar", Of.LAWS: "bar", Of.JOINTS: "joint"}
UNITS_S = {"s": 1.0, "min": 60.0, "h": 3600.0}
ORBITS = "orbits"
TIME_UNITS = (*UNITS_S, ORBITS)
DEGREES = {"rad": "°", "rad/s": "°/s"}
"""Units of angles and rates in degrees, by those of the tables"""
LEAST_ORBITS = 0.5
"""Length of a run from which on its time is counted in orbits"""
MOST_OF_UNIT = {"s": 300.0, "min": 3.0 * 3600.0}
"""Longest run, s, whose time is counted in a unit"""


class DrawingError(ValueError):
    """What can't be drawn, and why; one line."""


@dataclass(frozen=True)
class Run:
    """A run that is drawn: its table, n rows."""

    name: str
    """In legends"""
    table: pd.DataFrame
    """Columns of the time and of all channels that are drawn"""
    scene: Scene | None = None

    @property
    def t_s(self) -> Array:
        """Instants that are drawn, (n,) s: of a run that goes on those of its clock, so that it follows the first."""
        found: Array = self.table[CLOCK if CLOCK in self.table else TIME].to_numpy(float)
        return found

    @property
    def period_s(self) -> float | None:
        """Period of its orbit, s; None where there is none, or where the scene is not known."""
        scene = self.scene
        return scene.period_s if scene and scene.bound and scene.effects.gravity is not Gravity.NONE else None


@dataclass(frozen=True)
class TimeChart:
    """One quantity of one run over time."""

    label: str
    """Name and unit"""
    values: Array
    """(n, k)"""
    each: str = ""
    """Word for one column, e.g. ``bar``; empty for a single one"""
    numbers: tuple[int, ...] = ()
    """(k,) of its bars or joints"""

    @property
    def names(self) -> list[str]:
        """Name of each column; empty without a word for one."""
        return [f"{self.each} {j}" for j in self.numbers] if self.each else []


class Chosen(NamedTuple):
    """Numbers of the bars and joints that are drawn, all of them where none is named, and the unit of angles."""

    bars: Collection[int] = ()
    joints: Collection[int] = ()
    degrees: bool = False


EVERY = Chosen()


def main_charts(table: pd.DataFrame, chosen: Chosen = EVERY) -> list[TimeChart]:
    """Attitude, magnitude of reactions, change of the CM's radius and residual, as far as a table holds them.

    Raises
    ------
    DrawingError
        If the table has none of the chosen bars or joints.
    """
    angle, x, y = (numbered(table, name) for name in SHOWN)
    found = [] if angle is None else [of_numbers("attitude, rad", angle, "bar", chosen.bars)]
    if x is not None and y is not None:
        found.append(of_numbers("magnitude of reactions, N", np.hypot(x, y), "joint", chosen.joints))
    track = list(CHANNELS["com"].columns)
    if set(track) <= set(table.columns):
        radius = np.linalg.norm(table[track].to_numpy(float), axis=1)
        found.append(TimeChart("change of the CM's radius, m", (radius - radius[:1])[:, None]))
    if "com_residual_m" in table:
        found.append(TimeChart("centre-of-mass residual, m", table[["com_residual_m"]].to_numpy(float)))
    return found


def channel_charts(table: pd.DataFrame, name: str, chosen: Chosen = EVERY) -> list[TimeChart]:
    """Charts of a channel, one for each component and effect; empty of a table without its columns.

    Raises
    ------
    DrawingError
        If the table has none of the chosen bars or joints.
    """
    channel, found = ALL_CHANNELS[name], []
    for label, columns in columns_of(table, name).items():
        numbers = sorted(columns)
        values = table[[columns[j] for j in numbers]].to_numpy(float)
        wanted = chosen.joints if channel.of is Of.JOINTS else chosen.bars
        each = WORDS.get(channel.of, "")
        found.append(of_numbers(label, values, each, wanted if each else (), tuple(numbers)))
    return found


def of_numbers(
    label: str, values: Array, each: str, wanted: Collection[int], numbers: tuple[int, ...] = ()
) -> TimeChart:
    """Chart of the wanted ones of some columns; of all where none is named.

    Raises
    ------
    DrawingError
        If there is none of them.
    """
    numbers = numbers or tuple(range(1, values.shape[1] + 1))
    kept = [k for k, number in enumerate(numbers) if not wanted or number in wanted]
    if not kept and wanted:
        given, there = ", ".join(map(str, sorted(wanted))), ", ".join(map(str, numbers)) or "none"
        raise DrawingError(f"{each} {given}: {label.partition(',')[0]} has no such {each}, allowed: {there}")
    return TimeChart(label, values[:, kept], each, tuple(numbers[k] for k in kept))


def columns_of(table: pd.DataFrame, name: str) -> dict[str, dict[int, str]]:
    """Columns of a channel that a table has, by the label of a component and by number; 0 where there is none."""
    channel, found = ALL_CHANNELS[name], dict[str, dict[int, str]]()
    unit = "" if channel.unit == "1" else f", {channel.unit}"
    common = shared_begin(channel.stems)
    for stem, pattern in zip(channel.stems, channel.columns, strict=True):
        component = stem.removeprefix(common).replace("_", " ") if len(channel.stems) > 1 else ""
        numbered_pattern = pattern.format("(?P<number>[0-9]{1,9})")
        search = re.compile(re.sub(f"^{OF_EFFECTS}", "(?P<effect>.+)_", numbered_pattern))
        for column in map(str, table.columns):
            if not (match := search.fullmatch(column)):
                continue
            parts = match.groupdict()
            effect = parts.get("effect", "").replace("_", " ")
            label = " ".join(filter(None, [effect, channel.shown_label.removeprefix("effect "), component])) + unit
            found.setdefault(label, {})[int(parts.get("number", 0))] = column
    return found


def shared_begin(stems: Sequence[str]) -> str:
    """Longest text with which all of some stems begin."""
    first, last = min(stems), max(stems)
    return first[: next((k for k, pair in enumerate(zip(first, last, strict=False)) if pair[0] != pair[1]), len(first))]


def charts_of(runs: Sequence[Run], channels: Sequence[str], chosen: Chosen = EVERY) -> dict[str, dict[int, TimeChart]]:
    """Charts of all runs by label, and by the number of the run; the main ones where no channel is named.

    Raises
    ------
    DrawingError
        If there is nothing to draw.
    """
    found: dict[str, dict[int, TimeChart]] = {}
    for k, run in enumerate(runs):
        named = [chart for name in channels for chart in channel_charts(run.table, name, chosen)]
        for chart in named if channels else main_charts(run.table, chosen):
            shown = in_degrees(chart) if chosen.degrees else chart
            found.setdefault(shown.label, {})[k] = shown
    if not found:
        raise DrawingError(f"{', '.join(run.name for run in runs)}: no column of a channel that is drawn by default")
    return found


def in_degrees(chart: TimeChart) -> TimeChart:
    """Chart of an angle or of a rate in degrees; any other chart as it is."""
    quantity, _, unit = chart.label.rpartition(", ")
    if unit not in DEGREES:
        return chart
    return replace(chart, label=f"{quantity}, {DEGREES[unit]}", values=np.degrees(chart.values))


def fitting_unit(runs: Sequence[Run]) -> str:
    """Unit of time in which the longest run is a small number: orbits where there are some, else s, min or h."""
    end_s = max((float(run.t_s[-1]) for run in runs if len(run.t_s)), default=0.0)
    periods = [run.period_s for run in runs]
    if all(period is not None and end_s >= LEAST_ORBITS * period for period in periods):
        return ORBITS
    return next((unit for unit, most_s in MOST_OF_UNIT.items() if end_s <= most_s), "h")


def in_unit(run: Run, unit: str) -> Array:
    """Instants of a run in a unit, (n,).

    Raises
    ------
    DrawingError
        If the unit is orbits, and the run has none.
    """
    if unit != ORBITS:
        return run.t_s / UNITS_S[unit]
    if run.period_s is None:
        reason = "its scene has no closed orbit" if run.scene else "its scene is not known"
        raise DrawingError(f"{run.name}: time in orbits needs an orbit, and {reason}; allowed: {', '.join(UNITS_S)}")
    return run.t_s / run.period_s
