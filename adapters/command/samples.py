"""Tables of samples that another program wrote: CSV or JSON lines, with the columns of a trajectory's table."""

from __future__ import annotations

import contextlib
import csv
import json
import os
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from adapters.engine import EngineError
from adapters.trajectory import from_frame
from scenarios.channels import STORED, TIME, Of, columns_without_number, numbered_columns, numbered_part
from scenarios.nearest import nearest
from scenarios.size_limits import MOST_NAME
from scenarios.text import cut, shorten

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from adapters.trajectory import Trajectory

NEEDED = (TIME, *columns_without_number(c for c in STORED if c.of is Of.TRACK))
SINGLE = tuple(columns_without_number(c for c in STORED if c.of is Of.CHAIN))
NUMBERED = tuple(numbered_columns())
"""Columns with the number of a bar or joint, from 1"""
MOST_BYTES = 1 << 30
"""Of a table: the values of the largest scene, 2e7, with 25 characters each, twice"""
MOST_LINE = 200
"""Characters of names in a reason"""


def read_trajectory(path: Path, *, ended: str = "", torque_bars: Sequence[int] = ()) -> Trajectory:
    """Trajectory of a table.

    Parameters
    ----------
    path : Path
    ended : str
        Reason why the run ended before its last sample.
    torque_bars : sequence of int
        Prescribed bars in the scene's order; the table's columns may have another.

    Raises
    ------
    EngineError
        If the file is not there, is no table, or has a column that no trajectory has, or lacks one.
    """
    frame = read_table(path)
    missing = [name for name in NEEDED if name not in frame]
    if missing:
        there = cut(", ".join(map(str, frame.columns)), MOST_LINE)
        raise EngineError(f"{path.name} lacks the column {missing[0]}; it has {there}")
    for name in map(str, frame.columns):
        first, _, again = name.rpartition(".")
        if again.isdigit() and first in frame:  # pandas numbers the columns of one name
            raise EngineError(f"{path.name} has two columns {first}")
        if not is_column(name):
            raise EngineError(
                f"{path.name} has a column {cut(name, MOST_NAME)}{nearest(name, examples())}; {allowed()}"
            )
    check_numbers(path.name, map(str, frame.columns))
    torques = [f"torque_bar_{bar}_N_m" for bar in torque_bars]
    given = [str(name) for name in frame.columns if str(name).startswith("torque_")]
    if given and sorted(given) != sorted(torques):
        there = cut(", ".join(given), MOST_LINE)
        raise EngineError(f"{path.name} has {there}; allowed: {', '.join(torques) or 'no torque'}")
    return from_frame(
        frame[[*(name for name in frame.columns if name not in given), *(torques if given else [])]], ended=ended
    )


def read_table(path: Path) -> pd.DataFrame:
    """Numbers of a table, in double precision, every digit read."""
    if not os.path.lexists(path):
        raise EngineError(f"the program wrote no {path.name}")
    if not path.is_file():
        raise EngineError(f"{path.name} is no regular file")
    if (size := path.stat().st_size) > MOST_BYTES:
        raise EngineError(f"{path.name} has {size} bytes, allowed: at most {MOST_BYTES}")
    try:
        if path.suffix == ".jsonl":
            return read_lines(path)
        check_rows(path)
        found = pd.read_csv(path, float_precision="round_trip", skipinitialspace=True, dtype=float)
        if not isinstance(found.index, pd.RangeIndex):
            raise EngineError(f"{path.name} has more values in a row than columns in its header")
        return found
    except UnicodeDecodeError as error:
        raise EngineError(f"{path.name} is no text in UTF-8: {error.reason} at byte {error.start}") from None
    except (ValueError, OverflowError, OSError) as error:
        said = first_fault(path) or " ".join(str(error).split())[:MOST_LINE]
        raise EngineError(f"{path.name} is no table of numbers: {said}") from None


def first_fault(path: Path) -> str:
    """Words on the first cell of a CSV that is no number; empty without one."""
    with contextlib.suppress(csv.Error, OSError), path.open(encoding="utf-8", newline="") as lines:
        rows = csv.reader(lines, skipinitialspace=True)
        names = next(rows, [])
        for k, row in enumerate(rows, 2):
            for name, cell in zip(names, row, strict=False):
                if cell.strip() and not is_number(cell):
                    return f"line {k}, column {cut(name, MOST_NAME)}: {shorten(cell)} is no number"
    return ""


def is_number(cell: str) -> bool:
    """Whether a cell holds a number in digits that all programs read."""
    try:
        return cell.isascii() and bool(np.isfinite(float(cell)))
    except ValueError:
        return False


def read_lines(path: Path) -> pd.DataFrame:
    """Numbers of a table of JSON lines, an object each.

    Raises
    ------
    EngineError
        With the first line that is something else.
    """
    rows = list[dict[str, float]]()
    with path.open(encoding="utf-8", errors="replace") as lines:
        for k, line in enumerate(lines, 1):
            try:
                if line.strip():
                    rows.append({name: float(value) for name, value in json.loads(line).items()})
            except (ValueError, TypeError, AttributeError, OverflowError, RecursionError):
                raise EngineError(f"{path.name}, line {k} is no JSON object of numbers") from None
    return pd.DataFrame(rows)


def check_rows(path: Path) -> None:
    """Check that no row has less fields than the header, which would be read as missing numbers.

    Raises
    ------
    EngineError
        With the line.
    """
    with path.open(encoding="utf-8", errors="replace") as lines:
        wanted = next(lines, "").count(",")
        for k, line in enumerate(lines, 2):
            if line.strip() and line.count(",") < wanted:
                said = f"has {line.count(',') + 1} of {wanted + 1} fields"
                raise EngineError(f"{path.name}, line {k} {said}")


def is_column(name: str) -> bool:
    """Whether a trajectory's table may have a column of that name."""
    part = numbered_part(name)
    return name in (*NEEDED, *SINGLE) or (part is not None and part[0] in NUMBERED)


def check_numbers(file: str, columns: Iterable[str]) -> None:
    """Check that bars and joints are numbered from 1, and none is left out; torques are of prescribed bars alone.

    Raises
    ------
    EngineError
        With a column that is out of the order.
    """
    numbers: dict[str, list[int]] = {}
    for name in columns:
        if (part := numbered_part(name)) and not name.startswith("torque_"):
            numbers.setdefault(part[0], []).append(part[1])
    for pattern, own in numbers.items():
        wrong = sorted(set(own) - set(range(1, len(own) + 1)))
        if wrong:
            allowed_here = cut(", ".join(pattern.format(j) for j in range(1, len(own) + 1)), MOST_LINE)
            raise EngineError(f"{file} has a column {pattern.format(wrong[0])}; allowed: {allowed_here}")


def examples() -> list[str]:
    """Names of columns, of the first bar or joint."""
    return [*NEEDED, *SINGLE, *(pattern.format(1) for pattern in NUMBERED)]


def allowed() -> str:
    """Words on the columns that a table may have."""
    first = ", ".join(pattern.format(1) for pattern in NUMBERED)
    return f"allowed: {', '.join([*NEEDED, *SINGLE])}, and from 1 for each bar or joint {first}"
