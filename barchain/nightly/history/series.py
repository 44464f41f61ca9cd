"""Figures over the nights, and the whole history as a Parquet file."""

from __future__ import annotations

import fnmatch
import itertools
import operator
from collections import defaultdict
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from barchain.nightly.history.faults import UnknownFigureError
from barchain.nightly.history.model.series_model import FigureSeries, ValueSeries
from barchain.nightly.history.storage.connection import told
from barchain.nightly.history.storage.rows import read_figures
from barchain.nightly.history.storage.tables import environments, figures, nights, series, texts
from barchain.nightly.history.storage.vocabulary import identity_of
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from sqlalchemy import ColumnElement, Connection, Select

    from barchain.nightly.history.model.figures import Figure, FigureIdentity, FigureKind
    from barchain.nightly.history.model.series_model import NightSummary
    from barchain.nightly.history.store import NightStore

BATCH = 50_000
"""Rows of the Parquet file that are held at once"""
FEW = 2000
"""Series that are looked up one by one"""


def figure_series(store: NightStore, pattern: str) -> tuple[FigureSeries, ...]:
    """Series of the figures whose name is `pattern`, or fits it (``*`` and ``?`` stand for any text).

    Raises
    ------
    UnknownFigureError
        If no figure fits; the message gives the nearest name.
    """
    with told(store.given), store.engine.connect() as connection:
        names = {row.id: identity_of(row).name for row in connection.execute(sa.select(series))}
    fitting = [number for number, name in names.items() if name == pattern or fnmatch.fnmatchcase(name, pattern)]
    if not fitting:
        there = f"{nearest(pattern, names.values())}; {len(names)} figures are there" if names else "; there are none"
        raise UnknownFigureError(f"{pattern[:80]}: no such figure{there}")
    return load(store, store.nights(), numbers=fitting)


def all_series(
    store: NightStore, last: int | None = None, kinds: Collection[FigureKind] = ()
) -> tuple[FigureSeries, ...]:
    """Series of all figures, or those of some kinds, over all nights or the `last` ones."""
    return load(store, store.nights(last), kinds=kinds)


def load(
    store: NightStore,
    known: Sequence[NightSummary],
    *,
    numbers: Sequence[int] | None = None,
    kinds: Collection[FigureKind] = (),
) -> tuple[FigureSeries, ...]:
    """Series over the given nights."""
    order = {night.number: k for k, night in enumerate(known)}
    chosen: ColumnElement[bool] = figures.c.night_id.in_(order)
    if numbers is not None:
        chosen &= figures.c.series_id.in_(numbers)
    with told(store.given), store.engine.connect() as connection:
        if kinds:
            own = of_kinds(connection, kinds)
            few = len(own) <= FEW  # figures lie in the order of series: a few series are found at once
            chosen &= figures.c.series_id.in_(own) if few else series.c.kind.in_(names_of(kinds))
        return ordered(read_figures(connection, chosen), known, order)


def of_kinds(connection: Connection, kinds: Collection[FigureKind]) -> set[int]:
    """Numbers of the series of some kinds."""
    return set(connection.execute(sa.select(series.c.id).where(series.c.kind.in_(names_of(kinds)))).scalars())


def names_of(kinds: Collection[FigureKind]) -> list[str]:
    """Names of kinds, as they are stored."""
    return [str(kind) for kind in kinds]


def ordered(
    found: Iterable[tuple[int, Figure]], known: Sequence[NightSummary], place: Mapping[int, int]
) -> tuple[FigureSeries, ...]:
    """Series of figures, each given with the number of its night; `place` is that of a night in `known`."""
    own: dict[FigureIdentity, list[tuple[int, Figure]]] = defaultdict(list)
    for number, figure in found:
        own[figure.identity].append((place[number], figure))
    pairs = ((identity, sorted(every, key=operator.itemgetter(0))) for identity, every in own.items())
    return tuple(
        FigureSeries(identity, tuple(known[k] for k, _ in every), tuple(figure for _, figure in every))
        for identity, every in pairs
    )


