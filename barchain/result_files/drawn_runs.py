"""Tables of runs that are drawn: columns as `simulate` writes them, in any form of text or as Parquet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from barchain.result_files.numbers import CellError, decimal_comma, numbers_of
from barchain.result_files.table import TableError, read_table
from reports.motion.charts import ALL_CHANNELS, columns_of
from reports.results.reading import read_parquet
from scenarios import scene_names
from scenarios.channels import CLOCK, TIME, radian_column
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

COMPARED = "trajectories"
"""Folder of a comparison with a folder for each scene"""
PARQUET = ".parquet"


def read_run_table(path: Path) -> pd.DataFrame:
    """Time and channels of a file, n rows in SI units; of a run that goes on its clock, too.

    Raises
    ------
    TableError, DamagedResultsError, OSError
        If the file is no such table, or holds no channel; the message names the line of a cell that is no number.
    """
    found = read_parquet(path, [TIME]) if path.suffix == PARQUET else of_text(path)
    found = found.assign(**{name: np.radians(found[given]) for name, given in in_degrees(found.columns).items()})
    known = known_columns(found)
    if not known:
        there = ", ".join(map(str, found.columns[:8]))
        raise TableError(f"{path.name} has no column of `simulate` beside {TIME}, such as angle_1_rad; it has {there}")
    found = found[[*instants_in(found.columns), *known]]
    if len(found) < 2 or not (np.diff(found[TIME].to_numpy(float)) >= 0.0).all():
        raise TableError(f"{path.name}: {TIME} does not rise over two rows at least")
    return found


def of_text(path: Path) -> pd.DataFrame:
    """Table of a text file, its channels as numbers.

    Raises
    ------
    TableError
        If it is no table, has no time, or has a cell that is no number.
    """
    table = read_table(path)
    if TIME not in table.names:
        raise TableError(f"{table.file} has no column {TIME}{nearest(TIME, table.names)}; columns are as in `simulate`")
    texts = dict(zip(table.names, table.columns, strict=True))
    degrees = in_degrees(table.names)
    known = known_columns(pd.DataFrame(columns=[*table.names, *degrees]))
    wanted = [degrees.get(name, name) for name in (*instants_in(table.names), *known)]
    values = {}
    try:
        comma = decimal_comma(texts[name] for name in wanted)
        for name in wanted:
            values[name] = numbers_of(texts[name], decimal_comma=comma).values
    except CellError as error:
        raise table.fault(table.names.index(name), error) from None
    except ValueError as error:
        raise TableError(f"{table.file}: {error}") from None
    return pd.DataFrame(values | {name: np.nan for name in table.names if name not in values})


def in_degrees(names: Collection[str]) -> dict[str, str]:
    """Columns in degrees, as `simulate --degrees` writes them, by the columns in rad that they stand for."""
    return {radian_column(name): name for name in names if radian_column(name) not in names}


def instants_in(names: Collection[str]) -> list[str]:
    """Columns of the time, and of the clock where there is one."""
    return [name for name in (TIME, CLOCK) if name in names]


def known_columns(table: pd.DataFrame) -> list[str]:
    """Columns of a table that are those of a channel, in its order."""
    groups = [columns for name in ALL_CHANNELS for columns in columns_of(table, name).values()]
    known = {column for columns in groups for column in columns.values()}
    return [name for name in map(str, table.columns) if name in known]


def scene_of(path: Path) -> str:
    """Name of the scene in whose folder a comparison keeps a run; empty where it is none that comes with barchain."""
    parts = path.resolve().parts[:-1]
    if COMPARED not in parts:
        return ""
    name = "/".join(parts[len(parts) - parts[::-1].index(COMPARED) :])
    return name if name in scene_names() else ""
