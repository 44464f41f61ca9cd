"""The whole history as one Parquet file."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from barchain.nightly.history.table import COLUMNS, NUMBERS

if TYPE_CHECKING:
    from pathlib import Path

    import pyarrow as pa

    from barchain.nightly.history.model.series_model import NightSummary
    from barchain.nightly.history.store import NightStore

OF_NIGHT = ("night", "started", "plan", "barchain", "commit", "complete", "void", "machine_class", "cpu", "python")


def export_parquet(store: NightStore, path: Path) -> int:
    """Write all figures of all nights to a Parquet file, a row each, and return their number.

    Raises
    ------
    OSError
        If the file can't be written; an earlier file then stays.
    """
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    from reports.tables.writing import replaced  # noqa: PLC0415

    special = {"started": pa.timestamp("us", tz="UTC"), "complete": pa.bool_()}
    special |= dict.fromkeys(NUMBERS, pa.float64())
    schema = pa.schema([(name, special.get(name, pa.string())) for name in (*OF_NIGHT, *COLUMNS)])
    written = 0
    with replaced(path) as file, pq.ParquetWriter(file, schema, compression="zstd") as writer:
        for night in store.nights():
            rows = pq.read_table(io.BytesIO(store.figures_of(night)))
            writer.write_table(with_night(rows, night, schema))
            written += len(rows)
    return written


def with_night(rows: pa.Table, night: NightSummary, schema: pa.Schema) -> pa.Table:
    """Figures with the columns of their night."""
    import pyarrow as pa  # noqa: PLC0415

    own = {
        "night": night.name, "started": night.started, "plan": night.plan, "barchain": night.barchain,
        "commit": night.commit, "complete": night.complete, "void": night.void,
        "machine_class": night.environment.machine_class, "cpu": night.environment.cpu,
        "python": night.environment.python,
    }  # fmt: skip
    columns = {name: pa.repeat(pa.scalar(own[name], schema.field(name).type), len(rows)) for name in OF_NIGHT}
    return pa.table(columns | {name: rows[name] for name in COLUMNS}, schema=schema)
