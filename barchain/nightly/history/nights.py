"""History of nights: a folder with a folder for each night. A night is there once its record, written last, is there.

``<night>/figures.parquet``
    a row for each figure (:mod:`barchain.nightly.figures.table`);
``<night>/record.json``
    start, plan, environment and parts of the night, what it did of its plan, the digest of its figures, and its own;
``<night>/told.json``
    what the night told (:mod:`barchain.nightly.history.news`);
``accepted.toml``
    changes that somebody accepted (:mod:`barchain.nightly.history.acceptances`).

Nights are copied, merged and removed as folders; several machines may write into one history.
"""

from __future__ import annotations

import datetime
import hashlib
import io
import json
import re
from collections import defaultdict
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.figure import Night, NightSummary, content_digest
from barchain.nightly.figures.storage import Place
from barchain.nightly.figures.table import (
    COLUMNS,
    FIGURES,
    NUMBERS,
    figures_content,
    identity_of,
    read_figures,
    read_numbers,
)
from reports.results.reading import form_of
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence
    from pathlib import Path

    from barchain.nightly.figures.figure import Figure, FigureIdentity
    from barchain.nightly.figures.table import NumberTable
    from reports.results.nights.document import NightRun


RECORD = "record.json"
RECORD_DIGEST = "record_digest"
"""Key of a record: digest of its other entries, without ``void``, which somebody may give a night later"""
FORMAT = 1
NIGHT_NAME = re.compile(r"\d{4}-\d\d-\d\dT\d\d-\d\d-\d\d-\w+")
MISSING = "it has no {}: it is being written, or was copied in part"
UNREADABLE = f"it has a {RECORD} that is damaged, or being written; copy the night again, or remove its folder"
DAMAGED = f"it is damaged, as its {FIGURES} is not that of its record; copy the night again, or remove its folder"
AT_ONCE = 50
"""Nights whose files are held together"""
LATEST = "latest"
"""Name that stands for the last night"""


