"""Changes of figures: the rules of bits, counts, errors, values and verdicts, and levels over the nights."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING

from barchain.nightly.figures import MACHINE, STEPPED, FigureKind, content_digest
from barchain.nightly.suspects import differing
from reports.tables.faults.campaign import CellClass
from reports.tables.faults.selftest import FaultOutcome
from reports.tables.outcome import SEVERITY, Outcome
from reports.tables.stability import Stability

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from barchain.nightly.figures import Figure, FigureIdentity, FigureSeries, NightSummary


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
    latest: Figure | None = None
    """Result of the last night, of an earlier change that still holds with another one"""
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


@dataclass(frozen=True)
class JudgedNight:
    """Night with its changes."""

    night: NightSummary
    compared_with: tuple[NightSummary, ...]
    """Earlier nights that it was judged against, in their order"""
    changes: tuple[Change, ...] = ()
    """All changes over these nights, in the order of the nights; those that are not reproducible first"""
    tonight: tuple[Change, ...] = ()
    """Those that this night tells first"""
    same: tuple[Change, ...] = ()
    """Differences of this night from the one before that rounding or intervals explain"""
    judged: int = 0
    """Figures that have an earlier one, those among them that are gone since tonight"""
    new: int = 0
    """Figures of this night that have no earlier one, other than of studies that do other scenes each night"""
    left_out: int = 0
    """Figures of the night before that this night lacks, if that night had another plan"""
    renamed: tuple[str, ...] = ()
    """Settings and scenes that have other names since this night"""

    @property
    def by_name(self) -> dict[str, NightSummary]:
        """All of these nights by name."""
        return {night.name: night for night in (*self.compared_with, self.night)}

    @property
    def replanned(self) -> bool:
        """Whether the night before had another plan."""
        return bool(self.compared_with) and self.compared_with[-1].plan != self.night.plan

    @property
    def worse(self) -> bool:
        """Whether this night tells a change for the worse."""
        return any(change.direction is Direction.WORSE for change in self.tonight)


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


def as_of(change: Change, latest: Figure) -> Change:
    """Change that still holds, with the result of the last night."""
    judged = None if latest is change.now else compared(change.was, latest)
    return replace(change, latest=latest, factor=judged.factor, reason=judged.reason) if judged else change


State = tuple[tuple[str, str, str], ...]
NOT_REPRODUCIBLE = "not reproducible: the same parts on the same class of machine gave other bits"
OTHER_PARTS = "other bits from other parts"
UNKNOWN_PARTS = "other bits; whether a part changed is not known, as parts have no digests"


def bit_changes(series: FigureSeries) -> tuple[Change, ...]:
    """Changes of a trajectory's bits over the nights.

    Each night is compared with the one before, and with the last one of the same parts.
    """
    found: list[Change] = []
    seen: dict[State, tuple[NightSummary, Figure]] = {}
    earlier: tuple[NightSummary, Figure] | None = None
    for night, figure in zip(series.nights, series.figures, strict=True):
        if not figure.word:
            continue
        state = state_of(night, figure)
        alike = seen.get(state) if state is not None else None
        if alike is not None and alike[1].word != figure.word:
            found.append(changed(series, alike, (night, figure), NOT_REPRODUCIBLE, irreproducible=True))
        elif earlier is not None and earlier[1].word != figure.word:
            found.append(changed(series, earlier, (night, figure), UNKNOWN_PARTS if state is None else OTHER_PARTS))
        if state is not None:
            seen[state] = (night, figure)
        earlier = (night, figure)
    return tuple(found)


def changed(
    series: FigureSeries, was: tuple[NightSummary, Figure], now: tuple[NightSummary, Figure], reason: str,
    *, irreproducible: bool = False,
) -> Change:  # fmt: skip
    """Change of bits between two nights."""
    direction = Direction.WORSE if irreproducible else Direction.CHANGED
    return Change(
        series.identity, was[1], now[1], was[0].name, now[0].name, direction, reason,
        irreproducible=irreproducible, named=series.names_since(now[0].name),
    )  # fmt: skip


def state_of(night: NightSummary, figure: Figure) -> State | None:
    """Parts that a figure depends on, with their digests; None if a digest is unknown."""
    named = night.part_named
    parts = [named[name] for name in figure.depends if name in named]
    if len(parts) < len(figure.depends) or not parts or not all(part.digest for part in parts):
        return None
    return tuple((part.name, "", part.digest) for part in parts)


LEAST_UNKNOWN = 0.01
"""Of an error without recorded rounding: a smaller relative change is told, and called neither better nor worse"""


def judge_number(was: Figure, now: Figure) -> Judgement | None:
    """Judge an error, a count or a value against an earlier one; None for the same number.

    Intervals of values that overlap explain a difference, as does the rounding of both numbers. Of counts and values it
    is not known what is better: errors and times tell that.
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
        said = f"{factor:.6g} times the earlier error; its rounding is not recorded"
        return Judgement(Direction.CHANGED, said, factor)
    direction = Direction.WORSE if now.value > was.value else Direction.BETTER
    beyond = f"{off / rounding:.3g} times what rounding explains" if rounding else "beyond rounding"
    grown = f"{factor:.4g} times the earlier error" if factor is not None else "was zero"
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
    (CellClass.PASS, CellClass.LIMITED, CellClass.UNSUPPORTED, CellClass.LATE, CellClass.FALSE_ALARM),
    (CellClass.CAUGHT, CellClass.BELOW, CellClass.BEYOND, CellClass.MISSED, CellClass.BROKEN),
    ("reached", "at most", "no verdict", "not reached"),  # "at most" in nights before 2026-11-28
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
    """Changes; a comparison's larger errors are neither better nor worse where its verdict became right.

    An error that is gone, or of another study, is no larger one. Nor is one whose earlier level began before the
    verdict was wrong: that is the level of a right result.
    """
    every = list(changes)
    mended = {
        run_of(change): change.level
        for change in every
        if change.identity.quantity == VERDICT and change.was.word in WRONG and change.now.word in RIGHT
    }
    found = []
    for c in every:
        error = c.identity.kind is FigureKind.ERROR and c.identity.quantity.partition(".")[0] not in OTHER_STUDIES
        wrong_since = mended.get(run_of(c))
        known = wrong_since is not None and c.level >= wrong_since
        if error and known and c.direction is Direction.WORSE and not c.now.missing:
            found.append(replace(c, direction=Direction.CHANGED, reason=f"{MENDED}; {c.reason}"))
        else:
            found.append(c)
    return found


