"""File of a night, and the numbers over many nights that times and trends need: one matrix, figure × night."""

from __future__ import annotations

import io
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.nightly.figures.figure import Figure, FigureIdentity, FigureKind, FigureUnit

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from barchain.nightly.figures.figure import EarlierNames, Night, NightSummary

    Array = NDArray[np.float64]
    Places = NDArray[np.intp]


FIGURES = "figures.parquet"
IDENTITY = ("scene", "engine", "setting", "quantity", "kind", "unit", "anchor")
NUMBERS = ("value", "low", "high", "tolerance")
WORDS = ("word", "trajectory", "reason", "depends")
COLUMNS = (*IDENTITY, *NUMBERS, *WORDS, "versions")
"""Columns of a night's file; ``versions`` has those of the distributions behind a figure's engines, for readers"""
CHARTED = (FigureKind.ERROR, FigureKind.RATIO, FigureKind.MEMORY, FigureKind.COUNT)
"""Kinds whose numbers are looked at over many nights"""
ENGINE, PROGRAM = "engine:", "program:"
MEMBERS = "\n"
"""Between the names of parts; none of them holds it"""
FIGURES_KEPT = 2**14
"""Figures that are made once, as most are the same on many nights"""


def figures_content(night: Night) -> bytes:
    """File of a night's figures: a row each, in columns :data:`COLUMNS`; an empty text where there is none."""
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    own = night.figures
    columns: dict[str, Any] = {name: [str(getattr(f.identity, name)) for f in own] for name in IDENTITY}
    columns |= {name: [getattr(f, name) for f in own] for name in (*NUMBERS, *WORDS[:-1])}
    columns["depends"] = [MEMBERS.join(f.depends) for f in own]
    columns["versions"] = [versions_of(f, night) for f in own]
    schema = pa.schema([(name, pa.float64() if name in NUMBERS else pa.string()) for name in COLUMNS])
    sink = io.BytesIO()
    pq.write_table(pa.table({name: columns[name] for name in COLUMNS}, schema=schema), sink, compression="zstd")
    return sink.getvalue()


def versions_of(figure: Figure, night: Night | NightSummary) -> str:
    """Versions of the distributions and programs behind a figure's engines, e.g. ``mujoco 3.3.0``."""
    parts = (night.part_named[name] for name in figure.depends if name.startswith((ENGINE, PROGRAM)))
    known = (part for part in parts if part.version or part.name.startswith(ENGINE))
    return ", ".join(f"{part.name.partition(':')[2].partition(' (')[0]} {part.version}" for part in known)


def columns_of(content: bytes, names: Sequence[str]) -> list[list[Any]]:
    """Columns of a night's file; equal texts of a column are one object."""
    texts = [name for name in names if name not in NUMBERS]
    rows, found = rows_of(content, names, texts), []
    for name in names:
        if name in texts:
            codes, words = coded(rows[name])
            found.append([words[k] for k in codes.tolist()])
        else:
            found.append(rows[name].to_pylist())
    return found


def rows_of(content: bytes, names: Sequence[str], texts: Sequence[str]) -> Any:
    """Columns of a night's file as a table of Arrow, texts as dictionaries."""
    import pyarrow.parquet as pq  # noqa: PLC0415

    whole = pq.ParquetFile(io.BytesIO(content), read_dictionary=texts)
    return whole.read(columns=list(names), use_threads=False)  # a thread of Arrow that starts late aborts at the exit


def coded(column: Any) -> tuple[Places, list[str]]:
    """Places of a column's texts among its different texts, and these."""
    whole = column.combine_chunks()
    places: Places = whole.indices.to_numpy()
    return places, whole.dictionary.to_pylist()


def read_figures(content: bytes, fits: Callable[[tuple[str, ...]], bool] | None = None) -> list[Figure]:
    """Figures of a night's file; those alone whose columns :data:`IDENTITY` fit, if that is asked."""
    columns = columns_of(content, COLUMNS[:-1])
    keys, results = zip(*columns[: len(IDENTITY)], strict=True), zip(*columns[len(IDENTITY) :], strict=True)
    pairs = zip(keys, results, strict=True)
    return [figure_of(identity_of(*key), *result) for key, result in pairs if fits is None or fits(key)]


@lru_cache(FIGURES_KEPT)
def identity_of(*key: str) -> FigureIdentity:
    """Identity of a figure of its columns, in the order of :data:`IDENTITY`."""
    scene, engine, setting, quantity, kind, unit, anchor = key
    return FigureIdentity(scene, engine, setting, quantity, FigureKind(kind), FigureUnit(unit), anchor)


@lru_cache(FIGURES_KEPT)
def figure_of(identity: FigureIdentity, *result: Any) -> Figure:
    """Figure of its identity and the columns of its result."""
    value, low, high, tolerance, word, trajectory, reason, depends = result
    return Figure(identity, value, word, low, high, tolerance, trajectory, parts_in(depends), reason)


def parts_in(text: str) -> tuple[str, ...]:
    """Names of parts in a text of the column ``depends``."""
    return tuple(text.split(MEMBERS)) if text else ()


