"""Contact with the surface of the body: the first instant inside a step at which a height reaches zero."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from scipy.optimize import brentq, minimize_scalar

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.model.arrays import Array

PARABOLA_MARGIN = 0.5  # of the lower end's height: a parabola below this starts a search


class BodySurface(Protocol):
    """Surface that a chain may touch."""

    def height(self, y: Array) -> float:
        """Smallest distance of the chain from the surface, m."""

    def clears_surface(self, before: Array, after: Array, step_s: float) -> bool:
        """Whether contact is impossible in the step between these two states."""


def contact_instant(
    dense: Callable[[float], Array], height: Callable[[Array], float], start: float, end: float, before: float
) -> float | None:
    """First instant inside a step at which `height` reaches zero, or None."""
    if before <= 0.0:
        return start

    def at(t: float) -> float:
        return height(dense(t))

    below = end if at(end) <= 0.0 else lowest_instant(at, start, end, before)
    if below is None:
        return None
    found: float = brentq(at, start, below, xtol=1e-9 * max(end - start, 1e-3))
    return found


def lowest_instant(at: Callable[[float], float], start: float, end: float, before: float) -> float | None:
    """Instant inside a step at which `at` is below zero though positive at both ends, or None.

    One step may pass a perigee just below the surface. The parabola through both ends and the middle decides whether to
    search for the lowest point.
    """
    middle, after = at(0.5 * (start + end)), at(end)
    slope, bend = 4.0 * middle - 3.0 * before - after, 2.0 * (before + after - 2.0 * middle)
    if bend <= 0.0 or not 0.0 < -slope < 2.0 * bend:
        return None  # no lowest point between the ends
    if before - slope * slope / (4.0 * bend) > PARABOLA_MARGIN * min(before, after):
        return None
    lowest = minimize_scalar(at, bounds=(start, end), method="bounded", options={"xatol": 1e-9 * (end - start)})
    return float(lowest.x) if lowest.fun <= 0.0 else None