def run_of(change: Change) -> tuple[str, str, str]:
    """Scene and engine of a change, and the night since which it is; verdicts have no setting in their names."""
    return change.identity.scene, change.identity.engine, change.since


RULES: dict[FigureKind, Callable[[Figure, Figure], Judgement | None]] = {
    FigureKind.ERROR: judge_number,
    FigureKind.VERDICT: judge_verdict,
    FigureKind.COUNT: judge_number,
    FigureKind.VALUE: judge_number,
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
        before = last_of_level(series, level, k)
        judged = against_level(series, level, before, k) if begin < k else None
        if judged is not None and judged.direction is not Direction.SAME and not is_told(told, now):
            last, since = series.nights[before].name, series.nights[k].name
            found.append(
                Change(
                    series.identity, level, now, last, since, judged.direction, judged.reason, judged.factor,
                    level=series.nights[begin].name, named=series.names_since(since),
                    settings=series.other_settings(last, since),
                )
            )  # fmt: skip
            undecided = judged.direction is Direction.CHANGED and series.identity.kind is FigureKind.ERROR
            told, begin = (now, begin) if undecided else (None, k)
        known = known if series.figures[begin].missing else begin
    return tuple(found)


ROUNDING_PARTS = frozenset({"blas", "variables", MACHINE})
"""Parts that decide how numbers are rounded, and nothing else"""
ROUNDING_LEVEL = 30.0
"""Errors below so many shares of rounding are rounding themselves: the share is an estimate of its size, not a bound"""
OTHER_ROUNDING = "an error at the level of rounding, and only parts that round in another way differ"


def last_of_level(series: FigureSeries, level: Figure, k: int) -> int:
    """Place of the last night before a night that has a result of a level; results may be missing since then."""
    return next((j for j in reversed(range(k)) if level.missing or not series.figures[j].missing), k - 1)


def against_level(series: FigureSeries, level: Figure, before: int, k: int) -> Judgement | None:
    """Judge the figure of a night against its level, which a night before had last.

    An error at the level of its rounding is no worse or better where of the parts that it depends on only such differ
    that round in another way, and its setting is the same.
    """
    now = series.figures[k]
    judged = compared(level, now)
    if judged is None or judged.direction is Direction.SAME or now.identity.kind is not FigureKind.ERROR:
        return judged
    rounding = (level.tolerance or 0.0) + (now.tolerance or 0.0)
    if level.value is None or now.value is None or max(level.value, now.value) > ROUNDING_LEVEL * rounding:
        return judged
    last, since = series.nights[before], series.nights[k]
    names = {suspect.name for suspect in differing(last, since, now.depends)}
    if not names or not names <= ROUNDING_PARTS or series.other_settings(last.name, since.name):
        return judged
    return replace(judged, direction=Direction.CHANGED, reason=f"{OTHER_ROUNDING}; {judged.reason}")


def is_told(told: Figure | None, now: Figure) -> bool:
    """Whether a difference from the level was told before, as neither better nor worse, and nothing moved since.

    The level stays where it is then, so that small differences add up.
    """
    moved = None if told is None else compared(told, now)
    return told is not None and (moved is None or moved.direction is Direction.SAME)


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
    words = judged.direction, judged.reason, judged.factor
    return (Change(series.identity, was, now, last, since, *words, named=series.names_since(since)),)
