"""Channels of a table: columns by the names of `simulate --out` or by a mapping, in SI units, with error bars."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from barchain.result_files.instants import TIME, check, one_row_an_instant
from barchain.result_files.numbers import (
    FULL,
    CellError,
    Numbers,
    decimal_comma,
    half_of,
    half_single,
    numbers_of,
    seconds_of_dates,
)
from barchain.result_files.table import MOST_NAME, MOST_NAMES, TableError, listed, read_table
from barchain.result_files.units import UnitError, factor
from scenarios.channels import COMPARED, STORED, degree_column, unit_ending
from scenarios.derived_channels import DERIVED
from scenarios.named_file import UnreadableError
from scenarios.nearest import likeness, nearest, nearest_name
from scenarios.size_limits import LimitError
from scenarios.text import cut, shorten
from scenarios.toml.reading import read_text, tables_of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.result_files.table import Table
    from scenarios import Scene

SI_UNITS = {TIME: "s"} | {stem: channel.unit for channel in COMPARED for stem in channel.stems}
"""Channels that a file may have, ``{}`` for the number of a bar or joint, and their SI units"""
LEFT_ALONE = re.compile(
    "|".join(
        stem.format(r"\d+").replace("effect", r"\w+") + f"(?:{c.ending.lower()}|{degree_column(c.ending).lower()})?"
        for c in (*STORED, *DERIVED)
        if c not in COMPARED
        for stem in c.stems
    )
)
"""Columns of `simulate --out` that are not judged: what is not integrated, or has no meaning for others"""
ENDINGS = {
    unit_ending(unit).lower(): unit for unit in sorted(set(SI_UNITS.values()), key=lambda unit: (-len(unit), unit))
}
"""Units at the end of the names of `simulate --out`, in lower case, the longest first"""
HEADS = "|".join(dict.fromkeys(stem.partition("_{}")[0] for stem in SI_UNITS if "{}" in stem))
NUMBER = re.compile(rf"(?:{HEADS})_([0-9]{{1,9}})(?:_[xy])?$")
"""Channel of a numbered bar or joint"""
CHANNEL = re.compile(
    rf"(time|{'|'.join(stem.format('[0-9]+') for stem in SI_UNITS)})(?:\s*[,/:_]\s*|\s+in\s+|\s+)(\S.*)", re.IGNORECASE
)
"""Name of a channel, and a unit that follows without brackets"""
NUMBERED_NAME = re.compile(rf"^({HEADS})[\s_]*(?=[0-9])", re.IGNORECASE)
"""Begin of the name of a bar's or joint's channel, as in ``angle1`` and ``Angle 1``"""
ELEMENT = re.compile(rf"^({HEADS})\s*[\[(]\s*([0-9]{{1,9}})\s*[\])]", re.IGNORECASE)
"""The same as the element of an array, as in ``angle[1]`` of Modelica and ``angle(1)`` of Octave"""
BRACKETS = re.compile(r"(.*?)\s*[\[({]\s*([^\[\](){}]*?)\s*[\])}]")
IN_DEGREES = {"rad": "deg", "rad/s": "deg/s"}
"""Units of rotations without one of their own, in a file that says that these are in degrees"""
LIKE = 0.75
"""Likeness from which on a column is a channel that the file lacks, misspelt"""
MOST_HEADER = 200
"""Characters of a column's name that may be a channel"""
MOST_COMPARED = 50
"""Columns, and missing channels, among which misspelt names are sought: each pair is compared"""


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
    """Columns that are no channels of the scene, as they are told"""
    notes: list[str] = field(default_factory=list)
    """What was done with the file, in sentences"""
    time_unit: str = "s"
    time_unit_s: float = 1.0
    """Unit of the instants in the file, and its size in s"""

    @property
    def bars(self) -> int:
        """Number of bars of a file with every channel of such a chain; 0 of another one."""
        many = max((int(name.rpartition("_")[2]) for name in self.values if name.startswith("angle_")), default=0)
        joints = {f"reaction_{j}_{axis}" for j in range(1, many) for axis in "xy"}
        plain = {stem for channel in COMPARED if not channel.of.numbered for stem in channel.stems}
        needed = plain | {f"{what}_{j}" for j in range(1, many + 1) for what in ("angle", "rate")}
        reactions = {name for name in self.values if name.startswith("reaction_")}
        return many if needed <= self.values.keys() and reactions == joints else 0


def channel_units(scene: Scene) -> dict[str, str]:
    """Names of all channels that a scene has, and their SI units."""
    return {TIME: SI_UNITS[TIME]} | {name: channel.unit for channel in COMPARED for name in channel.names(scene)}