class NightStore:
    """Nights in a folder."""

    def __init__(self, place: Place) -> None:
        """Take a folder that is there; :func:`open_store` makes it."""
        self.place = place
        self.known: dict[str, tuple[bytes, NightSummary]] = {}
        self.broken: set[str] = set()
        """Names of nights whose figures were read and are damaged"""
        self.loaded: tuple[list[tuple[str, str]], NumberTable] | None = None

    def __str__(self) -> str:
        """Address without its password."""
        return self.place.url

    def add(self, night: Night, run: NightRun | None = None) -> bool:
        """Add a night: its figures, then its record.

        Returns
        -------
        bool
            Whether it was added: False of a night that is there already and complete. An incomplete one is replaced.

        Raises
        ------
        HistoryError
            If it can't be written; the night is not there then, or as it was.
        """
        name, content, added = night.name, figures_content(night), now()
        there = self.place.read(f"{name}/{RECORD}")
        if there is not None:
            earlier = self.summary(name)
            if earlier.complete or earlier.digest == digest_of(content):
                return False
            added = earlier.added
            self.place.remove(f"{name}/told.json")  # the whole night tells its changes anew
        self.place.write(f"{name}/{FIGURES}", content)
        self.broken.discard(name)
        stored = night.summary(run=run, digest=digest_of(content), size_B=len(content), added=added)
        self.place.write(f"{name}/{RECORD}", record_of(stored))
        return True

    def nights(self) -> tuple[NightSummary, ...]:
        """Nights in the order of their starts; torn ones and copies do not count (:meth:`left_out`)."""
        whole = self.summaries()
        kept = whole.keys() - copies(whole.values())
        return tuple(sorted((whole[name] for name in kept), key=lambda night: (night.started, night.name)))

    def summaries(self) -> dict[str, NightSummary]:
        """Whole nights by the name of their folder, copies among them."""
        sizes = self.place.sizes(f"*/{FIGURES}")
        records = self.place.read_all([name.replace(FIGURES, RECORD) for name in sizes])
        found = {}
        for file, content in records.items():
            name = file.removesuffix(f"/{RECORD}")
            if name not in self.known or self.known[name][0] != content:
                summary = summary_of(name, content)
                if summary is None:
                    continue
                self.known[name] = content, summary
            if name not in self.broken and self.known[name][1].size_B == sizes[f"{name}/{FIGURES}"]:
                found[name] = self.known[name][1]
        return found

    def left_out(self) -> dict[str, str]:
        """Folders of nights that count as not there, each with the reason."""
        parts = {*self.place.sizes(f"*/{FIGURES}"), *self.place.sizes(f"*/{RECORD}")}
        whole = self.summaries()
        names = {name.partition("/")[0] for name in parts} - whole.keys()

        def why(name: str) -> str:
            lacking = [file for file in (FIGURES, RECORD) if f"{name}/{file}" not in parts]
            if lacking:
                return MISSING.format(lacking[0])
            file = f"{name}/{RECORD}"
            record = self.place.read_all([file]).get(file, b"")  # another process may remove it now
            return UNREADABLE if summary_of(name, record) is None else DAMAGED

        torn = {name: why(name) for name in names if NIGHT_NAME.fullmatch(name)}
        more = {name: f"it is a copy of {kept}" for name, kept in copies(whole.values()).items()}
        return dict(sorted((torn | more).items()))

    def check(self) -> None:
        """Read the figures of all nights: a damaged one is left out from then on, and costs itself alone."""
        for _ in self.contents(self.nights()):
            pass

    def summary(self, name: str) -> NightSummary:
        """Night by its name, the beginning of it, or ``latest``.

        Raises
        ------
        HistoryError
            If there is none, or several; the message gives the nearest name.
        """
        every = self.nights()
        if name == LATEST:
            if not every:
                raise HistoryError(f"{name}: the history holds no nights")
            return latest_first(every)[0]
        known = {night.name: night for night in every}
        fitting = [name] if name in known else [each for each in known if name and each.startswith(name)]
        if len(fitting) == 1:
            return known[fitting[0]]
        if fitting:
            raise HistoryError(f"{name[:60]}: {len(fitting)} nights begin so, e.g. {fitting[0]} and {fitting[1]}")
        for folder, reason in self.left_out().items():
            if name and folder.startswith(name):
                raise HistoryError(f"{folder}: left out of the history: {reason}")
        if not known:
            raise HistoryError(f"{name[:60]}: no such night; the history holds no nights")
        raise HistoryError(f"{name[:60]}: no such night{nearest(name, known)}; `barchain history list` shows all")

    def night(self, name: str) -> Night:
        """Whole night; errors as :meth:`summary` and :meth:`figures`."""
        known = self.summary(name)
        figures = tuple(self.figures(known))
        return Night(**known.facts, figures=figures, label=known.name.rpartition("-")[2])

    def figures(self, night: NightSummary) -> list[Figure]:
        """Figures of a night.

        Raises
        ------
        HistoryError
            If they are not those that the record describes.
        """
        for _, content in self.contents([night]):
            return read_figures(content)
        said = f"{night.name}/{FIGURES} is damaged; copy the night again, or remove its folder"
        raise HistoryError(f"{self}: {said}")

    def contents(self, nights: Sequence[NightSummary]) -> Iterator[tuple[NightSummary, bytes]]:
        """Nights with the files of their figures; a damaged one is left out from then on."""
        for first in range(0, len(nights), AT_ONCE):
            some = nights[first : first + AT_ONCE]
            found = self.place.read_all([f"{night.name}/{FIGURES}" for night in some])
            for night in some:
                content = found.get(f"{night.name}/{FIGURES}", b"")
                if digest_of(content) == night.digest:
                    yield night, content
                else:
                    self.broken.add(night.name)

    def numbers(self) -> NumberTable:
        """Numbers of all nights, of the kinds that are looked at over many."""
        nights = self.nights()
        key = [(night.name, night.digest) for night in nights]
        if self.loaded is None or self.loaded[0] != key:
            self.loaded = key, read_numbers(self.contents(nights))
        return self.loaded[1]

    def series(self, *patterns: str) -> dict[FigureIdentity, list[tuple[NightSummary, Figure]]]:
        """Figures whose name is one of `patterns`, or fits it (``*`` and ``?`` stand for any text), with their nights.

        Raises
        ------
        HistoryError
            If no figure fits; the message gives the nearest name.
        """
        fitting: dict[tuple[str, ...], bool] = {}
        found: dict[FigureIdentity, list[tuple[NightSummary, Figure]]] = defaultdict(list)

        def fits(key: tuple[str, ...]) -> bool:
            if key not in fitting:
                name = identity_of(*key).name
                fitting[key] = any(name == pattern or fnmatchcase(name, pattern) for pattern in patterns)
            return fitting[key]

        for night, content in self.contents(self.nights()):
            for figure in read_figures(content, fits):
                found[figure.identity].append((night, figure))
        if not found:
            names = [identity_of(*key).name for key in fitting]
            there = f"{nearest(patterns[0], names)}; {len(names)} figures are there" if names else "; there are none"
            raise HistoryError(f"{patterns[0][:80]}: no such figure{there}")
        return found

    def prune(
        self, keep: int | None = None, before: datetime.datetime | None = None, spared: Collection[str] = ()
    ) -> tuple[str, ...]:
        """Remove nights with their folders.

        Parameters
        ----------
        keep : int, optional
            Number of the latest nights that stay.
        before : datetime, optional
            Nights that started before are removed.
        spared : collection of str
            Names of nights that stay.

        Returns
        -------
        tuple of str
            Names of the removed nights: those that both rules remove, where both are given.
        """
        kept = {night.name for night in latest_first(self.nights())[: 0 if keep is None else keep]} | set(spared)
        gone = [n.name for n in self.nights() if n.name not in kept and (before is None or n.started < before)]
        for name in gone:
            self.place.remove(f"{name}/{RECORD}")  # first, so that no half of a night counts
            self.place.remove(name)
        return tuple(gone)