@dataclass(frozen=True)
class NumberTable:
    """Numbers of the charted figures of some nights."""

    nights: tuple[NightSummary, ...]
    """In their order"""
    identities: tuple[FigureIdentity, ...]
    values: Array
    """Shape (identities, nights), NaN without a number"""
    depends: NDArray[np.int32]
    """Places in `parts`, of the same shape"""
    parts: Sequence[str]
    """Names of the parts that a figure depends on"""

    @cached_property
    def row(self) -> dict[FigureIdentity, int]:
        """Numbers of the rows."""
        return {identity: k for k, identity in enumerate(self.identities)}

    @cached_property
    def names(self) -> NDArray[np.str_]:
        """Names of the nights."""
        return np.array([night.name for night in self.nights], str)

    def among(self, nights: Iterable[NightSummary]) -> NumberTable:
        """Numbers of some of the nights."""
        kept = np.isin(self.names, [night.name for night in nights])
        own = tuple(night for night, there in zip(self.nights, kept, strict=True) if there)
        return replace(self, nights=own, values=self.values[:, kept], depends=self.depends[:, kept])

    def series(self, identity: FigureIdentity, earlier: EarlierNames = ()) -> NumberSeries:
        """Numbers of a figure, up to the last night of each earlier name under that name."""
        rows, at, since = [np.zeros(0, np.intp)], [np.zeros(0, np.intp)], 0
        ends = [int(np.searchsorted(self.names, last, "right")) for _, last in earlier]
        for name, end in zip((*(name for name, _ in earlier), identity), (*ends, len(self.nights)), strict=True):
            if name in self.row:
                at.append(since + np.flatnonzero(~np.isnan(self.values[self.row[name], since:end])))
                rows.append(np.full(len(at[-1]), self.row[name], np.intp))
            since = max(since, end)
        return NumberSeries(self, identity, np.concatenate(rows), np.concatenate(at), earlier)


@dataclass(frozen=True)
class NumberSeries:
    """Numbers of one figure over the nights that measured it, in their order."""

    table: NumberTable
    identity: FigureIdentity
    rows: Places
    """Of the table, shape (n,): other ones under earlier names"""
    at: Places
    """Numbers of the nights in the table, shape (n,)"""
    earlier: EarlierNames = ()

    @cached_property
    def values(self) -> Array:
        """Numbers, shape (n,)."""
        found: Array = self.table.values[self.rows, self.at]
        return found

    @property
    def nights(self) -> list[NightSummary]:
        """Nights that measured the figure."""
        return [self.table.nights[k] for k in self.at.tolist()]

    def depends(self, k: int) -> tuple[str, ...]:
        """Names of the parts that the figure of one of these nights depends on."""
        return parts_in(self.table.parts[self.table.depends[self.rows[k], self.at[k]]])

    def figure(self, k: int) -> Figure:
        """Figure of one of these nights."""
        return Figure(self.identity, float(self.values[k]), depends=self.depends(k))

    def within(self, first: int | None, last: int | None) -> NumberSeries:
        """Series of some of its nights, from one to before another one."""
        return replace(self, rows=self.rows[first:last], at=self.at[first:last])


def read_numbers(nights: Iterable[tuple[NightSummary, bytes]]) -> NumberTable:
    """Numbers of some nights in their order, each with the file of its figures."""
    import pyarrow as pa  # noqa: PLC0415

    whole, tables, texts = [], [], [*IDENTITY, "depends"]
    for k, (night, content) in enumerate(nights):
        own = rows_of(content, [*texts, "value"], texts)
        tables.append(own.append_column("night", pa.array(np.full(len(own), k))))
        whole.append(night)
    if not tables:
        return NumberTable((), (), np.zeros((0, 0)), np.zeros((0, 0), np.int32), ())
    rows = pa.concat_tables(tables).unify_dictionaries()
    codes, words = {}, {}
    for name in texts:
        codes[name], words[name] = coded(rows[name])
    numbers, night_of = rows["value"].to_numpy(), rows["night"].to_numpy()
    charted = np.isin(codes["kind"], [k for k, kind in enumerate(words["kind"]) if kind in CHARTED])
    kept = charted & ~np.isnan(numbers)
    sizes = [len(words[name]) for name in IDENTITY]
    keys, row = np.unique(np.ravel_multi_index([codes[name][kept] for name in IDENTITY], sizes), return_inverse=True)
    values, depends = np.full((len(keys), len(whole)), np.nan), np.zeros((len(keys), len(whole)), np.int32)
    at = row, night_of[kept]
    values[at], depends[at] = numbers[kept], codes["depends"][kept]
    named = zip(IDENTITY, np.unravel_index(keys, sizes), strict=True)
    columns = [[words[name][k] for k in own.tolist()] for name, own in named]
    identities = tuple(identity_of(*key) for key in zip(*columns, strict=True))
    return NumberTable(tuple(whole), identities, values, depends, tuple(words["depends"]))
