"""Rows of the random campaign, as the tables that its page is rendered from.

``campaign``
    a row for each engine on each scene, and for each fault in each host on each scene;
``rates``, ``rates_of_parts``
    rates with 95 % intervals: over everything, and by outcome, engine or fault;
``scenes/<scene>-<engine>[-<fault>].toml``
    a scene for each finding, beside the series, as simple as one could be found.
"""

from __future__ import annotations

from enum import StrEnum

from reports.results.files import StudyFiles
from reports.results.rows import Followed
from reports.results.schema import StudyRecord
from reports.results.table import Table

SCENES = "scenes"
ALL = "all"


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


RATE = {"rate": ".value", "low": ".low", "high": ".high", "why": ".reason"}
TABLES = {
    "campaign": Table(
        ("scene", "engine", "fault"),  # no fault: the unmodified engine
        "class",
        {
            "class": ".outcome",
            "reason": ".reason",
            "quantity": ".text",
            "size": "size",  # largest change of the quantity over its scale
            "detection_limit": "detection_limit",  # by the unmodified engine's verdict
            "own_limit": "own_limit",  # by the faulty engine's
            "seconds": "seconds:trial s",
            "outcome": "outcome.text",
        },
    ),
    "rates": Table(("what",), "rate", RATE | {"n": "tried", "count": "counted"}),  # what: a class of cells
    "rates_of_parts": Table(
        ("what", "by", "name"), "rate_of_part", RATE | {"n": "part.tried", "count": "part.counted"}
    ),
}
FOLLOWED = {
    "class": Followed("verdict", setting="{fault}"),
    "rate": Followed("value", "{metric}.{what}"),
}


FILES = StudyFiles(
    "campaign",
    TABLES,
    followed=FOLLOWED,
    model=StudyRecord,
    title="Random campaign",
    view="campaign:view_campaign",
    command="selftest --random N",
)
