"""Levels after a night, from those before it: one step of the fold over nights."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from barchain.nightly.figures.changes import (
    COMPARED,
    NOT_REPRODUCIBLE,
    OTHER_PARTS,
    OTHER_STUDIES,
    PATIENCE,
    RIGHT,
    UNKNOWN_PARTS,
    VERDICT,
    WRONG,
    Change,
    Direction,
    compared,
    differs,
    is_above,
    is_better,
    parts_digest,
    worst,
)
from barchain.nightly.figures.figure import STEPPED, Figure, FigureKind, names_since
from barchain.nightly.history.levels import FoldedNight, Level, LevelOf, LevelTable, Step, StepOf
from barchain.nightly.history.renames import SCENE, carried_on
from reports.results.comparison import COMPARISON
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from barchain.nightly.figures.changes import Judgement
    from barchain.nightly.figures.figure import FigureIdentity, NightSummary


FOLLOWED_AFTER = 3
"""Nights in a row after which an improvement is the level, as the worst of them. Followed at once, an error of rounding
was red on 8 of 12 nights, and a single zero was followed by a regression by a factor of 434"""
STATES_KEPT = 8
"""States of the parts of a trajectory whose digests are kept"""
OCCASIONS = 2
"""Occasions in a row that must have a figure: some figures are measured only now and then"""
SAMPLED = ("stability.", "selftest.", "campaign.")
"""Beginnings of the quantities of studies of which a night does a part only: scenes, or faults, of that night. Nights
of 0.7 have campaigns, of random scenes"""
Subject = tuple[str, str, str]
"""Study, scene and fault of a figure: what is done as a whole"""


@dataclass(frozen=True)
class Tonight:
    """A night whose figures are followed."""

    night: NightSummary
    here: Mapping[FigureIdentity, Figure]
    contents: Mapping[str, str]
    """Digests of scenes by name"""
    verdicts: Mapping[tuple[str, str], str]
    """Verdicts of the comparison, by scene and engine"""
    settings: Mapping[tuple[str, str], tuple[str, str]]
    """Old and new setting of engines that have another one since tonight, by scene and engine"""

    @cached_property
    def done(self) -> frozenset[Subject]:
        """Scenes that a study did to their end, with all engines.

        The night left nothing of the scene; one without a run of a plan is complete.
        """
        subjects = frozenset(map(subject_of, self.here))
        if self.night.run is None:
            return subjects if self.night.complete else frozenset()
        left = self.night.run.left
        return frozenset(s for s in subjects if not {s[:2], (s[0], "")} & left)

    @cached_property
    def not_run(self) -> frozenset[tuple[str, ...]]:
        """Studies, scenes, engines and settings of runs that had no time."""
        return frozenset(run_key(identity) for identity, figure in self.here.items() if figure.not_run)

    def verdict_on(self, identity: FigureIdentity) -> str:
        """Verdict on the run of a comparison's error; empty for all other figures."""
        if identity.kind is not FigureKind.ERROR or study_of(identity) != COMPARISON:
            return ""
        return self.verdicts.get((identity.scene, identity.engine), "")

    def change(self, row: Level, was: Figure, now: Figure, judgement: Judgement, last: str = "") -> Change:
        """Change of a figure that this night tells."""
        identity = now.identity
        if was.missing and row.steps:  # what brings it back differs from the night on which it was gone
            last = last or row.steps[-1].night
        return Change(
            identity, was, now, last or row.last_night, self.night.name, judgement.direction, judgement.reason,
            judgement.factor, irreproducible=judgement.irreproducible,
            named=names_since(self.night.name, row.told.identity, row.earlier),
            settings=self.settings.get((identity.scene, identity.engine), ()),
        )  # fmt: skip


def study_of(identity: FigureIdentity) -> str:
    """Study that a figure is of."""
    first = identity.quantity.partition(".")[0]
    return first if first in OTHER_STUDIES else COMPARISON


def subject_of(identity: FigureIdentity) -> Subject:
    """Study, scene and fault of a figure."""
    study = study_of(identity)
    return study, identity.scene, identity.setting if study in {"selftest", "campaign"} else ""


def run_key(identity: FigureIdentity) -> tuple[str, ...]:
    """Study, scene, engine and setting of a figure: a run that had no time lacks all of its figures."""
    return study_of(identity), identity.scene, identity.engine, identity.setting


