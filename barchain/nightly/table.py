"""Figures of many nights as one table, series × night, and the file of one night's figures.

A history of a thousand nights has millions of figures, most of them the same on many nights. Each distinct result of a
series is kept once, and a matrix says which night has which. ``cache.parquet`` in the history's folder holds the table
of the nights that were there when it was written; without it, it only takes longer.
"""

from __future__ import annotations

import contextlib
import fnmatch
import io
import itertools
import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.nightly.faults import HistoryError
from barchain.nightly.figures import (
    Figure,
    FigureIdentity,
    FigureKind,
    FigureSeries,
    FigureUnit,
    NightSummary,
)
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    import pyarrow as pa
    from numpy.typing import NDArray

    from barchain.nightly.figures import Night
    from barchain.nightly.place import Place

    Codes = NDArray[np.int32]
    Mask = NDArray[np.bool_]


FIGURES = "figures.parquet"
CACHE = "cache.parquet"
CACHE_FORMAT = b"nights, format 1"
"""Entry of the cache's schema that names its nights with the digests of their figures"""
IDENTITY = ("scene", "engine", "setting", "quantity", "kind", "unit", "anchor")
NUMBERS = ("value", "low", "high", "tolerance")
WORDS = ("word", "trajectory", "reason", "depends")
COLUMNS = (*IDENTITY, *NUMBERS, *WORDS, "versions")
"""Columns of a night's file; ``versions`` has those of the distributions behind a figure's engines, for readers"""
TYPES = dict.fromkeys(NUMBERS, np.float64) | dict.fromkeys(WORDS, np.int32)
MOST_READ = 16
"""Nights beside the cache: with more it is written anew"""
AT_ONCE = 50
"""Nights whose files are held together"""
ENGINE, PROGRAM = "engine:", "program:"
BETWEEN, MEMBERS = "\t", "\n"
"""Between the parts of a series' key, and the names of parts; no text of a figure holds them"""


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


def versions_of(figure: Figure, night: Night) -> str:
    """Versions of the distributions and programs behind a figure's engines, e.g. ``mujoco 3.3.0``."""
    parts = (night.part_named[name] for name in figure.depends if name.startswith((ENGINE, PROGRAM)))
    known = (part for part in parts if part.version or part.name.startswith(ENGINE))
    return ", ".join(f"{part.name.partition(':')[2].partition(' (')[0]} {part.version}" for part in known)


@dataclass(frozen=True)
class FigureTable:
    """Figures of some nights."""

    nights: tuple[NightSummary, ...]
    identities: tuple[FigureIdentity, ...]
    """Of the series"""
    cells: Codes
    """Places (series, nights) in the columns of `results`, -1 without a figure; equal places are equal results"""
    results: Mapping[str, NDArray[Any]]
    """Columns of the distinct results of all series: numbers, NaN where there is none, and places in `texts`"""
    texts: Sequence[str]
    made: dict[int, Figure] = field(default_factory=dict)
    """Figures that were looked at"""

    def where(self, known: Collection[NightSummary], kinds: Collection[FigureKind] = ()) -> Mask:
        """Whether there is a figure (series, nights), of some nights and kinds only."""
        found: Mask = (self.cells >= 0) & self.among(known)
        if kinds:
            found &= np.array([identity.kind in kinds for identity in self.identities], bool)[:, None]
        return found

    def among(self, known: Collection[NightSummary]) -> Mask:
        """Whether a night (nights,) is one of some."""
        names = {night.name for night in known}
        return np.array([night.name in names for night in self.nights], bool)

    def series_at(self, chosen: Mask) -> tuple[FigureSeries, ...]:
        """Series of the chosen figures."""
        found = []
        for k in np.flatnonzero(chosen.any(axis=1)).tolist():
            at = np.flatnonzero(chosen[k]).tolist()
            figures = tuple(self.figure(k, code) for code in self.cells[k, at].tolist())
            found.append(FigureSeries(self.identities[k], tuple(self.nights[n] for n in at), figures))
        return tuple(found)

    def figure(self, series: int, code: int) -> Figure:
        """Figure of a result of a series."""
        if code not in self.made:
            numbers, words = ([self.results[name][code].item() for name in names] for names in (NUMBERS, WORDS))
            value, low, high, tolerance = (None if x != x else x for x in numbers)  # noqa: PLR0124  # NaN
            word, trajectory, reason, depends = (self.texts[k] for k in words)
            self.made[code] = Figure(
                self.identities[series],
                value,
                word,
                low,
                high,
                tolerance,
                trajectory,
                tuple(depends.split(MEMBERS)) if depends else (),
                reason,
            )
        return self.made[code]

    def named(self, pattern: str) -> tuple[FigureSeries, ...]:
        """Series of the figures whose name is `pattern`, or fits it (``*`` and ``?`` stand for any text).

        Raises
        ------
        HistoryError
            If no figure fits; the message gives the nearest name.
        """
        names = [identity.name for identity in self.identities]
        fitting = np.array([name == pattern or fnmatch.fnmatchcase(name, pattern) for name in names], bool)
        if not fitting.any():
            there = f"{nearest(pattern, names)}; {len(names)} figures are there" if names else "; there are none"
            raise HistoryError(f"{pattern[:80]}: no such figure{there}")
        return self.series_at((self.cells >= 0) & fitting[:, None])

    def of_night(self, name: str) -> list[Figure]:
        """Figures of a night."""
        codes = self.cells[:, next(k for k, night in enumerate(self.nights) if night.name == name)]
        there = np.flatnonzero(codes >= 0)
        return [self.figure(k, code) for k, code in zip(there.tolist(), codes[there].tolist(), strict=True)]


