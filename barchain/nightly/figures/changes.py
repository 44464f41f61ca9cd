"""Changes of figures, and the rules of bits, counts, errors, values and verdicts."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from barchain.metrics.quantities import TRACK
from barchain.nightly.figures.figure import STEPPED, Figure, FigureIdentity, FigureKind, content_digest
from reports.results.comparison import COMPARISON
from reports.results.nights.document import multiple
from reports.results.outcome import SEVERITY, Outcome
from reports.results.selftest import FaultOutcome
from reports.results.stability import Stability
from reports.results.studies import STUDIES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.nightly.figures.figure import NightSummary


ID_DIGITS = 10
STATE_DIGITS = 16


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
    latest: Figure | None = None
    """Result of the last night, of a state that holds"""
    through: str = ""
    """Night of the latest step, of a state of several steps"""
    steps: int = 1
    """Number of steps that lead to the new value"""
    named: tuple[FigureIdentity, ...] = ()
    """Names that the figure has had since the change, if it had others"""
    settings: tuple[str, ...] = ()
    """Settings of the run before and since the change, where they differ"""

    @property
    def names(self) -> tuple[str, ...]:
        """All names that the figure has had since the change: an acceptance has that of its day."""
        return tuple(identity.name for identity in self.named or (self.identity,))

    @property
    def is_step(self) -> bool:
        """Whether it is a step of times or memory."""
        return self.identity.kind in STEPPED and not self.now.missing

    @property
    def id(self) -> str:
        """Name of the change: the same as long as figure, nights and values are."""
        return self.ids[0]

    @property
    def ids(self) -> tuple[str, ...]:
        """Name of the change, and those that it had under earlier names of the figure.

        That of a step has figure, night and direction only: the values after a step are other ones on each night.
        """
        values = [self.last, self.since, self.now.word, self.now.value]
        rest = [self.since, str(self.direction)] if self.is_step else values
        every = reversed(self.named or (self.identity,))
        return tuple(content_digest([identity, *rest])[:ID_DIGITS] for identity in every)


def result_words(figure: Figure, *, exact: bool = False) -> str:
    """Result of a figure in words: of a number six digits, or all."""
    if figure.missing:
        return "missing"
    if figure.value is None:
        return figure.word
    unit, value = str(figure.identity.unit), f"{figure.value!r}" if exact else f"{figure.value:.6g}"
    return f"{value}{f' {unit}' if unit not in {'', '1'} else ''}"


def results_words(change: Change) -> tuple[str, str]:
    """Old and new result of a change in words, with the digits that tell them apart."""
    figures = change.was, change.latest or change.now
    was, now = map(result_words, figures)
    return (was, now) if was != now else (result_words(figures[0], exact=True), result_words(figures[1], exact=True))


NOT_REPRODUCIBLE = Judgement(
    Direction.WORSE, "not reproducible: the same parts on the same class of machine gave other bits",
    irreproducible=True,
)  # fmt: skip
OTHER_PARTS = Judgement(Direction.CHANGED, "other bits from other parts")
UNKNOWN_PARTS = Judgement(
    Direction.CHANGED, "other bits; whether a part changed is not known, as parts have no digests"
)


def parts_digest(night: NightSummary, figure: Figure) -> str:
    """Digest of the parts that a figure depends on; empty if that of one is unknown."""
    named = night.part_named
    known = [named[name].digest for name in figure.depends if name in named]
    if len(known) < len(figure.depends) or not known or not all(known):
        return ""
    return hashlib.sha256("\n".join((*figure.depends, *known)).encode()).hexdigest()[:STATE_DIGITS]


LEAST_UNKNOWN = 0.01
"""Of an error without recorded rounding: a smaller relative change is told, and called neither better nor worse"""


def judge_number(was: Figure, now: Figure, earlier: str = "the earlier error") -> Judgement | None:
    """Judge an error, a count or a value against an earlier one; None for the same number.

    Intervals of values that overlap explain a difference, as does the rounding of both numbers. Of counts and values it
    is not known what is better: errors and times tell that. `earlier` names what an error is compared with.
    """
    assert was.value is not None
    assert now.value is not None
    if now.value == was.value:
        return None
    off, factor = abs(now.value - was.value), now.value / was.value if was.value else None
    if was.identity.kind is FigureKind.VALUE and overlap(was, now):
        return Judgement(Direction.SAME, f"differs by {off:.2g}, and the intervals overlap", factor)
    known = was.tolerance is not None and now.tolerance is not None
    rounding = (was.tolerance or 0.0) + (now.tolerance or 0.0)
    if known and off <= rounding:
        return Judgement(Direction.SAME, f"differs by {off:.2g}, rounding explains {rounding:.2g}", factor)
    if was.identity.kind is not FigureKind.ERROR:
        return Judgement(Direction.CHANGED, f"{was.value:.10g} before, {now.value:.10g} now", factor)
    if not known and factor is not None and factor > 0.0 and abs(math.log(factor)) < LEAST_UNKNOWN:
        said = f"{factor:.6g} times {earlier}; its rounding is not recorded"
        return Judgement(Direction.CHANGED, said, factor)
    direction = Direction.WORSE if now.value > was.value else Direction.BETTER
    beyond = f"{off / rounding:.3g} times what rounding explains" if rounding else "beyond rounding"
    grown = f"{multiple(factor)} times {earlier}" if factor is not None else "was zero"
    return Judgement(direction, f"{grown}, a difference {beyond}" if known else grown, factor)


def overlap(was: Figure, now: Figure) -> bool:
    """Whether both figures have intervals, and these overlap."""
    if was.low is None or was.high is None or now.low is None or now.high is None:
        return False
    return was.low <= now.high and now.low <= was.high


SCALES: tuple[tuple[str, ...], ...] = (
    tuple(map(str, SEVERITY)),
    (
        Stability.STABLE, Stability.DRIFTING, Stability.INACCURATE, Stability.UNSTABLE, Stability.UNSUPPORTED,
        Stability.REJECTED, Stability.FAILED,
    ),
    (FaultOutcome.KILLED, FaultOutcome.INVISIBLE, FaultOutcome.SURVIVES, FaultOutcome.BROKEN),
    (FaultOutcome.CLEAN, FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN),
    ("pass", "limited", "unsupported", "timed out", "false alarm"),  # of random scenes, in nights of 0.7
    ("caught", "below the limit", "beyond the predictability limit", "missed", "broken"),  # of faults in them
    ("reached", "at most", "no verdict", "not reached"),  # "at most" in nights before 2026-11-28
)  # fmt: skip
"""Words of each study from the best to the worst"""

WRONG = {str(o) for o in (Outcome.INCONSISTENT, Outcome.EXCEEDS_BOUND, Outcome.JOINTS_IGNORED, Outcome.MALFORMED)}
"""Verdicts on a whole result that is wrong"""
RIGHT = {str(Outcome.PASS), str(Outcome.ROUNDOFF_LIMITED)}
VERDICT = "verdict"
"""Quantity of a comparison's verdict; those of other studies have the study's name before them"""
OTHER_STUDIES = {"campaign", *(files.study for files in STUDIES if files.followed)} - {COMPARISON}
"""First words of the quantities of all studies but the comparison; nights of 0.7 have campaigns of random scenes"""


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


COMPARED = frozenset(FigureKind) - STEPPED - {FigureKind.BITS}
"""Kinds of which a figure is judged against an earlier one alone"""

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
    return judge_verdict(was, now) if was.identity.kind is FigureKind.VERDICT else judge_number(was, now)


ROUNDING_LEVEL = 30.0
"""Errors below so many shares of rounding are rounding themselves: the share is an estimate of its size, not a bound"""


def is_above(level: Figure, now: Figure) -> bool:
    """Whether a figure is worse than its level.

    Errors and verdicts can be, and a figure that is missing. An error at the level of rounding is a draw of rounding:
    it is news when it moves, and never worse. The share of the track is a bound: its roundings grow by Kepler's orbit
    alone, not by the scene's amplification.
    """
    if level.missing or now.missing:
        return now.missing and not level.missing
    shares = 1.0 if now.identity.quantity.partition(".")[0] in TRACK else ROUNDING_LEVEL
    if now.identity.kind is FigureKind.ERROR and (now.value or 0.0) <= shares * (now.tolerance or 0.0):
        return False
    return now.identity.kind in COMPARED and differs(level, now, Direction.WORSE)


def is_better(level: Figure, now: Figure) -> bool:
    """Whether a result that is there is better than another one."""
    return not level.missing and differs(level, now, Direction.BETTER)


def differs(was: Figure, now: Figure, direction: Direction) -> bool:
    """Whether a result differs from an earlier one in a direction."""
    judged = compared(was, now)
    return judged is not None and judged.direction is direction


def worst(figures: Iterable[Figure]) -> Figure:
    """Worst of some results."""
    found, *others = figures
    for figure in others:
        found = figure if differs(found, figure, Direction.WORSE) else found
    return found
