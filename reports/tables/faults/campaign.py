"""Stored tables of the random campaign: everything that its page is rendered from.

A folder ``campaign`` inside a result folder holds

``campaign.csv``
    a row for each engine on each scene, and for each fault in each host on each scene, columns :data:`COLUMNS`;
``rates.csv``
    rates with 95 % intervals, columns :data:`RATE_COLUMNS`;
``scenes/<scene>-<engine>[-<fault>].toml``
    a scene for each finding, as simple as one could be found;
``record.json``
    scenes, engines, faults, environment, and whether the campaign passed.
"""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, Any

from reports.tables.files import StudyFiles
from reports.tables.rows import Followed, Rows, known, records
from reports.tables.schema import Record

if TYPE_CHECKING:
    from pathlib import Path

COLUMNS = (
    "scene", "engine", "fault", "outcome", "class", "quantity", "reason", "size", "detection_limit", "own_limit",
    "seconds",
)  # fmt: skip
"""`fault`: empty for the unmodified engine; `size`: largest change of the quantity over its scale; `detection_limit`:
by the unmodified engine's verdict; `own_limit`: by the faulty engine's"""
RATE_COLUMNS = ("what", "by", "name", "n", "count", "rate", "low", "high")
"""`what`: a :class:`CellClass`; `by`: ``all``, ``outcome``, ``engine`` or ``fault``; `low`, `high`: 95 % interval"""
WORDS = ("scene", "engine", "fault", "outcome", "class", "quantity", "reason", "what", "by", "name")
SCENES = "scenes"
ALL = "all"


class CampaignRecord(Record):
    """Entries of the record."""

    seed: int | None = None
    scenes: int | None = None
    engines: list[str] | None = None
    hosts: list[str] | None = None
    most_reruns: int | None = None
    faults: dict[str, dict[str, Any]] | None = None
    passed: bool | None = None


FILES = StudyFiles(
    "campaign",
    {"campaign": COLUMNS, "rates": RATE_COLUMNS},
    WORDS,
    model=CampaignRecord,
    pages=("campaign.html",),
)


class CellClass(StrEnum):
    """Class of a cell."""

    PASS = "pass"
    """An unmodified engine that the judge accepts"""
    LIMITED = "limited"
    """An unmodified engine that round-off limits, by the verdict"""
    UNSUPPORTED = "unsupported"
    """An engine that does not support the scene"""
    LATE = "timed out"
    """An engine whose run reaches the campaign's time limit: no verdict"""
    FALSE_ALARM = "false alarm"
    """An unmodified engine that the judge rejects"""
    CAUGHT = "caught"
    """A faulty engine that the judge rejects"""
    BELOW = "below the limit"
    """An undetected fault below the detection limit of the verdict"""
    BEYOND = "beyond the predictability limit"
    """An undetected fault above the detection limit only where the verdict compares nothing with the reference"""
    MISSED = "missed"
    """An undetected fault above the detection limit of the verdict"""
    NOTHING = "not applicable"
    """A fault that changes nothing in the scene, or can't be inserted"""
    BROKEN = "broken"
    """A faulty engine that fails where it should run: the fault is not inserted as meant"""


ENGINE_CLASSES = (CellClass.PASS, CellClass.LIMITED, CellClass.FALSE_ALARM, CellClass.UNSUPPORTED, CellClass.LATE)
"""Classes of unmodified engines"""
FAULT_CLASSES = (
    CellClass.CAUGHT, CellClass.MISSED, CellClass.BELOW, CellClass.BEYOND, CellClass.NOTHING, CellClass.BROKEN,
)  # fmt: skip
"""Classes of faulty engines"""


read_campaign = FILES.contents


SIZES = {
    "size": ("", "size", "1"), "detection_limit": ("", "detection_limit", "1"), "own_limit": ("", "own_limit", "1"),
    "seconds": ("trial", "seconds", "s"),
}  # fmt: skip
"""Quantity, metric and unit of the columns of numbers"""
FOLLOWED = {
    "class": Followed("verdict", setting="{fault}"),
    "rate": Followed("value", "{metric}.{what}"),
}


def campaign_rows(folder: Path) -> Rows:
    """Rows of a campaign: the class of each cell, and the rates with their intervals; of other seeds scenes differ."""
    tables, found = read_campaign(folder), Rows(FILES.name)
    for row in records(tables.campaign):
        where = {name: row[name] for name in ("scene", "engine", "fault")}
        found.add("class", outcome=row["class"], reason=row["reason"], text=row["quantity"], **where)
        found.add("verdict", outcome=row["outcome"], **where)
        found.measured(row, SIZES, **where)
    for row in records(tables.rates):
        every = row["by"] == ALL
        of = {} if every else {"by": row["by"], "name": row["name"]}
        reason = "" if known(row["rate"]) else "none tried"
        ends = {"low": row["low"], "high": row["high"], "reason": reason}
        found.add("rate" if every else "rate_of_part", row["rate"], what=row["what"], **ends, **of)
    return found