def read_table(
    nights: Sequence[NightSummary], place: Place | None, figures_of: Callable[[Sequence[NightSummary]], list[bytes]]
) -> FigureTable:
    """Figures of all nights of a history: those of the cache, and of the nights that it lacks.

    Parameters
    ----------
    nights : sequence of NightSummary
        In their order.
    place : Place, optional
        Of the history, for its cache; none is used without.
    figures_of : callable
        Gives the files of the figures of some nights.
    """
    building = Building(nights)
    with contextlib.suppress(Exception):  # a cache that is not there, damaged, or of another format is made again
        building.take_cache(place.read(CACHE) or b"" if place else b"")
    lacking = [night for night in nights if night.name not in building.known]
    for first in range(0, len(lacking), AT_ONCE):
        some = lacking[first : first + AT_ONCE]
        for night, content in zip(some, figures_of(some), strict=True):
            building.add(night, content)
    table = building.table()
    if place is not None and len(lacking) > MOST_READ:
        with contextlib.suppress(HistoryError):  # without a cache it only takes longer
            place.write(CACHE, cache_content(table))
    return table


class Building:
    """Table to which the figures of one night after the other are added."""

    def __init__(self, nights: Sequence[NightSummary]) -> None:
        """Begin without figures."""
        self.nights = tuple(nights)
        self.place = {night.name: k for k, night in enumerate(nights)}
        self.known: set[str] = set()
        """Names of the nights whose figures are there"""
        self.keys: dict[str, int] = {}
        self.texts: dict[str, int] = {}
        self.cells = np.full((0, len(nights)), -1, np.int32)
        self.results: dict[str, list[NDArray[Any]]] = {name: [] for name in (*NUMBERS, *WORDS)}
        self.count = 0
        """Number of results"""
        self.last = np.zeros(0, np.int32)
        """Result of each series that was added last, -1 before"""
        self.latest: dict[str, NDArray[Any]] = {name: np.zeros(0, kind) for name, kind in TYPES.items()}
        """Its columns"""

    def take_cache(self, content: bytes) -> None:
        """Take the figures of a cache, of nights that are there and as they were."""
        import pyarrow.parquet as pq  # noqa: PLC0415

        rows = pq.ParquetFile(io.BytesIO(content), page_checksum_verification=True).read()
        cached = json.loads(rows.schema.metadata[CACHE_FORMAT])
        series = numbered(rows["series"], self.keys)
        first, last = (np.from_dlpack(rows[name].combine_chunks()) for name in ("first", "last"))
        begins, ends = series * len(cached) + first, series * len(cached) + last + 1
        lengths = np.diff(np.stack([begins, ends], axis=1).ravel(), prepend=0, append=len(self.keys) * len(cached))
        codes = np.full(len(lengths), -1, np.int32)
        codes[1::2] = np.arange(len(rows), dtype=np.int32)
        cells = np.repeat(codes, lengths).reshape(len(self.keys), len(cached))
        counted = np.count_nonzero(cells >= 0, axis=0)
        own = {(night.name, night.digest, night.figures): k for k, night in enumerate(self.nights)}
        place = [own.get((name, digest, counted[k]), -1) for k, (name, digest) in enumerate(cached)]
        kept = [k for k, there in enumerate(place) if there >= 0]
        self.cells = np.full((len(self.keys), len(self.nights)), -1, np.int32)
        self.cells[:, [place[k] for k in kept]] = cells[:, kept]
        self.known = {cached[k][0] for k in kept}
        columns, self.count = self.columns(rows), len(rows)
        self.results = {name: [column] for name, column in columns.items()}
        self.last = self.cells.max(axis=1, initial=-1)  # places of a series are in the order of its nights
        self.latest = {name: column[self.last] for name, column in columns.items()}

    def add(self, night: NightSummary, content: bytes) -> None:
        """Add the figures of a night's file: of those that are as they were last, the result stands there already."""
        import pyarrow.compute as pc  # noqa: PLC0415
        import pyarrow.parquet as pq  # noqa: PLC0415

        rows = pq.ParquetFile(io.BytesIO(content), read_dictionary=list(WORDS)).read()
        keys = pc.binary_join_element_wise(*(rows[name] for name in IDENTITY), BETWEEN)
        series = numbered(keys.dictionary_encode(), self.keys)
        columns, more = self.columns(rows), len(self.keys) - len(self.cells)
        if more:
            self.cells = np.pad(self.cells, ((0, more), (0, 0)), constant_values=-1)
            self.last = np.pad(self.last, (0, more), constant_values=-1)
            self.latest = {name: np.pad(column, (0, more)) for name, column in self.latest.items()}
        same = self.last[series] >= 0
        for name, column in columns.items():
            latest = self.latest[name][series]
            same &= (column == latest) | ((column != column) & (latest != latest))  # noqa: PLR0124  # NaN
        code = np.where(same, self.last[series], self.count - 1 + np.cumsum(~same, dtype=np.int32))
        for name, column in columns.items():
            self.results[name].append(column[~same])
            self.latest[name][series] = column
        self.last[series] = code
        self.cells[series, self.place[night.name]] = code
        self.count += int(np.count_nonzero(~same))
        self.known.add(night.name)

    def columns(self, rows: pa.Table) -> dict[str, NDArray[Any]]:
        """Columns of results; texts as their numbers.

        Arrays without nulls, as those of the cache, are taken by DLPack: `to_numpy` imports pandas, which takes longer
        than all else here.
        """
        found = {
            name: rows[name].to_numpy() if rows[name].null_count else np.from_dlpack(rows[name].combine_chunks())
            for name in NUMBERS
        }
        return found | {name: numbered(rows[name], self.texts) for name in WORDS}

    def table(self) -> FigureTable:
        """Table of what was added; series that no night has any more are left out."""
        there: Mask = np.any(self.cells >= 0, axis=1)
        identities = []
        for key in itertools.compress(self.keys, there):
            scene, engine, setting, quantity, kind, unit, anchor = key.split(BETWEEN)
            kinds = FigureKind(kind), FigureUnit(unit)
            identities.append(FigureIdentity(scene, engine, setting, quantity, *kinds, anchor))
        results = {name: np.concatenate([np.zeros(0, TYPES[name]), *own]) for name, own in self.results.items()}
        return FigureTable(self.nights, tuple(identities), self.cells[there], results, tuple(self.texts))


