"""Outcome of each engine on each scene, and of each fault: the cells of a campaign."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from reports.tables.faults.campaign import COLUMNS, CellClass

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
