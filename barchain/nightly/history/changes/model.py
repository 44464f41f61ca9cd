"""Changes of figures, as all rules give them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from barchain.nightly.history.model.figures import STEPPED
from barchain.nightly.history.model.identity import content_digest

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import Figure, FigureIdentity

ID_DIGITS = 10


class Direction(StrEnum):
    """Direction of a change."""

    BETTER = "better"
    WORSE = "worse"
    SAME = "same"
    """Numerically the same: within rounding, or within the intervals"""
    CHANGED = "changed"
    """Neither better nor worse, or not known which"""


@dataclass(frozen=True)
class Judgement:
    """Relation of a figure to an earlier one."""

    direction: Direction
    reason: str
    factor: float | None = None
    """New value relative to the old one; None where there is none"""
    irreproducible: bool = False
    """Whether equal parts on an equal machine gave other bits"""


@dataclass(frozen=True)
class Change:
    """Change of one figure between two nights."""

    identity: FigureIdentity
    was: Figure
    now: Figure
    last: str
    """Name of the last night with the old value"""
    since: str
    """Name of the first night with the new value"""
    direction: Direction
    reason: str
    factor: float | None = None
    """New value relative to the old one"""
    factor_low: float | None = None
    """Ends of the factor's 95 % interval, of times and memory"""
    factor_high: float | None = None
    irreproducible: bool = False
    level: str = ""
    """Name of the night on which the earlier level began; of levels only"""

    @property
    def id(self) -> str:
        """Name of the change: the same as long as figure, nights and values are.

        That of a step has figure, night and direction only: the values after a step are other ones on each night.
        """
        if self.identity.kind in STEPPED and not self.now.missing:
            return content_digest([self.identity, self.since, str(self.direction)])[:ID_DIGITS]
        return content_digest([self.identity, self.last, self.since, self.now.word, self.now.value])[:ID_DIGITS]


@dataclass(frozen=True)
class ToldChange:
    """Change that an earlier night told first."""

    since: str
    """Name of the first night with the new value"""
    direction: Direction


def result_words(figure: Figure) -> str:
    """Result of a figure in words."""
    if figure.missing:
        return "missing"
    unit = str(figure.identity.unit)
    return figure.word or f"{figure.value:.6g}{f' {unit}' if unit not in {'', '1'} else ''}"
