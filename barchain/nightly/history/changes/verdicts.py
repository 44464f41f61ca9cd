"""Rule of verdicts: another word is always told, and the scale of its study says whether it is better or worse."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Direction, Judgement
from reports.tables.faults.campaign import CellClass
from reports.tables.faults.selftest import FaultOutcome
from reports.tables.outcome import SEVERITY
from reports.tables.stability import Stability

if TYPE_CHECKING:
    from barchain.nightly.history.model.figures import Figure

SCALES: tuple[tuple[str, ...], ...] = (
    tuple(map(str, SEVERITY)),
    (
        Stability.STABLE, Stability.DRIFTING, Stability.INACCURATE, Stability.UNSTABLE, Stability.UNSUPPORTED,
        Stability.REJECTED, Stability.FAILED,
    ),
    (FaultOutcome.KILLED, FaultOutcome.INVISIBLE, FaultOutcome.SURVIVES, FaultOutcome.BROKEN),
    (FaultOutcome.CLEAN, FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN),
    (CellClass.PASS, CellClass.LIMITED, CellClass.UNSUPPORTED, CellClass.LATE, CellClass.FALSE_ALARM),
    (CellClass.CAUGHT, CellClass.BELOW, CellClass.BEYOND, CellClass.MISSED, CellClass.BROKEN),
    ("reached", "at most", "no verdict", "not reached"),
)  # fmt: skip
"""Words of each study from the best to the worst"""


def judge_verdict(was: Figure, now: Figure) -> Judgement | None:
    """Judge a verdict against an earlier one; None for the same word."""
    if now.word == was.word:
        return None
    said = f"{was.word} before, {now.word} now" + (f": {now.reason}" if now.reason else "")
    for scale in SCALES:
        if was.word in scale and now.word in scale:
            worse = scale.index(now.word) > scale.index(was.word)
            return Judgement(Direction.WORSE if worse else Direction.BETTER, said)
    return Judgement(Direction.CHANGED, said)
