"""Figures of many nights as one table of columns, sorted by series and night, and the file of one night's figures.

A history of a thousand nights has millions of figures. The table holds numbers and codes only; figures become objects
where a rule looks at them. Files of whole months are gathered in a cache of the user's, which may be deleted.
"""

from __future__ import annotations

import contextlib
import fnmatch
import hashlib
import io
import itertools
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.nightly.faults import UnknownFigureError
from barchain.nightly.figures import (
    Figure,
    FigureIdentity,
    FigureKind,
    FigureSeries,
    FigureUnit,
    NightSummary,
    ValueSeries,
)
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Sequence

    import pyarrow as pa
    from numpy.typing import NDArray

    Places = NDArray[np.intp]


FIGURES = "figures.parquet"
IDENTITY = ("scene", "engine", "setting", "quantity", "kind", "unit", "anchor")
NUMBERS = ("value", "low", "high", "tolerance")
WORDS = ("word", "trajectory", "reason", "depends")
COLUMNS = (*IDENTITY, *NUMBERS, *WORDS)
JUDGED = ("value", "word", "tolerance", "low", "high")
"""Columns that the rules look at"""
DENSE_NIGHTS = 16
"""Last nights of which every figure is looked at: two turns of parts that divide their scenes among a week, and two
more"""
BETWEEN, MEMBERS = "\t", "\n"
"""Between the parts of a series' key, and the names of parts; no text of a figure holds them"""
MONTH = 7
"""Characters of a night's name that tell its month"""


def figures_content(figures: Iterable[Figure]) -> bytes:
    """File of a night's figures: a row each, in columns :data:`COLUMNS`; an empty text where there is none."""
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    own = list(figures)
    columns: dict[str, Any] = {name: [str(getattr(f.identity, name)) for f in own] for name in IDENTITY}
    columns |= {name: [getattr(f, name) for f in own] for name in (*NUMBERS, *WORDS[:-1])}
    columns["depends"] = [MEMBERS.join(f.depends) for f in own]
    schema = pa.schema([(name, pa.float64() if name in NUMBERS else pa.string()) for name in COLUMNS])
    sink = io.BytesIO()
    pq.write_table(pa.table({name: columns[name] for name in COLUMNS}, schema=schema), sink, compression="zstd")
    return sink.getvalue()


def figures_in(content: bytes) -> tuple[Figure, ...]:
    """Figures of the file of a night."""
    import pyarrow.parquet as pq  # noqa: PLC0415

    rows = pq.read_table(io.BytesIO(content)).to_pylist()
    return tuple(
        Figure(
            FigureIdentity(row["scene"], row["engine"], row["setting"], row["quantity"], FigureKind(row["kind"]),
                           FigureUnit(row["unit"]), row["anchor"]),
            row["value"], row["word"], row["low"], row["high"], row["tolerance"], row["trajectory"],
            members(row["depends"]), row["reason"],
        )
        for row in rows
    )  # fmt: skip


def members(text: str) -> tuple[str, ...]:
    """Names of parts from their text."""
    return tuple(text.split(MEMBERS)) if text else ()