def read_mapping(path: Path) -> dict[str, str]:
    """Mapping of a TOML file: names of channels, each with its unit in brackets, to columns.

    Raises
    ------
    TableError
        If it is no TOML file, or a value is neither a column's name nor its number.
    """
    try:
        found = tables_of(read_text(path))
    except (LimitError, UnreadableError) as error:
        raise TableError(f"{path.name}: {error}") from None
    for name, column in found.items():
        if isinstance(column, bool) or not isinstance(column, str | int):
            raise TableError(
                f"{path.name}: {shorten(name)} = {shorten(column)} given, allowed: the name of a column, or its number"
            )
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
    table, units = read_table(path), channel_units(scene)
    taken, ignored = chosen(table, mapping, units)
    check_there(table, taken)
    check_ignored(table.file, scene, ignored, units, [name for name in units if name not in taken])
    if len(taken) == 1:
        channels, there = [name for name in units if name != TIME][:4], listed(table.names)
        raise TableError(
            f"{table.file} has no channel beside the time, such as {', '.join(channels)}; it has {there}; "
            "name them, e.g. --column 'angle_1 [deg]=...'"
        )
    read = converted(table, taken)
    sizes, unit_of_time = {}, "s"
    for name, (column, unit) in taken.items():
        try:
            sizes[name] = factor(unit, units[name], scene.period_s) if unit and not read[name].started else 1.0
        except UnitError as error:
            raise TableError(f"{table.file}, column {shorten(table.names[column])}: {error}") from None
        unit_of_time = unit if name == TIME and unit else unit_of_time
    values, halves = {}, {}
    for name, each in read.items():
        half_unit = each.half_unit if digits is None else np.maximum(each.half_unit, half_of(each.values, digits))
        values[name], halves[name] = sizes[name] * each.values, sizes[name] * half_unit
    check(table, values)
    values[TIME] = np.maximum(values[TIME], 0.0)
    rows, notes = one_row_an_instant(table, scene, values, halves[TIME])
    values, halves = ({name: each[rows] for name, each in found.items()} for found in (values, halves))
    single = [name for name, each in read.items() if each.single]
    if single:
        notes.append(f"single precision in {listed(single)}: however many digits are written, its error bar is 6e-8")
    if read[TIME].started:
        notes.append(f"dates: t counts from the first one, {read[TIME].started}")
    told = [cut(name, MOST_NAME) for name in ignored[:MOST_NAMES]]
    told += [f"{len(ignored) - MOST_NAMES} more"] if len(ignored) > MOST_NAMES else []
    return Channels(
        table.file, values.pop(TIME), halves.pop(TIME), values, halves, told, notes, unit_of_time, sizes[TIME]
    )  # fmt: skip


def chosen(
    table: Table, mapping: Mapping[str, str], units: Mapping[str, str]
) -> tuple[dict[str, tuple[int, str]], list[str]]:
    """Column and unit of each channel, and the names of the other columns.

    Raises
    ------
    TableError
        If a name of the mapping is none, or two columns have one channel.
    """
    named, by_mapping = mapped(table, mapping), {parted(channel)[0] for channel in mapping}
    found: dict[str, tuple[int, str]] = {}
    ignored: list[str] = []
    for c, header in enumerate(table.names):
        name, unit = parted(named.get(c, header))
        if name not in units and c in named:
            raise TableError(f"{shorten(name)} given as a channel{nearest(name, units)}, allowed: {listed([*units])}")
        if name not in units or (name in by_mapping and c not in named):
            if any(map(str.strip, table.columns[c])):
                ignored.append(header)
            continue
        if name in found:
            raise TableError(f"{table.file} has two columns of {name}")
        if not unit and c in named:
            unit = own_unit(header, units[name])
        row = table.units[c].strip().strip("[](){}").strip() if table.units else ""
        kind = IN_DEGREES.get(units[name], "") if table.degrees else ""
        found[name] = c, unit or ("" if row in ("-", "1") else row) or kind
    return found, ignored


def own_unit(header: str, wanted: str) -> str:
    """Unit in brackets of a column that a mapping names without one; empty where it is none of that quantity."""
    match = BRACKETS.fullmatch(cut(header.strip(), MOST_HEADER))
    try:
        return match[2] if match and factor(match[2], wanted, 1.0) else ""
    except UnitError:
        return ""


def mapped(table: Table, mapping: Mapping[str, str]) -> dict[int, str]:
    """Channels that a mapping gives to columns, by the columns from 0."""
    names = table.names
    bare = [match[1] if (match := BRACKETS.fullmatch(cut(name, MOST_HEADER))) else name for name in names]
    meant = {name: k for k, name in enumerate(bare) if bare.count(name) == 1}  # without its unit, where one has it
    meant |= {str(k): k - 1 for k in range(1, len(names) + 1)} | {name: k for k, name in enumerate(names)}
    found: dict[int, str] = {}
    for channel, given in mapping.items():
        column = meant.get(given, meant.get(" ".join(given.split())))
        if column is None:
            near = nearest(given, names[:MOST_NAMES])
            raise TableError(f"{table.file} has no column {shorten(given)}{near}; it has {listed(names)}")
        if column in found:
            raise TableError(
                f"column {shorten(given)} given for {shorten(found[column])} and for {shorten(channel)}, "
                "allowed: one channel"
            )
        found[column] = channel
    return found