def advance(
    before: LevelTable, night: NightSummary, figures: Iterable[Figure], *, late: bool = False,
    occasions: int = OCCASIONS,
) -> FoldedNight:  # fmt: skip
    """Levels after a night.

    Parameters
    ----------
    before : LevelTable
        Levels before the night.
    night : NightSummary
    figures : iterable of Figure
        Of the night.
    late : bool
        Whether a later night was told before this one was there: it begins the levels of figures that had none, and
        changes nothing else, so that what was told stays true.
    occasions : int
        Occasions in a row that must have a figure, so that it is told when it is gone.
    """
    here = {figure.identity: figure for figure in figures}
    contents = {part.name.removeprefix(SCENE): part.digest for part in night.parts if part.name.startswith(SCENE)}
    renames = carried_on({} if late else before.rows, here, contents)
    verdicts = {(i.scene, i.engine): figure.word for i, figure in here.items() if i.quantity == VERDICT}
    tonight = Tonight(night, here, contents, verdicts, renames.settings)
    folded = (*before.folded, (night.name, night.digest, late))
    if late:
        begun = {i: begin(figure, tonight) for i, figure in here.items() if not figure.not_run}
        return FoldedNight(replace(before, folded=folded, rows=begun | dict(before.rows)))
    rows, news = renames.rows, list[Change]()
    judged = same = new = 0
    for identity, now in here.items():
        row = rows.get(identity)
        if row is None:
            if not now.not_run:
                rows[identity] = may_not_fail(begin(now, tonight))
            new += not identity.quantity.startswith(SAMPLED)
            continue
        judged += not now.not_run
        same += row.last is not now and identity.kind in COMPARED and differs(row.last, now, Direction.SAME)
        rows[identity], change = follow(row, now, tonight)
        news += [change] if change else []
    other_plan = [i for i, row in rows.items() if row.present == before.night and before.plan != night.plan]
    gone = lost(rows, tonight, occasions)
    news = sorted([*news, *gone], key=lambda change: (not change.irreproducible, change.identity))
    return FoldedNight(
        LevelTable(night.name, night.plan, folded, rows), tuple(news), judged + len(gone), same, new,
        sum(i not in here and not i.quantity.startswith(SAMPLED) for i in other_plan), renames.words,
    )  # fmt: skip


def begin(now: Figure, tonight: Tonight) -> Level:
    """State of a figure on its first night: its level is its value."""
    name, plan = tonight.night.name, tonight.night.plan
    row = LevelOf(
        now, name, tonight.verdict_on(now.identity) not in WRONG, now, now, name, name, plan=plan,
        content=tonight.contents.get(now.identity.scene, ""),
    )  # fmt: skip
    if now.identity.kind is FigureKind.BITS and not now.missing:
        row = row._replace(seen=seen_with(row, parts_digest(tonight.night, now), now.word, name))
    return counted(row, now, tonight)


def may_not_fail(row: Level) -> Level:
    """State of a figure's first night: a verdict that begins with a run that failed is worse than a pass."""
    if row.told.identity.quantity != VERDICT or row.told.word != Outcome.FAILED:
        return row
    passing = replace(row.told, word=str(Outcome.PASS), reason="")
    return row._replace(level=passing, steps=(StepOf(row.present, row.present, row.told),))


def follow(row: Level, now: Figure, tonight: Tonight) -> tuple[Level, Change | None]:
    """State of a figure after a night that has it, and its change if the night tells one."""
    if now.not_run and (row.left_out + 1 < PATIENCE or now.identity.kind not in COMPARED):
        return row._replace(left_out=row.left_out + 1, present=tonight.night.name), None
    if now.identity.kind is FigureKind.BITS:
        return follow_bits(row, now, tonight)
    if now.identity.kind in STEPPED:
        moved = {} if now.missing else {"told": now, "last": now, "steps": ()}
        return counted(row, now, tonight, **moved), None
    if now == row.told and now == row.last and not row.better and row.right:
        return counted(row, now, tonight), None  # most figures
    row, change = follow_result(row, now, tonight)
    return counted(row, now, tonight), change


def counted(row: Level, now: Figure, tonight: Tonight, **moved: Any) -> Level:
    """State with the occasions that had the figure, and perhaps with other changes."""
    night = tonight.night
    occasions, complete = (row.occasions, row.complete) if row.plan == night.plan else (0, 0)
    whole = subject_of(now.identity) in tonight.done
    return row._replace(
        last_night=row.last_night if now.missing else night.name, present=night.name, plan=night.plan,
        left_out=row.left_out + 1 if now.not_run else 0, content=tonight.contents.get(now.identity.scene, row.content),
        occasions=min(occasions + whole, OCCASIONS), complete=min(complete + night.complete, OCCASIONS), **moved,
    )  # fmt: skip


def follow_bits(row: Level, now: Figure, tonight: Tonight) -> tuple[Level, Change | None]:
    """State of a trajectory after a night.

    The same parts must give the same bits, whenever they did so last: another digest is an event of its night. Other
    parts may give other bits.
    """
    if now.missing:
        return counted(row, now, tonight), None
    state = parts_digest(tonight.night, now)
    known = next(((word, night) for own, word, night in row.seen if own == state), None) if state else None
    change = None
    if known is not None and known[0] != now.word:
        change = tonight.change(row, replace(now, word=known[0]), now, NOT_REPRODUCIBLE, known[1])
    elif not row.last.missing and row.last.word != now.word:
        change = tonight.change(row, row.last, now, OTHER_PARTS if state else UNKNOWN_PARTS)
    seen = seen_with(row, state, now.word, tonight.night.name)
    return counted(row, now, tonight, told=now, last=now, steps=(), seen=seen), change


