"""Outcome of each engine on each scene, and of each fault: the cells of a campaign."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

COLUMNS = (
    "scene", "engine", "fault", "outcome", "class", "quantity", "reason", "size", "detection_limit", "own_limit",
    "seconds",
)  # fmt: skip


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


UNMODIFIED = (CellClass.PASS, CellClass.LIMITED, CellClass.FALSE_ALARM)
"""Classes of unmodified engines that ran"""
TRIED = (CellClass.CAUGHT, CellClass.MISSED)
"""Classes of faults that a verdict has to detect"""


@dataclass(frozen=True)
class CampaignCell:
    """One engine on one scene, as it is or with a fault in it."""

    scene: str
    engine: str
    fault: str
    """Empty: the engine as it is"""
    kind: CellClass
    outcome: str = ""
    """The judge's; empty where nothing was judged"""
    quantity: str = ""
    """Quantity that is rejected, or that the fault changes most"""
    reason: str = ""
    size: float | None = None
    """Largest change of the quantity, over its scale"""
    limit: float | None = None
    """Smallest detectable change by the unmodified engine's verdict"""
    own_limit: float | None = None
    """Smallest detectable change by the faulty engine's own verdict, which a user would read"""
    seconds: float = 0.0
    """Time of its own runs"""

    @property
    def is_finding(self) -> bool:
        """Whether it speaks against the judge."""
        return self.kind in (CellClass.MISSED, CellClass.FALSE_ALARM)

    def row(self) -> dict[str, Any]:
        """Row of the table."""
        values = (
            self.scene, self.engine, self.fault, self.outcome, str(self.kind), self.quantity, self.reason, self.size,
            self.limit, self.own_limit, self.seconds,
        )  # fmt: skip
        return dict(zip(COLUMNS, values, strict=True))
