"""Judged trials as messages between processes: text and numbers, read without running code."""

from __future__ import annotations

import dataclasses
from typing import Any

from barchain.runs.job import Role
from barchain.runs.message import MessageError, message_bytes, plain_text, read_message
from barchain.runs.verdict_task import VerdictCodec
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.campaign.rating import Judged
from barchain.studies.selftest.trial import DetectionLimit
from reports.tables.faults.campaign import CellClass

MOST_TEXT = 2000
"""Characters of a text in a cell"""
NUMBERS = ("size", "limit", "own_limit", "seconds")
"""Numbers of a cell; all else is text"""


def judged_bytes(judged: Judged) -> bytes:
    """Message with a judged trial."""
    limits = {name: [limit.share, limit.until_s] for name, limit in judged.limits.items()}
    roles = [str(role) for role in judged.further_runs]
    cell = {name: value if name in NUMBERS else str(value) for name, value in dataclasses.asdict(judged.cell).items()}
    return message_bytes({"cell": cell, "limits": limits, "further_runs": roles}, {})


def judged_from(content: bytes) -> Judged:
    """Judged trial of a message.

    Raises
    ------
    MessageError, ValueError, TypeError, KeyError
        If a part is missing or of a wrong type.
    """
    header, _ = read_message(content)
    limits = {plain_text(name): DetectionLimit(*map(number, pair)) for name, pair in header["limits"].items()}
    return Judged(cell_from(header["cell"]), limits, tuple(map(Role, header["further_runs"])))


def cell_from(said: dict[str, Any]) -> CampaignCell:
    """Cell of a message."""
    plain: dict[str, Any] = {
        name: optional_number(v) if name in NUMBERS else plain_text(v, MOST_TEXT) for name, v in said.items()
    }
    return CampaignCell(**(plain | {"kind": CellClass(said["kind"])}))


def optional_number(value: object) -> float | None:
    """Number, or None."""
    return None if value is None else number(value)


def number(value: object) -> float:
    """Number, which may be infinite or NaN.

    Raises
    ------
    MessageError
        If it is none.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise MessageError(f"its verdict holds a {type(value).__name__}, expected a number")
    return value


JUDGED = VerdictCodec(judged_bytes, judged_from)