def seen_with(row: Level, state: str, word: str, night: str) -> tuple[tuple[str, str, str], ...]:
    """States of a trajectory's parts, with one more."""
    if not state:
        return row.seen
    return (*(one for one in row.seen if one[0] != state), (state, word, night))[-STATES_KEPT:]


def follow_result(row: Level, now: Figure, tonight: Tonight) -> tuple[Level, Change | None]:
    """State of an error, a verdict, a count or a value after a night."""
    verdict = tonight.verdict_on(now.identity)
    mended = verdict in RIGHT and not row.right and not now.missing  # the level of a wrong result binds no right one
    above = not mended and is_above(row.level, now)
    was, judgement = news_of(row, now, above=above, mended=mended)
    change = None
    if judgement is not None and judgement.direction is not Direction.SAME:
        change = tonight.change(row, was, now, judgement)
    row = with_level(row, now, tonight, mended=mended, wrong=verdict in WRONG)
    steps = row.steps
    if not is_above(row.level, now):
        if change is not None and steps and not now.missing:
            change = replace(change, reason=f"back at its level; {change.reason}")
        steps = ()
    elif change is not None:
        steps = (*(steps or unseen_step(row, now)), StepOf(change.last, change.since, change.now, change.settings))
    told = now if change else row.told
    return row._replace(told=told, steps=steps, last=row.last if now.missing else now), change


def unseen_step(row: Level, now: Figure) -> tuple[Step, ...]:
    """Step of an error that moved among rounding errors before it counts, if that is more than it moves tonight.

    Nobody knows which of these moves are draws of rounding: they are one step since the level.
    """
    level, told, found = row.level.value, row.told.value, now.value
    if level is None or told is None or found is None or told**2 <= level * found:
        return ()
    return (StepOf(row.since, row.last_night, row.told),)


def news_of(row: Level, now: Figure, *, above: bool, mended: bool) -> tuple[Figure, Judgement | None]:
    """Earlier value that a result is compared with, and its judgement.

    A result that comes back after it was missing is compared with the last one, if it is worse. What is worse than it
    was told last, and no worse than the level, is neither better nor worse.
    """
    was, found = row.told, compared(row.told, now)
    if was.missing and not now.missing and not row.last.missing:
        back = compared(row.last, now)
        if back is not None and back.direction is Direction.WORSE:
            was, found = row.last, back
    if above and not row.steps and (found is None or found.direction is not Direction.WORSE):
        since_level = compared(row.level, now)
        assert since_level is not None  # it is above
        return row.level, replace(since_level, reason=f"small moves since its level add up: {since_level.reason}")
    if found is not None and found.direction is Direction.WORSE and not above:
        why = (
            "the verdict became right: the earlier value was that of a wrong result"
            if mended
            else "no worse than its level"
        )
        reason = f"{why}; {found.reason}"
        found = replace(found, direction=Direction.CHANGED, reason=reason)
    return was, found


def with_level(row: Level, now: Figure, tonight: Tonight, *, mended: bool, wrong: bool) -> Level:
    """State with the level that holds from a night on.

    The first right run replaces the level of a wrong one, its verdict that of the wrong one, and a wrong run lowers no
    level. An improvement becomes the level after some nights in a row, with the worst of them.
    """
    passes = now.identity.quantity == VERDICT and now.word in RIGHT and is_better(row.level, now)
    if mended or passes or (row.level.missing and not now.missing):
        return row._replace(level=now, since=tonight.night.name, right=not wrong, better=())
    if not is_better(row.level, now) or (wrong and row.right):
        return row._replace(better=())
    better = (*row.better, now)
    if len(better) < FOLLOWED_AFTER:
        return row._replace(better=better)
    return row._replace(level=worst(better), since=tonight.night.name, right=not wrong, better=())


def lost(rows: dict[FigureIdentity, Level], tonight: Tonight, occasions: int) -> list[Change]:
    """Figures that are gone since tonight: their states become missing.

    An occasion is a night of the same plan on which the figure's study did its scene to its end, or a complete one.
    A figure of a run that had no time is not gone.
    """
    night, found = tonight.night, []
    for identity in [identity for identity in rows if identity not in tonight.here]:
        row = rows[identity]
        if row.told.missing or row.plan != night.plan or run_key(identity) in tonight.not_run:
            continue
        whole = subject_of(identity) in tonight.done
        if not whole and (not night.complete or identity.quantity.startswith(SAMPLED)):
            continue
        if (row.occasions if whole else row.complete) < occasions:
            if row.complete or (whole and row.occasions):
                rows[identity] = row._replace(occasions=0 if whole else row.occasions, complete=0)
            continue
        reason = f"not measured, though each of the {occasions} nights before that did its scene had it"
        now = Figure(identity, reason=reason, depends=row.last.depends)
        judgement = compared(row.last, now)
        assert judgement is not None  # it is missing
        change = tonight.change(row, row.last, now, replace(judgement, reason=reason))
        step = StepOf(change.last, change.since, now, change.settings)
        rows[identity] = row._replace(told=now, steps=(*row.steps, step), occasions=0, complete=0)
        found.append(change)
    return found