def positive_values(
    store: NightStore, drawn: Collection[NightSummary], kinds: Collection[FigureKind]
) -> tuple[ValueSeries, ...]:
    """Positive values of the figures of some kinds over some nights, in the order of the nights' numbers.

    Only what a curve needs is read: a history of a thousand nights has millions of figures.
    """
    numbers = [night.number for night in drawn]
    query = (
        sa.select(figures.c.series_id, figures.c.night_id, figures.c.value)
        .join(series)
        .where(figures.c.night_id.in_(numbers), figures.c.value > 0.0, series.c.kind.in_(names_of(kinds)))
        .order_by(figures.c.series_id, figures.c.night_id)
    )
    with told(store.given), store.engine.connect() as connection:
        identities = {row.id: identity_of(row) for row in connection.execute(sa.select(series))}
        rows = connection.execute(query).all()
    found = []
    for number, own in itertools.groupby(rows, key=operator.itemgetter(0)):
        _, at, values = zip(*own, strict=True)
        found.append(ValueSeries(identities[number], at, values))
    return tuple(found)


def whole() -> Select[Any]:
    """Query of every figure of every night, as columns of the Parquet file."""
    word, trajectory, reason, depends = (texts.alias(n) for n in ("word", "trajectory", "reason", "depends"))
    return (
        sa.select(
            nights.c.name.label("night"), nights.c.started, nights.c.plan, nights.c.barchain, nights.c.source_commit,
            nights.c.complete, nights.c.void, environments.c.machine_class, environments.c.cpu, environments.c.python,
            series.c.scene, series.c.engine, series.c.setting, series.c.quantity, series.c.kind, series.c.unit,
            series.c.anchor, figures.c.value, word.c.text.label("word"), figures.c.low, figures.c.high,
            figures.c.tolerance, trajectory.c.text.label("trajectory"), depends.c.text.label("depends"),
            reason.c.text.label("reason"),
        )
        .select_from(figures)
        .join(nights, figures.c.night_id == nights.c.id)
        .join(environments, nights.c.environment_id == environments.c.id)
        .join(series, figures.c.series_id == series.c.id)
        .join(depends, figures.c.depends_id == depends.c.id)
        .outerjoin(word, figures.c.word_id == word.c.id)
        .outerjoin(trajectory, figures.c.trajectory_id == trajectory.c.id)
        .outerjoin(reason, figures.c.reason_id == reason.c.id)
        .order_by(nights.c.started, nights.c.id, figures.c.series_id)
    )  # fmt: skip


def export_parquet(store: NightStore, path: Path) -> int:
    """Write all figures of all nights to a Parquet file, and return their number.

    Raises
    ------
    OSError
        If the file can't be written; an earlier file then stays.
    """
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    from reports.tables.writing import replaced  # noqa: PLC0415

    schema = parquet_schema()
    written = 0
    with replaced(path) as file, pq.ParquetWriter(file, schema) as writer:
        for rows in batches(store):
            columns = {name: [row[k] for row in rows] for k, name in enumerate(schema.names)}
            writer.write_table(pa.table(columns, schema=schema))
            written += len(rows)
    return written


def batches(store: NightStore) -> Iterator[list[Any]]:
    """Rows of :func:`whole`, some at a time."""
    with told(store.given), store.engine.connect().execution_options(yield_per=BATCH) as connection:
        for rows in connection.execute(whole()).partitions():
            yield list(rows)


def parquet_schema() -> Any:
    """Names and types of the columns."""
    import pyarrow as pa  # noqa: PLC0415

    special = {"started": pa.timestamp("us", tz="UTC"), "complete": pa.bool_()}
    special |= dict.fromkeys(("value", "low", "high", "tolerance"), pa.float64())
    return pa.schema([(c.name, special.get(c.name, pa.string())) for c in whole().selected_columns])