@dataclass(frozen=True)
class FigureTable:
    """Figures of some nights; columns (n,), sorted by series, then by night."""

    nights: tuple[NightSummary, ...]
    identities: tuple[FigureIdentity, ...]
    series: NDArray[np.int32]
    """Places in `identities`"""
    night: NDArray[np.int32]
    """Places in `nights`"""
    numbers: dict[str, NDArray[np.float64]]
    """NaN where a figure has none"""
    words: dict[str, NDArray[np.int32]]
    texts: dict[str, list[str]]
    """Texts of the codes in `words`"""

    def rows(
        self, known: Collection[NightSummary], kinds: Collection[FigureKind] = (), series: Collection[int] | None = None
    ) -> Places:
        """Rows of some nights, and of some kinds or series."""
        names = {night.name for night in known}
        chosen = np.array([night.name in names for night in self.nights], bool)[self.night]
        if kinds:
            chosen &= np.array([identity.kind in kinds for identity in self.identities], bool)[self.series]
        if series is not None:
            chosen &= np.isin(self.series, np.array(sorted(series), np.int32))
        return np.flatnonzero(chosen)

    def series_at(self, rows: Places) -> tuple[FigureSeries, ...]:
        """Series of the figures in some rows. Most figures are the same on many nights, and are made once."""
        made: dict[tuple[Any, ...], Figure] = {}
        numbers = [[None if x != x else x for x in self.numbers[name][rows].tolist()] for name in NUMBERS]  # noqa: PLR0124  # NaN
        codes = [self.words[name][rows].tolist() for name in WORDS]
        depends = [members(text) for text in self.texts["depends"]]
        found: dict[int, tuple[list[NightSummary], list[Figure]]] = {}
        for number, night, *rest in zip(
            self.series[rows].tolist(), self.night[rows].tolist(), *numbers, *codes, strict=True
        ):
            key = (number, *rest)
            if key not in made:
                value, low, high, tolerance, word, trajectory, reason, needs = rest
                made[key] = Figure(
                    self.identities[number], value, self.texts["word"][word], low, high, tolerance,
                    self.texts["trajectory"][trajectory], depends[needs], self.texts["reason"][reason],
                )  # fmt: skip
            nights, figures = found.setdefault(number, ([], []))
            nights.append(self.nights[night])
            figures.append(made[key])
        return tuple(FigureSeries(self.identities[k], tuple(n), tuple(f)) for k, (n, f) in found.items())

    def named(self, pattern: str) -> tuple[FigureSeries, ...]:
        """Series of the figures whose name is `pattern`, or fits it (``*`` and ``?`` stand for any text).

        Raises
        ------
        UnknownFigureError
            If no figure fits; the message gives the nearest name.
        """
        names = [identity.name for identity in self.identities]
        fitting = [k for k, name in enumerate(names) if name == pattern or fnmatch.fnmatchcase(name, pattern)]
        if not fitting:
            there = f"{nearest(pattern, names)}; {len(names)} figures are there" if names else "; there are none"
            raise UnknownFigureError(f"{pattern[:80]}: no such figure{there}")
        return self.series_at(self.rows(self.nights, series=fitting))

    def levels(
        self, known: Sequence[NightSummary], kinds: Collection[FigureKind], dense: int = DENSE_NIGHTS
    ) -> tuple[FigureSeries, ...]:
        """Series over some nights, before the `dense` last ones without figures that equal both neighbours.

        A figure that stays the same for a thousand nights tells no more than its first and its last one. The rules of
        levels need the last night of each level and the first of the next; missing figures count by their nights, and
        of a trajectory whose bits ever differed all nights count.
        """
        rows = self.rows(known, kinds)
        if not len(rows):
            return ()
        series = self.series[rows]
        begins = np.append(True, series[1:] != series[:-1])
        differs = begins.copy()
        for name in JUDGED:
            column = (self.numbers | self.words)[name][rows]
            same = column[1:] == column[:-1]
            if name in NUMBERS:
                same |= np.isnan(column[1:]) & np.isnan(column[:-1])
            differs[1:] |= ~same
        chosen = differs | self.missing(rows)
        chosen[:-1] |= chosen[1:]  # the last night of the level before
        chosen[-1] = True
        bits = np.array([identity.kind is FigureKind.BITS for identity in self.identities], bool)
        moved = np.zeros(len(self.identities), bool)
        moved[series[differs & ~begins]] = True
        chosen |= (bits & moved)[series]
        recent = {night.name for night in known[-dense:]}
        chosen |= np.array([night.name in recent for night in self.nights], bool)[self.night[rows]]
        return self.series_at(rows[chosen])

    def missing(self, rows: Places) -> NDArray[np.bool_]:
        """Whether the figures in some rows have no result."""
        empty = np.array([not text for text in self.texts["word"]], bool)
        found: NDArray[np.bool_] = np.isnan(self.numbers["value"][rows]) & empty[self.words["word"][rows]]
        return found

    def gone(
        self, known: Collection[NightSummary], recent: Collection[NightSummary], kinds: Collection[FigureKind]
    ) -> tuple[FigureSeries, ...]:
        """Last figures of the series that the `recent` ones of some nights lack."""
        rows = self.rows(known, kinds)
        there = np.zeros(len(self.identities), bool)
        there[self.series[self.rows(recent, kinds)]] = True
        last = np.append(self.series[rows][1:] != self.series[rows][:-1], True) if len(rows) else np.zeros(0, bool)
        return self.series_at(rows[last & ~there[self.series[rows]]])

    def positive(self, drawn: Collection[NightSummary], kinds: Collection[FigureKind]) -> tuple[ValueSeries, ...]:
        """Positive values of the figures of some kinds over some nights, for curves."""
        rows = self.rows(drawn, kinds)
        rows = rows[self.numbers["value"][rows] > 0.0]
        names = [night.name for night in self.nights]
        found = []
        ends = np.flatnonzero(np.diff(self.series[rows], prepend=-1, append=-1))
        for first, last in itertools.pairwise(ends.tolist()):
            own = rows[first:last]
            at = tuple(names[k] for k in self.night[own].tolist())
            found.append(
                ValueSeries(self.identities[self.series[own[0]]], at, tuple(self.numbers["value"][own].tolist()))
            )
        return tuple(found)


