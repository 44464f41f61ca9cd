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
    """A sound engine that the judge finds right"""
    LIMITED = "limited"
    """A sound engine that its round-off limits, as the judge says"""
    UNSUPPORTED = "unsupported"
    """An engine that can't carry the scene, and says so"""
    LATE = "not in time"
    """An engine whose run is ended by the campaign's limit of time: nobody says that it is wrong"""
    FALSE_ALARM = "false alarm"
    """A sound engine that the judge refuses"""
    CAUGHT = "caught"
    """A fault that the judge refuses"""
    BELOW = "below the limit"
    """A fault that is not seen, and is smaller than the verdict says that it would detect"""
    BEYOND = "beyond the horizon"
    """A fault that is not seen, and is larger than that only where the verdict compares nothing with the reference"""
    MISSED = "missed"
    """A fault that is not seen, though the verdict says that it would be"""
    NOTHING = "nothing to spoil"
    """A fault that changes nothing there, or can't be put in"""
    BROKEN = "broken"
    """A spoilt engine that fails where it should run: no verdict on the judge"""


SOUND = (CellClass.PASS, CellClass.LIMITED, CellClass.FALSE_ALARM)
"""Classes of sound engines that ran"""
TRIED = (CellClass.CAUGHT, CellClass.MISSED)
"""Classes of faults that a verdict has to see"""


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
    """That is refused, or that the fault changes most"""
    reason: str = ""
    size: float | None = None
    """Largest change of the quantity, over its scale"""
    limit: float | None = None
    """Smallest change that the sound engine's verdict says it would detect"""
    own_limit: float | None = None
    """The same of the spoilt engine's own verdict: what a user would read"""
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
