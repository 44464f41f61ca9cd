"""Channels of a table: columns by the names of `simulate --out` or by a mapping, in SI units, with error bars."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from barchain.given.table import TableError, half_of, read_columns
from barchain.given.units import UnitError, factor
from scenarios.nearest import likeness, nearest, nearest_name

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.given.table import Column
    from scenarios import Scene

TIME = "t"
PLAIN = {"t": "s", "com_x": "m", "com_y": "m", "com_vx": "m/s", "com_vy": "m/s"}
NUMBERED = {
    "angle_{}": "rad", "rate_{}": "rad/s", "reaction_{}_x": "N", "reaction_{}_y": "N", "torque_bar_{}": "N m",
    "impulse_{}_x": "N s", "impulse_{}_y": "N s",
}  # fmt: skip
"""Channels of bars and joints, from 1, and their SI units"""
LEFT_ALONE = re.compile(r"gap_\d+|com_residual|condition|position_\d+_[xy]")
"""Columns of `simulate --out` that are not judged: what is not integrated, or has no meaning for others"""
ENDINGS = {
    "_rad_s": "rad/s", "_m_s": "m/s", "_n_m": "N m", "_n_s": "N s", "_rad": "rad", "_m": "m", "_s": "s", "_n": "N",
}  # fmt: skip
"""Units at the end of the names of `simulate --out`, in lower case"""
NUMBER = re.compile(r"(?:angle|rate|reaction|torque_bar|impulse)_(\d+)(?:_[xy])?$")
"""Channel of a numbered bar or joint"""
LIKE = 0.75
"""Likeness from which on a column is a channel that the file lacks, misspelt"""
FIELDS = {
    "com_m": ("com_x", "com_y"), "com_velocity_m_s": ("com_vx", "com_vy"), "angle_rad": ("angle_{}",),
    "rate_rad_s": ("rate_{}",), "reaction_N": ("reaction_{}_x", "reaction_{}_y"), "torque_N_m": ("torque_bar_{}",),
    "impulse_N_s": ("impulse_{}_x", "impulse_{}_y"),
}  # fmt: skip
"""Arrays of a trajectory, and the channels of each of their parts"""


@dataclass(frozen=True)
class Channels:
    """Channels of a file in SI units, n rows."""

    file: str
    t_s: Array
    """(n,), increasing"""
    half_t_s: Array
    """(n,) half a unit in the last place written of the instants, s"""
    values: dict[str, Array]
    """(n,) by the names of :func:`channel_units`"""
    half_units: dict[str, Array]
    """(n,) half a unit in the last place written of each"""
    ignored: list[str] = field(default_factory=list)
    """Columns that are no channels of the scene"""

    @property
    def bars(self) -> int:
        """Number of bars of a file with every channel of such a chain; 0 of another one."""
        many = max((int(name.rpartition("_")[2]) for name in self.values if name.startswith("angle_")), default=0)
        joints = {f"reaction_{j}_{axis}" for j in range(1, many) for axis in "xy"}
        needed = {*PLAIN.keys() - {TIME}, *(f"{what}_{j}" for j in range(1, many + 1) for what in ("angle", "rate"))}
        reactions = {name for name in self.values if name.startswith("reaction_")}
        return many if needed <= self.values.keys() and reactions == joints else 0


def channel_units(scene: Scene) -> dict[str, str]:
    """Names of all channels that a scene has, and their SI units."""
    bars = range(1, scene.bars + 1)
    turned = [law.bar for law in scene.effects.prescribed_rotation]
    found = dict(PLAIN)
    for pattern, unit in NUMBERED.items():
        numbers: Iterable[int] = bars if pattern in ("angle_{}", "rate_{}") else bars[:-1]
        if pattern.startswith("torque"):
            numbers = turned
        if pattern.startswith("impulse") and not scene.effects.impulse:
            numbers = ()
        found |= {pattern.format(j): unit for j in numbers}
    return found


def read_mapping(path: Path) -> dict[str, str]:
    """Mapping of a TOML file: names of channels, each with its unit in brackets, to columns.

    Raises
    ------
    TableError
        If it is no TOML file, or a value is neither a column's name nor its number.
    """
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise TableError(f"{path.name}: {error}") from None
    for name, column in found.items():
        if isinstance(column, bool) or not isinstance(column, str | int):
            raise TableError(f"{path.name}: {name} = {column} given, allowed: the name of a column, or its number")
    return {name: str(column) for name, column in found.items()}


def read_channels(path: Path, scene: Scene, mapping: Mapping[str, str], digits: int | None = None) -> Channels:
    """Channels of a file.

    Parameters
    ----------
    path : Path
    scene : Scene
        Whose channels are meant.
    mapping : mapping of str to str
        Names of channels, each with its unit in brackets or in SI, to names or numbers of columns. Other columns are
        known by their own names.
    digits : int, optional
        Digits of each number that count, of a curve that was read off.

    Raises
    ------
    TableError
        If the file is no table, lacks times or every channel, or has a fault in a name, a unit or a row.
    """
    columns, units = read_columns(path), channel_units(scene)
    named, taken = mapped(path.name, columns, mapping), {parted(channel)[0] for channel in mapping}
    values: dict[str, Array] = {}
    halves: dict[str, Array] = {}
    ignored: list[str] = []
    for column in columns:
        header = named.get(column.name, column.name)
        name, unit = parted(header)
        if name not in units and column.name in named:
            raise TableError(f"{name} given as a channel{nearest(name, units)}, allowed: {', '.join(units)}")
        if name not in units or (name in taken and column.name not in named):
            ignored.append(column.name)
            continue
        if name in values:
            raise TableError(f"{path.name} has two columns of {name}")
        try:
            size = factor(unit, units[name], scene.period_s) if unit else 1.0
        except UnitError as error:
            raise TableError(f"{path.name}, column {column.name}: {error}") from None
        half_unit = column.half_unit if digits is None else np.maximum(column.half_unit, half_of(column.values, digits))
        values[name], halves[name] = size * column.values, size * half_unit
    check(path.name, values, columns)
    check_ignored(path.name, scene, ignored, units, [name for name in units if name not in values])
    return Channels(path.name, values.pop(TIME), halves.pop(TIME), values, halves, ignored)


def mapped(file: str, columns: list[Column], mapping: Mapping[str, str]) -> dict[str, str]:
    """Channels that a mapping gives to columns, by the names of the columns."""
    names = [column.name for column in columns]
    meant = {str(k): name for k, name in enumerate(names, 1)} | {name: name for name in names}
    found: dict[str, str] = {}
    for channel, given in mapping.items():
        name = meant.get(given)
        if name is None:
            raise TableError(f"{file} has no column {given}{nearest(given, names)}; it has {', '.join(names)}")
        if name in found:
            raise TableError(f"column {name} given for {found[name]} and for {channel}, allowed: one channel")
        found[name] = channel
    return found


def parted(header: str) -> tuple[str, str]:
    """Name of a channel, and its unit, of a header such as ``angle_1 [deg]``, ``angle_1_rad`` or ``ANGLE_1``."""
    match = re.fullmatch(r"(.*?)\s*[\[(]\s*(.*?)\s*[\])]", header.strip())
    name, unit = (match[1], match[2]) if match else (header.strip(), "")
    name = name.lower()
    ending = next((each for each in ENDINGS if name.endswith(each)), "")
    name = name.removesuffix(ending)
    return (TIME if name == "time" else name), unit or ENDINGS.get(ending, "")


def check_ignored(
    file: str, scene: Scene, headers: list[str], units: Mapping[str, str], missing: Collection[str]
) -> None:
    """Check that no column is meant as a channel: of bars from 0, of further bars, or misspelt.

    Parameters
    ----------
    file : str
    scene : Scene
    headers : list of str
        Of the columns that are no channels of the scene.
    units : mapping of str to str
        Units of all channels.
    missing : collection of str
        Channels of the scene that the file lacks.

    Raises
    ------
    TableError
        With the column.
    """
    names = {name: header for header in headers if not LEFT_ALONE.fullmatch(name := parted(header)[0])}
    numbers = {name: int(found[1]) for name in names if (found := NUMBER.match(name))}
    if 0 in numbers.values():
        first = next(name for name, number in numbers.items() if number == 0)
        raise TableError(f"{file} has a column {first}, and numbers bars from 0; allowed: from 1, as in angle_1")
    bars = max((number for name, number in numbers.items() if name.startswith(("angle", "rate"))), default=0)
    if bars > scene.bars:
        raise TableError(f"{file} has {bars} bars, the scene {scene.name} {scene.bars}; was another scene meant?")
    for name, header in names.items():
        begun = next((each for each in missing if re.match(rf"{each}(?![0-9])", name)), "")
        if begun:
            raise TableError(
                f"{file} has no {begun}, but a column {header}; rename it, e.g. to {begun} [{units[begun]}]"
            )
        near = nearest_name(name, missing)
        if near is not None and likeness(name, near) >= LIKE and name not in numbers:
            raise TableError(f"{file} has no {near}, but a column {header}; rename it, or leave it out")


def check(file: str, values: Mapping[str, Array], columns: list[Column]) -> None:
    """Check that there are rising times and some channel.

    Raises
    ------
    TableError
    """
    there = ", ".join(column.name for column in columns)
    if TIME not in values and all(column.name.isdigit() for column in columns):
        raise TableError(f"{file} has no header; name its columns: --column t=1 --column 'angle_1 [deg]=2' ...")
    if TIME not in values:
        raise TableError(f"{file} has no column t_s or time; it has {there}. A mapping names it, see --columns")
    if len(values) == 1:
        raise TableError(f"{file} has no channel beside the time; it has {there}. A mapping names them, see --columns")
    t = values[TIME]
    if not np.all(np.isfinite(t)) or t[0] < 0.0 or not np.all(np.diff(t) > 0.0):
        row = int(np.argmin(np.append(t[0] >= 0.0, np.diff(t) > 0.0))) + 1
        raise TableError(f"{file}: the times of its rows do not rise from 0 on, at row {row}: t = {t[row - 1]:.9g} s")
    for name, numbers in values.items():
        if not np.all(np.isfinite(numbers)):
            row = int(np.argmin(np.isfinite(numbers))) + 1
            raise TableError(f"{file}: {name} has no finite number in row {row}, t = {t[row - 1]:.6g} s")
