"""All figures of a store as one table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from barchain.history.tables import NAME

if TYPE_CHECKING:
    from barchain.history.store import HistoryStore

COLUMNS = ("night", "started", "machine", *NAME, "value", "word", "low", "high", "roundoff", "reason", "parts")


def table_of(store: HistoryStore) -> pd.DataFrame:
    """One row for each figure of each night, columns :data:`COLUMNS`, in order of time."""
    nights = {night.id: night for night in store.nights()}
    rows = []
    for name, figure in store.values():
        night, series = nights[name], figure.series
        own = (
            figure.value,
            figure.word,
            figure.low,
            figure.high,
            figure.roundoff,
            figure.reason,
            ",".join(figure.parts),
        )
        rows.append((name, night.started, night.machine, *(str(getattr(series, column)) for column in NAME), *own))
    return pd.DataFrame(rows, columns=list(COLUMNS))