def read_table(nights: Sequence[NightSummary], read: Callable[[NightSummary], bytes], url: str) -> FigureTable:
    """Figures of all nights.

    Parameters
    ----------
    nights : sequence of NightSummary
        In their order.
    read : callable
        Gives the file of a night's figures.
    url : str
        Address of the history, which names its cache.
    """
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    months = [list(own) for _, own in itertools.groupby(nights, key=lambda night: night.name[:MONTH])]
    blocks = [cached_block(own, read, url) if own is not months[-1] else block_of(own, read) for own in months]

    def taken(name: str) -> pa.ChunkedArray:
        """Column of all blocks; columns are read one after the other, as all together would be held twice."""
        texts = [] if name in NUMBERS else [name]
        tables = (pq.read_table(b, columns=[name], read_dictionary=texts) if isinstance(b, Path) else b for b in blocks)
        return pa.chunked_array([chunk for table in tables for chunk in table[name].chunks])

    if not blocks:
        return FigureTable((), (), *(np.zeros(0, np.int32),) * 2, dict.fromkeys(NUMBERS, np.zeros(0)),
                           dict.fromkeys(WORDS, np.zeros(0, np.int32)), {name: [] for name in WORDS})  # fmt: skip
    series, keys = coded(taken("series"))
    at, names = coded(taken("night"))
    place = {night.name: k for k, night in enumerate(nights)}
    night = np.array([place[name] for name in names], np.int32)[at]
    order = np.argsort(series.astype(np.int64) * len(nights) + night)
    words, texts = {}, {}
    for name in WORDS:
        codes, texts[name] = coded(taken(name))
        words[name] = codes[order]
    numbers = {name: np.asarray(taken(name).to_numpy(), np.float64)[order] for name in NUMBERS}
    identities = tuple(map(identity_of, keys))
    return FigureTable(tuple(nights), identities, series[order], night[order], numbers, words, texts)


def coded(column: pa.ChunkedArray) -> tuple[NDArray[np.int32], list[str]]:
    """Codes (n,) of a column of texts, and the texts."""
    one = column.unify_dictionaries()
    codes = np.concatenate([chunk.indices.to_numpy() for chunk in one.chunks])
    return codes.astype(np.int32, copy=False), one.chunk(0).dictionary.to_pylist()


def identity_of(key: str) -> FigureIdentity:
    """Identity of a series' key."""
    scene, engine, setting, quantity, kind, unit, anchor = key.split(BETWEEN)
    return FigureIdentity(scene, engine, setting, quantity, FigureKind(kind), FigureUnit(unit), anchor)


def block_of(nights: Sequence[NightSummary], read: Callable[[NightSummary], bytes]) -> pa.Table:
    """Figures of some nights, with the columns ``series`` and ``night`` for their identity."""
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.compute as pc  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    found = []
    for night in nights:
        own = pq.read_table(io.BytesIO(read(night)))
        series = pc.binary_join_element_wise(*(own[name] for name in IDENTITY), BETWEEN)
        columns = {
            "series": series.combine_chunks().dictionary_encode(),
            "night": pa.repeat(pa.scalar(night.name), len(own)).dictionary_encode(),
        }
        columns |= {name: own[name] for name in NUMBERS}
        columns |= {name: own[name].combine_chunks().dictionary_encode() for name in WORDS}
        found.append(pa.table(columns))
    return pa.concat_tables(found).unify_dictionaries()


def cached_block(nights: Sequence[NightSummary], read: Callable[[NightSummary], bytes], url: str) -> Path | pa.Table:
    """File of the cache with the figures of the nights of a month; the figures themselves without a cache."""
    import pyarrow.parquet as pq  # noqa: PLC0415

    state = hashlib.sha256(repr([(night.name, night.digest) for night in nights]).encode()).hexdigest()[:16]
    folder, month = cache_of(url), nights[0].name[:MONTH]
    path = folder / f"{month}-{state}.parquet"
    with contextlib.suppress(Exception):  # one that is not there, or damaged, is made again
        if pq.read_metadata(path).num_rows == sum(night.figures for night in nights):
            return path
    made = block_of(nights, read)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob(f"{month}-*.parquet"):
            old.unlink()
        part = path.with_suffix(f".{os.getpid()}.part")
        pq.write_table(made, part, compression="zstd")
        part.replace(path)
    except OSError:  # without a cache it only takes longer
        return made
    return path


def cache_of(url: str) -> Path:
    """Folder of a history's cache."""
    from platformdirs import user_cache_path  # noqa: PLC0415

    return user_cache_path("barchain") / "nights" / hashlib.sha256(url.encode()).hexdigest()[:16]