def converted(table: Table, taken: Mapping[str, tuple[int, str]]) -> dict[str, Numbers]:
    """Numbers of the channels, of columns that a mapping or their names choose; faults in others count nothing.

    Raises
    ------
    TableError
        With the line of the first cell that is no number.
    """
    found, texts = dict[str, Numbers](), {name: table.columns[column] for name, (column, _) in taken.items()}
    try:
        name = TIME
        if (dates := seconds_of_dates(texts[TIME])) is not None:
            found[TIME] = dates
        rest = {name: each for name, each in texts.items() if name not in found}
        comma = decimal_comma(rest.values())
        for name, each in rest.items():
            found[name] = numbers_of(each, decimal_comma=comma)
    except CellError as error:
        raise table.fault(taken[name][0], error) from None
    except ValueError as error:
        raise TableError(f"{table.file}: {error}") from None
    if any(each.single for name, each in found.items() if name != TIME):  # what has one value alone tells nothing
        found = {name: each if name == TIME else as_single(each) for name, each in found.items()}
    if max(each.digits for each in found.values()) < FULL:
        return found
    exact = 0.5 * 10.0**-FULL
    return {
        name: replace(each, half_unit=exact * np.abs(each.values)) if not each.single and is_constant(each) else each
        for name, each in found.items()
    }


def as_single(numbers: Numbers) -> Numbers:
    """Numbers of a file of single precision: those that may be of single precision have its error bar."""
    if not numbers.maybe_single:
        return numbers
    half_unit = half_single(numbers.values)
    if not is_constant(numbers):
        half_unit = np.maximum(numbers.half_unit, half_unit)
    return replace(numbers, half_unit=half_unit, single=True)


def is_constant(numbers: Numbers) -> bool:
    """Whether a column has one value, which says nothing about its digits."""
    return bool(np.all(numbers.values == numbers.values[0]))


def parted(header: str) -> tuple[str, str]:
    """Name of a channel, and its unit, of a header such as ``angle_1 [deg]``, ``angle_1_rad`` or ``ANGLE_1, deg``."""
    text = NUMBERED_NAME.sub(r"\1_", " ".join(header.split()) if len(header) <= MOST_HEADER else "")
    text = ELEMENT.sub(r"\1_\2", text)
    match = BRACKETS.fullmatch(text)
    follows = None if match else CHANNEL.fullmatch(text)
    if follows:
        channel = TIME if follows[1].lower() == "time" else follows[1].lower()
        wanted, given = SI_UNITS[re.sub("[0-9]+", "{}", channel)], follows[2].replace("_per_", "/")
        for unit in (ENDINGS.get(f"_{given.lower()}", given), given.replace("_", "/"), given.replace("_", " ")):
            with contextlib.suppress(UnitError):
                factor(unit, wanted, 1.0)
                return channel, unit
    name, unit = (match[1].lower(), match[2]) if match else (text.lower(), "")
    ending = next((each for each in ENDINGS if name.endswith(each)), "")
    name = name.removesuffix(ending).replace(" ", "_")
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
    parts = ((parted(header)[0], header) for header in headers)
    names = {name: header for name, header in parts if name and not LEFT_ALONE.fullmatch(name)}
    numbers = {name: int(found[1]) for name in names if (found := NUMBER.match(name))}
    if 0 in numbers.values():
        first = next(name for name, number in numbers.items() if number == 0)
        raise TableError(f"{file} has a column {first}, and numbers bars from 0; allowed: from 1, as in angle_1")
    bars = max((number for name, number in numbers.items() if name.startswith(("angle", "rate"))), default=0)
    if bars > scene.bars:
        raise TableError(f"{file} has {bars} bars, the scene {scene.name} {scene.bars}; was another scene meant?")
    for name, header in list(names.items())[:MOST_COMPARED]:
        begun = next((each for each in missing if name.startswith(each) and not name[len(each) :][:1].isdigit()), "")
        if begun and (begun != TIME or CHANNEL.fullmatch(header)):
            raise TableError(
                f"{file} has no {begun}, but a column {shorten(header)}; rename it, e.g. to {begun} [{units[begun]}]"
            )
        near = nearest_name(name, list(missing)[:MOST_COMPARED])
        if near is not None and likeness(name, near) >= LIKE and name not in numbers:
            raise TableError(f"{file} has no {near}, but a column {shorten(header)}; rename it, or leave it out")


def check_there(table: Table, taken: Mapping[str, tuple[int, str]]) -> None:
    """Check that there is a time.

    Raises
    ------
    TableError
    """
    file, there = table.file, listed(table.names)
    if TIME not in taken and not table.named:
        raise TableError(f"{file} has no header; name its columns: --column t=1 --column 'angle_1 [deg]=2' ...")
    if TIME not in taken:
        raise TableError(f"{file} has no column t_s or time; it has {there}; name it: --column 't=...'")
