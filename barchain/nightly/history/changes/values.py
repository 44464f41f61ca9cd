"""Rule of other values: by their intervals or their rounding; exact without either."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Direction, Judgement

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import Figure


def judge_value(was: Figure, now: Figure) -> Judgement | None:
    """Judge a value against an earlier one; None for the same number.

    Intervals that overlap explain a difference, as does the rounding of both. What is better is not known.
    """
    assert was.value is not None
    assert now.value is not None
    if now.value == was.value:
        return None
    off, factor = abs(now.value - was.value), now.value / was.value if was.value else None
    if overlap(was, now):
        return Judgement(Direction.SAME, f"differs by {off:.2g}, and the intervals overlap", factor)
    if was.tolerance is not None and now.tolerance is not None and off <= was.tolerance + now.tolerance:
        rounding = was.tolerance + now.tolerance
        return Judgement(Direction.SAME, f"differs by {off:.2g}, rounding explains {rounding:.2g}", factor)
    return Judgement(Direction.CHANGED, f"{was.value:.6g} before, {now.value:.6g} now", factor)


def overlap(was: Figure, now: Figure) -> bool:
    """Whether both figures have intervals, and these overlap."""
    ends = (was.low, was.high, now.low, now.high)
    if any(end is None for end in ends):
        return False
    low_was, high_was, low_now, high_now = (float(end) for end in ends if end is not None)
    return low_was <= high_now and low_now <= high_was
