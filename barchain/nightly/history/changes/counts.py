"""Rule of counts: exact."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Direction, Judgement

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import Figure


def judge_count(was: Figure, now: Figure) -> Judgement | None:
    """Judge a count against an earlier one; None for the same number.

    More steps are neither better nor worse: errors and times tell that.
    """
    assert was.value is not None
    assert now.value is not None
    if now.value == was.value:
        return None
    factor = now.value / was.value if was.value else None
    return Judgement(Direction.CHANGED, f"{was.value:.0f} before, {now.value:.0f} now", factor)
