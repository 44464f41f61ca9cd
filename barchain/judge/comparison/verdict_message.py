"""Verdicts as messages between processes: text and float64 arrays, read without running code."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.boundary.message import MessageError, message_bytes, plain_text, read_message
from barchain.judge.comparison.verdict import Verdict
from barchain.run.job import Role
from barchain.run.verdict_workers import VerdictCodec
from reports.tables.crossval import METRIC_COLUMNS
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from barchain.judge.comparison.verdict import Row

MOST_REASON = 2000
"""Characters of a text in a row"""


def verdict_bytes(verdict: Verdict) -> bytes:
    """Message with a verdict."""
    columns = None if verdict.series is None else list(verdict.series.columns)
    header = {"rows": verdict.rows, "columns": columns, "further_runs": [str(role) for role in verdict.further_runs]}
    arrays = {} if verdict.series is None else {f"c{k}": verdict.series[name] for k, name in enumerate(columns or [])}
    return message_bytes(header, {name: values.to_numpy() for name, values in arrays.items()})


def verdict_from(content: bytes) -> Verdict:
    """Verdict of a message.

    Raises
    ------
    MessageError, ValueError, TypeError, KeyError
        If a part is missing or of a wrong type.
    """
    header, arrays = read_message(content)
    columns = header["columns"]
    series = None
    if columns is not None:
        series = pd.DataFrame({plain_text(name): arrays[f"c{k}"] for k, name in enumerate(columns)})
    return Verdict([checked_row(row) for row in header["rows"]], series, tuple(map(Role, header["further_runs"])))


def checked_row(row: dict[str, Any]) -> Row:
    """Row of the metrics table with its own columns, text and numbers.

    Raises
    ------
    MessageError
        If it is another.
    """
    if tuple(row) != METRIC_COLUMNS:
        raise MessageError(f"a row has the columns {plain_text(', '.join(map(str, row)))}")
    Outcome(row["outcome"])
    return {name: checked_value(name, value) for name, value in row.items()}


def checked_value(name: str, value: object) -> float | str | None:
    """Text, number or None.

    Raises
    ------
    MessageError
        For anything else.
    """
    if value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)):
        return value
    if not isinstance(value, str):
        raise MessageError(f"{name} is a {type(value).__name__}")
    return plain_text(value, MOST_REASON)


VERDICTS = VerdictCodec(verdict_bytes, verdict_from)
