"""Start of a scene in a state of another run: tables with `[start]`, as tables with that state."""

from __future__ import annotations

import csv
import math
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from scenarios.channels import CHANNELS, CLOCK, TIME, degree_column
from scenarios.effect_types import Frame
from scenarios.nearest import nearest
from scenarios.size_limits import MOST_KEY
from scenarios.text import shorten, visible
from scenarios.toml.resolve import IncompleteError
from scenarios.toml.scene_tables import ANGLE_KEYS, RATE_KEYS, StartTable

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from scenarios.scene import Scene

    Data = dict[str, Any]
    Row = Mapping[str, Any]

OWN = ("angle_from", "centre_m", *ANGLE_KEYS, *RATE_KEYS)
"""Keys of `[chain]` that a state stands for"""
SAME_INSTANT = 1e-9
"""Relative difference of an instant that is written with ten digits"""
MET = 1e-6
"""Share of the fastest rate by which a held bar may turn in a state: digits of a file, drift of its engine"""


class OnlyStart(BaseModel):
    """The one table of a file that is read before the others."""

    start: StartTable


def state_tables(
    t_s: float, position_m: Sequence[float], velocity_m_s: Sequence[float], angle_rad: Sequence[float],
    rate_rad_s: Sequence[float],
) -> Data:  # fmt: skip
    """Tables of a scene that starts in a state; the clock of its effects goes on."""
    return {
        "orbit": {"position_m": list(position_m), "velocity_m_s": list(velocity_m_s)},
        "chain": {"angle_from": "inertial", "angle_rad": list(angle_rad), "rate_rad_s": list(rate_rad_s)},
        "run": {"start_s": t_s},
    }


def with_state(tables: Data, folder: Path) -> Data:
    """Tables of a file whose `[start]` has become the state that it names.

    Parameters
    ----------
    tables : dict
    folder : Path
        Folder that the path of the run is relative to.

    Raises
    ------
    ValidationError
        If `[start]` itself is not valid.
    IncompleteError
        If the run can't be read, has no such row or state, or the file gives another start besides.
    """
    if "start" not in tables:
        return tables
    start = OnlyStart.model_validate({"start": tables["start"]}).start
    chain = tables["chain"] if isinstance(tables.get("chain"), dict) else {}
    twice = ["orbit"] * ("orbit" in tables) + [f"chain.{key}" for key in OWN if key in chain]
    if twice:
        raise IncompleteError(f"{twice[0]}: given beside [start], whose row has it; allowed: one of the two")
    row, bars = chosen_row(start, folder), chain.get("bars")
    bars = bars if isinstance(bars, int) else 0
    (angle_j,), (rate_j,) = CHANNELS["attitude"].columns, CHANNELS["rate"].columns
    angles, rates = ([column.format(j) for j in range(1, bars + 1)] for column in (angle_j, rate_j))
    further = angle_j.format(bars + 1)
    if further in row or degree_column(further) in row:
        raise IncompleteError(f"chain.bars: {bars} given, and {start.from_} has more bars; allowed: as many")
    columns = (CHANNELS["com"].columns, CHANNELS["com_velocity"].columns, angles, rates)
    place, velocity, angle, rate = (numbers(start, row, names) for names in columns)
    clock_s = numbers(start, row, [CLOCK if CLOCK in row else TIME])[0]
    state = state_tables(clock_s, place, velocity, angle, rate)
    run = tables["run"] if isinstance(tables.get("run"), dict) else {}
    others = {key: value for key, value in tables.items() if key != "start"}
    return others | {"orbit": state["orbit"], "chain": chain | state["chain"], "run": state["run"] | run}


def chosen_row(start: StartTable, folder: Path) -> Row:
    """Row of the run that `[start]` names: by number, by time, or the last."""
    path, last = folder / start.from_, None
    nearest_s: float | None = None
    for number, row in enumerate(rows_of(start, path), 1):
        if start.row == number:
            return row
        if start.time_s is not None:
            t_s = numbers(start, row, [TIME])[0]
            if math.isclose(t_s, start.time_s, rel_tol=SAME_INSTANT, abs_tol=SAME_INSTANT):
                return row
            if nearest_s is None or abs(t_s - start.time_s) < abs(nearest_s - start.time_s):
                nearest_s = t_s
        last = row
    if last is None:
        raise IncompleteError(f"start.from: {start.from_} has no rows")
    if start.row is not None:
        raise IncompleteError(f"start.row: {start.row} given, allowed: 1 to {number}, the rows of {start.from_}")
    if nearest_s is not None:
        raise IncompleteError(
            f"start.time_s: {start.time_s:g} given, allowed: the instant of a row; the nearest is {nearest_s!r} s"
        )
    return last


def rows_of(start: StartTable, path: Path) -> Iterator[Row]:
    """Rows of a run's table by its columns; texts of a CSV file, numbers of a Parquet file."""
    if path.suffix not in (".csv", ".parquet"):
        raise IncompleteError(
            f"start.from: {shorten(start.from_)} given, allowed: a file that ends with .csv or .parquet"
        )
    try:
        if not path.is_file():
            raise IncompleteError(f"start.from: {visible(path)}: no such file")
        if path.suffix == ".parquet":
            import pandas as pd  # noqa: PLC0415  # most scenes read no table

            yield from pd.read_parquet(path).to_dict("records")  # type: ignore[misc]
            return
        with path.open(newline="", encoding="utf-8-sig") as lines:
            yield from csv.DictReader(lines)
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        if isinstance(error, IncompleteError):
            raise
        raise IncompleteError(f"start.from: {visible(path)} can't be read: {shorten(str(error))}") from None


def numbers(start: StartTable, row: Row, names: Sequence[str]) -> list[float]:
    """Finite numbers of some columns of a row; in degrees where it has these instead, as of `simulate --degrees`."""
    found = []
    for name in names:
        there = name if name in row else degree_column(name)
        if there not in row:
            near = nearest(name, [column for column in row if column and len(column) <= MOST_KEY])
            raise IncompleteError(
                f"start.from: {start.from_} has no column {name}{near}; allowed: the columns of `barchain simulate`"
            )
        try:
            value = float(row[there]) if there == name else math.radians(float(row[there]))
        except (TypeError, ValueError):
            value = math.nan
        if not math.isfinite(value):
            raise IncompleteError(
                f"start.from: {shorten(row[there])} in the column {there} of {start.from_}, allowed: a number"
            )
        found.append(value)
    return found


def need_met_laws(scene: Scene) -> None:
    """Check that a state in which a scene goes on turns its prescribed bars and joints as their laws do there: not.

    To catch a moving joint is an impact, in which other bars jump, too. Bars that follow the local horizontal are left
    out: a bar's own longitude tells.

    Raises
    ------
    IncompleteError
        If a law would have to stop its bar or joint at once.
    """
    rates = [factor * scene.orbital_rate_rad_s for factor in scene.chain.rate_factor]
    for law in scene.effects.prescribed_rotation:
        joint = law.frame is Frame.PREVIOUS_BAR
        if law.frame is Frame.LOCAL_HORIZONTAL:
            continue
        against = rates[law.bar - 2] if joint else 0.0
        if abs(rates[law.bar - 1] - against) > MET * scene.fastest_rate_rad_s:
            whose = f"bar {law.bar} turns {f'against bar {law.bar - 1} ' if joint else ''}at"
            raise IncompleteError(
                f"effects.prescribed_rotation: {whose} {rates[law.bar - 1] - against:.4g} rad/s in the state of the "
                "start, where its law holds it; allowed: a state at rest there, such as barchain.latched gives, as to "
                "catch it in motion is an impact"
            )