def numbered(column: pa.ChunkedArray, known: dict[str, int]) -> Codes:
    """Numbers of the texts of a column; new texts get the next numbers."""
    own = column.combine_chunks()
    numbers = [known.setdefault(text, len(known)) for text in own.dictionary.to_pylist()]
    found: Codes = np.array(numbers, np.int32)[np.from_dlpack(own.indices)]
    return found


def cache_content(table: FigureTable) -> bytes:
    """File of the cache: a row for each level of a series, with the places of its first and its last night."""
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    cells = np.pad(table.cells, ((0, 0), (1, 1)), constant_values=-1)
    own = cells[:, 1:-1]
    series, first = np.nonzero((own >= 0) & (own != cells[:, :-2]))
    last = np.nonzero((own >= 0) & (own != cells[:, 2:]))[1]
    code, keys = own[series, first], pa.array([key_of(identity) for identity in table.identities], pa.string())
    texts = pa.array(table.texts, pa.string())
    columns: dict[str, Any] = {"series": pa.DictionaryArray.from_arrays(series, keys), "first": first, "last": last}
    columns |= {name: table.results[name][code] for name in NUMBERS}
    columns |= {name: pa.DictionaryArray.from_arrays(table.results[name][code], texts) for name in WORDS}
    nights = json.dumps([(night.name, night.digest) for night in table.nights])
    sink = io.BytesIO()
    rows = pa.table(columns).replace_schema_metadata({CACHE_FORMAT: nights})
    pq.write_table(rows, sink, compression="zstd", write_page_checksum=True)
    return sink.getvalue()


def key_of(identity: FigureIdentity) -> str:
    """Key of a series."""
    return BETWEEN.join(str(getattr(identity, name)) for name in IDENTITY)
