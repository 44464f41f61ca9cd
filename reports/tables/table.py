"""Tables of a study as rows of the one relation, and back: each says once which of its columns is which row."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from reports.tables.rows import COLUMNS, NUMBERS, RELATIVE_TO, tag_text, typed

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import pandas as pd

PLACES = ("scene", "engine", "setting", "quantity", "metric")
"""Columns of the relation that a column of a table of the same name is; any other one is a tag"""


class Number(NamedTuple):
    """A number that a table has in a column: the row in which it is kept."""

    quantity: str
    """Empty: the quantity of the table's row"""
    metric: str
    unit: str = "1"
    low: str = ""
    """Columns of its interval"""
    high: str = ""
    text: str = ""
    """Column of the row's text"""
    relative_to: str = ""
    """What a ratio is relative to"""


@dataclass(frozen=True, eq=False)
class Table:
    """A table of a study: each of its rows is a row that has `metric`, and one more for each number, word and flag."""

    index: tuple[str, ...]
    """Columns that tell the rows of the table apart"""
    metric: str = ""
    """Empty where ``metric`` is one of them"""
    said: Mapping[str, str] = field(default_factory=dict)
    """Columns of the relation in the row of `metric` (value, low, outcome, reason …), and those of the table there"""
    unit: str = "1"
    numbers: Mapping[str, Number] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    """Further columns of text"""
    flags: tuple[str, ...] = ()
    """Columns of True and False"""
    sizes: tuple[str, ...] = ()
    """Columns of `index` that are numbers"""
    only: frozenset[str] = frozenset()
    """Quantities of the table's rows, where others have the same metrics"""
    named: Mapping[str, str] = field(default_factory=dict)
    """Columns of `index` that are kept under another name"""
    prefix: str = ""
    """Begin of the metrics of its numbers, words and flags, where other tables have the same"""
    relative_to: str = ""
    """What the value of `metric` is relative to"""

    @property
    def columns(self) -> tuple[str, ...]:
        """All columns, each once: those that tell rows apart, then those of `metric`, numbers, words and flags."""
        numbers = (c for name, of in self.numbers.items() for c in (name, of.low, of.high, of.text) if c)
        return tuple(dict.fromkeys((*self.index, *self.said.values(), *numbers, *self.words, *self.flags)))

    @property
    def texts(self) -> frozenset[str]:
        """Columns of text: an empty cell is an empty string."""
        index = {name for name in self.index if name not in self.sizes}
        said = {column for of, column in self.said.items() if of not in NUMBERS}
        return frozenset(index | said | {of.text for of in self.numbers.values() if of.text} | set(self.words))

    def framed(self, rows: Iterable[Mapping[str, object]] | pd.DataFrame) -> pd.DataFrame:
        """Rows as a table with all columns in their order and with their types; further columns are left out."""
        import pandas as pd  # noqa: PLC0415

        given = rows if isinstance(rows, pd.DataFrame) else pd.DataFrame(list(rows))
        found = given.reindex(columns=list(self.columns))
        for name in self.columns:
            if name in self.texts:
                found[name] = found[name].astype(object).where(found[name].notna(), "").astype(str)
            elif name in self.flags:
                found[name] = [value in (True, "True") for value in found[name]]
            else:
                found[name] = found[name].astype(float)
        return found.reset_index(drop=True)

    def to_rows(self, study: str, table: pd.DataFrame, place: Mapping[str, str]) -> pd.DataFrame:
        """Rows of a table of :meth:`framed`, all of one row of it together.

        Parameters
        ----------
        study : str
        table : DataFrame
        place : mapping
            Scene, engine or setting of all its rows.
        """
        import pandas as pd  # noqa: PLC0415

        empty = {name: "" for name in COLUMNS if name not in NUMBERS} | dict.fromkeys(NUMBERS, float("nan"))
        base = pd.DataFrame(empty | {"study": study} | dict(place), index=table.index)
        names = {name: self.named.get(name, name) for name in self.index}
        for name in (name for name, kept in names.items() if kept in PLACES):
            base[names[name]] = table[name]
        tags = [name for name, kept in names.items() if kept not in PLACES]
        pairs: list[dict[str, Any]] = [
            {str(k): v for k, v in each.items()} for each in table[tags].rename(columns=names).to_dict("records")
        ]
        base["tags"] = [tag_text(each) for each in pairs]
        main = base.assign(**{of: table[column] for of, column in self.said.items()})
        if self.metric:
            main["metric"] = self.metric
        if self.relative_to:
            main["tags"] = [tag_text(each | {RELATIVE_TO: self.relative_to}) for each in pairs]
        if "value" in self.said and "unit" not in self.said:
            main["unit"] = [self.unit if known else "" for known in main["value"].notna()]
        found = [main]
        for of, columns in self.kept():
            own = base.assign(metric=self.prefix + of.metric, **{kept: table[name] for name, kept in columns.items()})
            if of.quantity:
                own["quantity"] = of.quantity
            if of.relative_to:
                own["tags"] = [tag_text(each | {RELATIVE_TO: of.relative_to}) for each in pairs]
            if "value" in columns.values():
                own = own.assign(unit=of.unit, value=own["value"].astype(float))[own["value"].notna()]
            else:
                own = own[own["text"] != ""]
            found.append(own)
        return typed(pd.concat(found).sort_index(kind="stable"))

    def from_rows(self, rows: pd.DataFrame) -> pd.DataFrame:
        """Table of which some rows of a study are, as :meth:`framed` gave it.

        Parameters
        ----------
        rows : DataFrame
            Rows with a column for each tag (:func:`reports.tables.rows.spread`).
        """
        names = [self.named.get(name, name) for name in self.index]
        rows = rows.reindex(columns=list(dict.fromkeys((*rows.columns, *names))))
        for name, kept in zip(self.index, names, strict=True):
            if name not in self.sizes:
                rows[kept] = rows[kept].astype(object).where(rows[kept].notna(), "").astype(str)
        if self.only:
            rows = rows[rows["quantity"].isin(self.only)]
        main = rows[rows["metric"] == self.metric] if self.metric else rows
        keys = {name: f"key {name}" for name in dict.fromkeys((*names, "quantity"))}  # no column's name
        found = main[list(keys)].rename(columns=keys).assign(**{column: main[of] for of, column in self.said.items()})
        for of, columns in self.kept():
            own = rows[rows["metric"] == self.prefix + of.metric]
            same = [name for name in keys if not (of.quantity and name == "quantity")]
            if of.quantity:
                own = own[own["quantity"] == of.quantity]
            own = own[[*same, *columns.values()]].set_axis([*(keys[name] for name in same), *columns], axis=1)
            found = found.merge(own, "left", [keys[name] for name in same])
        found = found.assign(**{name: found[keys[kept]] for name, kept in zip(self.index, names, strict=True)})
        return self.framed(found)

    def kept(self) -> Iterable[tuple[Number, dict[str, str]]]:
        """Row of each number, word and flag, and the table's columns there with those of the relation."""
        for name, of in self.numbers.items():
            columns = {name: "value", of.low: "low", of.high: "high", of.text: "text"}
            yield of, {column: kept for column, kept in columns.items() if column}
        yield from ((Number("", name), {name: "text"}) for name in self.words)
        yield from ((Number("", name), {name: "value"}) for name in self.flags)