def open_store(given: str, *, create: bool = False) -> NightStore:
    """Open a history.

    Parameters
    ----------
    given : str
        A folder, or an address that fsspec knows.
    create : bool
        Take a folder that is not there yet.

    Raises
    ------
    HistoryError
        If it can't be opened; the message is one line.
    """
    place = Place(given)
    if not create and not place.exists():
        raise HistoryError(
            f"{place.url}: no history there; `barchain nightly` and `barchain history add DIR` begin one"
        )
    return NightStore(place)


def copies(nights: Collection[NightSummary]) -> dict[str, str]:
    """Names of nights that stand in the history once more, each with the name that counts."""
    first: dict[tuple[datetime.datetime, str], str] = {}
    every = sorted(nights, key=lambda night: (not night.complete, night.name))
    counts = {night.name: first.setdefault((night.started, night.added), night.name) for night in every}
    return {name: kept for name, kept in counts.items() if name != kept}


def now() -> str:
    """Present instant in UTC, as text that is ordered as instants are."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="microseconds")


def digest_of(content: bytes) -> str:
    """Digest of a file's contents."""
    return hashlib.sha256(content).hexdigest()


def record_of(summary: NightSummary) -> bytes:
    """Record of a night, as JSON, with the digest of all that it holds."""
    content = form_of(NightSummary).dump_python(summary, mode="json")
    content |= {"format": FORMAT, "machine_class": summary.environment.machine_class}
    return json.dumps(
        {RECORD_DIGEST: digest_of_record(content)} | content, indent=1, ensure_ascii=False, allow_nan=False
    ).encode()


def digest_of_record(content: Mapping[str, object]) -> str:
    """Digest of the entries of a record."""
    return content_digest({name: value for name, value in content.items() if name != "void"})


def summary_of(name: str, content: bytes) -> NightSummary | None:
    """Night without its figures, of its record; None of something else, or of a damaged one.

    Records of 0.7 have no digest of their own.

    Raises
    ------
    HistoryError
        If a later barchain wrote it.
    """
    try:
        found = json.loads(content)
        if found["format"] > FORMAT:
            raise HistoryError(f"{name}: a later barchain wrote this night; update barchain")
        signed = found.pop(RECORD_DIGEST, None)
        if signed is not None and signed != digest_of_record(found):
            return None
        summary = form_of(NightSummary).validate_python(found | {"name": name})
    except HistoryError:
        raise
    except (ValueError, TypeError, KeyError, RecursionError):
        return None
    return summary if summary.started.tzinfo else None


def latest_first(nights: Collection[NightSummary]) -> list[NightSummary]:
    """Nights from the latest one on; those without figures, or with a start later than now, come at the end."""
    here = datetime.datetime.now(datetime.UTC)
    return sorted(nights, key=lambda n: (n.figures > 0 and n.started <= here, n.started, n.name), reverse=True)


def last_run(store: NightStore, plan: str) -> NightRun | None:
    """Run of the last turn of a plan; None before the first. A clock that was wrong once does not stop the turns."""
    runs = [night.run for night in store.nights() if night.run is not None and night.run.plan == plan]
    return max(runs, key=lambda run: run.turn, default=None)


OF_NIGHT = ("night", "started", "plan", "barchain", "commit", "complete", "void", "machine_class", "cpu", "python")


def export_parquet(store: NightStore, path: Path) -> int:
    """Write all figures of all nights to a Parquet file, a row each, and return their number.

    Raises
    ------
    OSError
        If the file can't be written; an earlier file then stays.
    """
    import pandas as pd  # noqa: PLC0415
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    from reports.results.writing import replaced  # noqa: PLC0415

    types = {name: pa.float64() if name in NUMBERS else pa.string() for name in (*OF_NIGHT, *COLUMNS)}
    types |= {"started": pa.timestamp("us", tz="UTC"), "complete": pa.bool_()}
    schema, written = pa.schema(types), 0
    with replaced(path) as file, pq.ParquetWriter(file, schema, compression="zstd") as writer:
        for night, content in store.contents(store.nights()):
            machine = night.environment
            rows = pd.read_parquet(io.BytesIO(content)).assign(
                night=night.name, started=night.started, plan=night.plan, barchain=night.barchain, commit=night.commit,
                complete=night.complete, void=night.void, machine_class=machine.machine_class, cpu=machine.cpu,
                python=machine.python,
            )  # fmt: skip
            writer.write_table(pa.Table.from_pandas(rows, schema, preserve_index=False))
            written += len(rows)
    return written
