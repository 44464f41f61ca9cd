"""Rule of errors: deterministic, so that a difference beyond what rounding makes of the figure is a change.

Two runs of the same method that round differently part by at most one share of rounding each: a random walk of the
roundings of all steps, amplified by the scene. Their errors differ by at most the sum of both shares. A larger
difference has another cause.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Direction, Judgement

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import Figure

LEAST_UNKNOWN = 0.01
"""Of an error without recorded rounding: a smaller relative change is told, and called neither better nor worse"""


def judge_error(was: Figure, now: Figure) -> Judgement | None:
    """Judge an error against an earlier one; None for the same number."""
    assert was.value is not None
    assert now.value is not None
    if now.value == was.value:
        return None
    known = was.tolerance is not None and now.tolerance is not None
    rounding = (was.tolerance or 0.0) + (now.tolerance or 0.0)
    off = abs(now.value - was.value)
    factor = now.value / was.value if was.value else None
    if known and off <= rounding:
        return Judgement(Direction.SAME, f"differs by {off:.2g}, rounding explains {rounding:.2g}", factor)
    if not known and factor is not None and factor > 0.0 and abs(math.log(factor)) < LEAST_UNKNOWN:
        return Judgement(
            Direction.CHANGED, f"{factor:.6g} times the earlier error; its rounding is not recorded", factor
        )
    direction = Direction.WORSE if now.value > was.value else Direction.BETTER
    beyond = f"{off / rounding:.3g} times what rounding explains" if rounding else "beyond rounding"
    grown = f"{factor:.4g} times the earlier error" if factor is not None else "was zero"
    return Judgement(direction, f"{grown}, a difference {beyond}" if known else grown, factor)
