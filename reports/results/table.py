"""Tables of a study as rows of the one relation, and back: each column says once which cell of which row it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from reports.results.rows import COLUMNS, IDENTITY, NUMBERS, RELATIVE_TO, number, parsed_tags, records, tag_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import pandas as pd

    from reports.results.rows import Row, Rows

CELLS = set(COLUMNS) - set(IDENTITY)
TYPED: dict[type, Callable[[Any], Any]] = {
    str: lambda value: "" if value is None or (isinstance(value, float) and math.isnan(value)) else str(value),
    float: number,
    bool: lambda value: value in (True, "True"),
}
"""Value of a cell of each type; an empty cell is an empty text, NaN or False"""


class TableRow(NamedTuple):
    """Row of the relation in which a row of a table has some of its columns."""

    own: dict[str, str]
    """What it has of its own: metric, quantity, and what a ratio is relative to"""
    unit: str
    columns: dict[str, str]
    """Columns of the table by the relation's"""


@dataclass(frozen=True, eq=False)
class Table:
    """A table of a study: each of its rows is a row with `metric`, and further ones of the same identity."""

    index: tuple[str, ...]
    """Columns that tell the rows of the table apart, kept under the same names"""
    metric: str
    """Empty where ``metric`` is one of them"""
    cells: Mapping[str, str] = field(default_factory=dict)
    """Further columns, each with its cell, ``metric:quantity/relative_to.column unit``.

    ``error:attitude rad`` is the value of the row with this metric and quantity, ``seconds:build.low`` the lower end of
    another value, ``.reason`` in the row of `metric` itself. Without a quantity the row has that of the table's row;
    without a unit a number has the unit 1. A further row without its value, or else without its text, is left out.
    """
    flags: tuple[str, ...] = ()
    """Columns of `cells` that are True or False"""
    sizes: tuple[str, ...] = ()
    """Columns of `index` that are numbers"""
    only: frozenset[str] = frozenset()
    """Quantities of the table's rows, where others have the same metrics"""

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns."""
        return (*self.index, *self.cells)

    @cached_property
    def rows(self) -> list[TableRow]:
        """Rows that a row of the table is, first that of `metric`."""
        found = {"": TableRow({"metric": self.metric} if self.metric else {}, "1", {})}
        for name, text in self.cells.items():
            place, _, unit = text.partition(" ")
            row, _, column = place.rpartition(".")
            row, column = (row, column) if column in CELLS else (place, "value")  # metrics have points in their names
            where, _, relative_to = row.partition("/")
            metric, _, quantity = where.partition(":")
            own = {"metric": metric, "quantity": quantity, RELATIVE_TO: relative_to}
            same = found.setdefault(where, TableRow({}, "1", {}))
            same.own.update({key: value for key, value in own.items() if value})
            same.columns[column] = name
            found[where] = same._replace(unit=unit or same.unit)
        return list(found.values())

    @cached_property
    def types(self) -> dict[str, type]:
        """Type of each column: str, where an empty cell is an empty text, float or bool."""
        found: dict[str, type] = {name: float if name in self.sizes else str for name in self.index}
        for row in self.rows:
            found |= {name: float if column in NUMBERS else str for column, name in row.columns.items()}
        return found | dict.fromkeys(self.flags, bool)

    def lines(self, rows: Iterable[Row] | pd.DataFrame) -> list[Row]:
        """Rows of the table with all its columns, each of its type; further columns are left out."""
        return [{name: TYPED[kind](row.get(name)) for name, kind in self.types.items()} for row in records(rows)]

    def framed(self, rows: Iterable[Row] | pd.DataFrame) -> pd.DataFrame:
        """Rows of the table as :meth:`lines`, with its columns in their order."""
        import pandas as pd  # noqa: PLC0415

        return pd.DataFrame(self.lines(rows), columns=list(self.columns)).astype(self.types)

    def add_rows(self, found: Rows, lines: Iterable[Row], place: Row) -> None:
        """Add the rows of :meth:`lines`; `place` has the scene, engine or setting of all of them."""
        for line in lines:
            where = {**place, **{name: line[name] for name in self.index}}
            for row in self.rows:
                cells = {column: line[name] for column, name in row.columns.items()}
                there = not math.isnan(cells.get("value", math.nan))
                if row is self.rows[0] or there or ("value" not in cells and cells["text"]):
                    found.add(**where | row.own | {"unit": row.unit if there else ""} | cells)

    def from_rows(self, rows: Iterable[Row]) -> pd.DataFrame:
        """Table of which some rows of a study are, as :meth:`framed` gave it."""
        found: dict[tuple[Any, str, str], Row] = {}
        metrics = {row.own.get("metric", "") for row in self.rows}
        for row in (row for row in rows if row["metric"] in metrics or not self.metric):
            tags = row["tags"]
            if RELATIVE_TO in tags and RELATIVE_TO not in self.index:
                tags = tag_text({name: tag for name, tag in parsed_tags(tags).items() if name != RELATIVE_TO})
            place = row["scene"], row["engine"], row["setting"], tags
            found[place, row["metric"], row["quantity"]] = row
        lines = []
        for (place, metric, quantity), main in found.items():
            if metric == (self.metric or metric) and (quantity in self.only or not self.only):
                here = main | parsed_tags(main["tags"])
                line = {name: here.get(name) for name in self.index}
                for own, _, columns in self.rows:
                    cells = found.get((place, own.get("metric", metric), own.get("quantity", quantity)), {})
                    line |= {name: cells.get(column) for column, name in columns.items()}
                lines.append(line)
        return self.framed(lines)
