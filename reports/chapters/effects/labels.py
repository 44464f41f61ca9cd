"""Placement of names beside the points of a chart without overlaps."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

LETTER, LINE = 5.4, 11.0  # width of a letter and height of a line, px
CLEAR = 5.5  # px from a point's middle that a name keeps off
SHIFTS = (0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0, 5.0, -5.0)  # lines up


@dataclass(frozen=True)
class Box:
    """Rectangle, px."""

    left: float
    low: float
    right: float
    high: float

    def meets(self, other: Box) -> bool:
        """Whether two boxes overlap."""
        return self.left < other.right and other.left < self.right and self.low < other.high and other.low < self.high

    @property
    def middle(self) -> float:
        """Height of its middle, px."""
        return 0.5 * (self.low + self.high)


@dataclass(frozen=True)
class Anchor:
    """A point to be named, px from the plot's lower left corner."""

    text: str
    x: float
    y: float
    reach: tuple[float, float]
    """Ends of its interval, px"""

    @property
    def box(self) -> Box:
        """Box of the point itself, with its interval."""
        left, right = self.reach
        return Box(min(left, self.x - CLEAR), self.y - 3.0, max(right, self.x + CLEAR), self.y + 3.0)

    @property
    def places(self) -> Iterator[Box]:
        """Possible boxes of the name, nearest first: right and left of the point, then lines above and below."""
        width, point = LETTER * len(self.text), self.box
        for shift, right in product(SHIFTS, (True, False)):
            left = point.right + 2.0 if right else point.left - 2.0 - width
            yield Box(left, self.y - 0.5 * LINE + shift * LINE, left + width, self.y + 0.5 * LINE + shift * LINE)


def placed(anchors: Sequence[Anchor], width: float, height: float) -> list[Box | None]:
    """Boxes of the names in a plot of this size; None for a name that fits nowhere."""
    taken, plot = [a.box for a in anchors], Box(0.0, 0.0, width, height)
    found: dict[int, Box | None] = {}
    for k in sorted(range(len(anchors)), key=lambda k: -anchors[k].y):
        free = (b for b in anchors[k].places if inside(b, plot) and not any(b.meets(t) for t in taken))
        found[k] = next(free, None)
        taken += [b for b in (found[k],) if b]
    return [found[k] for k in range(len(anchors))]


def inside(box: Box, plot: Box) -> bool:
    """Whether a box lies within the plot."""
    return plot.left <= box.left and box.right <= plot.right and plot.low <= box.low and box.high <= plot.high
