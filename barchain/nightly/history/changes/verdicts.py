"""Rules of verdicts: another word is always told, and the scale of its study says whether it is better or worse.

Where a comparison's verdict became right, larger errors of the same run are no regression: the earlier ones were those
of a wrong result, which may be small by chance.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from barchain.nightly.history.changes.model import Direction, Judgement
from barchain.nightly.history.model.figures import FigureKind
from reports.tables.faults.campaign import CellClass
from reports.tables.faults.selftest import FaultOutcome
from reports.tables.outcome import SEVERITY, Outcome
from reports.tables.stability import Stability

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.nightly.history.changes.model import Change
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

WRONG = {str(o) for o in (Outcome.INCONSISTENT, Outcome.EXCEEDS_BOUND, Outcome.JOINTS_IGNORED, Outcome.MALFORMED)}
"""Verdicts on a whole result that is wrong"""
RIGHT = {str(Outcome.PASS), str(Outcome.ROUNDOFF_LIMITED)}
VERDICT = "verdict"
"""Quantity of a comparison's verdict; those of other studies have the study's name before them"""
OTHER_STUDIES = {"cost", "stability", "roundoff", "selftest", "campaign", "scaling", "effects", "ensemble"}
"""First words of the quantities of all studies but the comparison"""
MENDED = "the verdict became right: the earlier value was that of a wrong result"


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


def without_mended(changes: Iterable[Change]) -> list[Change]:
    """Changes; a comparison's larger errors are neither better nor worse where its verdict became right."""
    every = list(changes)
    mended = {
        run_of(change)
        for change in every
        if change.identity.quantity == VERDICT and change.was.word in WRONG and change.now.word in RIGHT
    }
    return [as_mended(change) if run_of(change) in mended else change for change in every]


def run_of(change: Change) -> tuple[str, str, str]:
    """Scene and engine of a change, and the night since which it is; verdicts have no setting in their names."""
    return change.identity.scene, change.identity.engine, change.since


def as_mended(change: Change) -> Change:
    """Change of a result that was wrong before; an error that is gone, or of another study, is no larger one."""
    error = change.identity.kind is FigureKind.ERROR and change.identity.quantity.partition(".")[0] not in OTHER_STUDIES
    if not error or change.now.missing or change.direction is not Direction.WORSE:
        return change
    return replace(change, direction=Direction.CHANGED, reason=f"{MENDED}; {change.reason}")
