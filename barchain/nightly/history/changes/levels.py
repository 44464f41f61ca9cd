"""Levels of deterministic figures: a figure is compared with the night on which its present level began.

Small differences that rounding explains can't add up over the nights unseen, as they could between neighbours.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.history.changes.counts import judge_count
from barchain.nightly.history.changes.errors import judge_error
from barchain.nightly.history.changes.model import Change, Direction, Judgement
from barchain.nightly.history.changes.values import judge_value
from barchain.nightly.history.changes.verdicts import judge_verdict
from barchain.nightly.history.model.figures import FigureKind

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.nightly.history.model.figures import Figure
    from barchain.nightly.history.model.series_model import FigureSeries

RULES: dict[FigureKind, Callable[[Figure, Figure], Judgement | None]] = {
    FigureKind.ERROR: judge_error,
    FigureKind.VERDICT: judge_verdict,
    FigureKind.COUNT: judge_count,
    FigureKind.VALUE: judge_value,
}
"""Rule of each deterministic kind"""

PATIENCE = 5
"""Nights in a row on which a run had no time: then that is told. Slow-downs of 10 % take about as many nights"""


def compared(was: Figure, now: Figure) -> Judgement | None:
    """Judge a figure against an earlier one of the same identity; None if nothing differs."""
    if was.missing or now.missing:
        if was.missing and now.missing:
            return None
        if now.missing:
            return Judgement(Direction.WORSE, f"missing: {now.reason}")
        return Judgement(Direction.BETTER, f"there again; it was missing: {was.reason}")
    return RULES[was.identity.kind](was, now)


def level_changes(series: FigureSeries) -> tuple[Change, ...]:
    """Changes of a deterministic figure over the nights, each against the level before.

    A run that a busy machine had no time for is no change, until it has been left out :data:`PATIENCE` nights in a row.
    """
    found: list[Change] = []
    begin: int | None = None  # place of the night on which the level began
    known: int | None = None  # the same of the last level that was not missing
    told: Figure | None = None  # the last figure that was told to be neither better nor worse than its level
    left_out = 0
    for k, now in enumerate(series.figures):
        left_out = left_out + 1 if now.not_run else 0
        if 0 < left_out < PATIENCE or (begin is None and now.not_run):
            continue
        if begin is None:
            begin = k
        if series.figures[begin].missing and known is not None and is_worse(series.figures[known], now):
            begin = known  # a figure that comes back worse than it was has not become better
        level = series.figures[begin]
        judged = compared(level, now) if begin < k else None
        if judged is not None and judged.direction is not Direction.SAME and not is_told(told, now, judged):
            last, since = series.nights[k - 1].name, series.nights[k].name
            found.append(
                Change(
                    series.identity, level, now, last, since, judged.direction, judged.reason, judged.factor,
                    level=series.nights[begin].name,
                )
            )  # fmt: skip
            undecided = judged.direction is Direction.CHANGED and series.identity.kind is FigureKind.ERROR
            told, begin = (now, begin) if undecided else (None, k)
        known = known if series.figures[begin].missing else begin
    return tuple(found)


def is_told(told: Figure | None, now: Figure, judged: Judgement) -> bool:
    """Whether a difference from the level was told before: it is neither better nor worse, and nothing moved since.

    The level stays where it is then, so that small differences add up.
    """
    return told is not None and judged.direction is Direction.CHANGED and compared(told, now) is None


def is_worse(was: Figure, now: Figure) -> bool:
    """Whether a figure that is there is worse than an earlier one."""
    if was.missing or now.missing or was.identity.kind not in RULES:
        return False
    judged = compared(was, now)
    return judged is not None and judged.direction is Direction.WORSE


def same_changes(series: FigureSeries) -> tuple[Change, ...]:
    """Difference of the last night's figure from the night before that rounding or intervals explain; none, or one."""
    if len(series.figures) < 2:
        return ()
    was, now = series.figures[-2:]
    judged = compared(was, now)
    if judged is None or judged.direction is not Direction.SAME:
        return ()
    last, since = series.nights[-2].name, series.nights[-1].name
    return (Change(series.identity, was, now, last, since, judged.direction, judged.reason, judged.factor),)
