"""What is worse than accepted: figures above their levels, with acceptances as an overlay."""

from __future__ import annotations

import dataclasses
import datetime
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.nightly.figures.changes import Change, Direction, compared, differs, is_above, judge_number
from barchain.nightly.figures.figure import FigureKind, names_since
from barchain.nightly.figures.steps import LEAST_EFFECT
from barchain.nightly.history.acceptances import accepting, holding

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from barchain.nightly.figures.figure import Figure, FigureIdentity
    from barchain.nightly.history.acceptances import Acceptance
    from barchain.nightly.history.levels import JudgedNight, Level, Step


ELSEWHERE = 1.5
"""Largest increase by one cause over that beside another one: ×1.202 there was ×1.21 alone in a program's figures"""


@dataclass(frozen=True)
class Standing:
    """State of a figure that is worse than it was."""

    change: Change
    """From what the figure may be to what it is; since the first step that nobody accepted, or else the first one"""
    acceptance: Acceptance | None = None
    """What covers the state; None of a state that is worse than accepted"""
    newest: Change | None = None
    """Its latest step, of a state of several: another part may have made it"""

    @property
    def latest(self) -> str:
        """Night of the latest step."""
        return self.change.through or self.change.since


def standing(
    judged: JudgedNight, known: Iterable[Acceptance] = (), at: datetime.datetime | None = None
) -> list[Standing]:
    """States that are worse than they were on a judged night, those that its own news lead to among them.

    Parameters
    ----------
    judged : JudgedNight
    known : iterable of Acceptance
    at : datetime, optional
        Instant of which the acceptances count; default: now.
    """
    instant, known = at or datetime.datetime.now(datetime.UTC), list(known)
    own = holding(known, instant)
    found = [standing_of(row, own) for row in judged.above.values()]
    slower = [Standing(change, accepting(change, known, instant)) for change in slow_downs(judged.stepped)]
    return sorted([*found, *slower], key=lambda state: (state.change.since, state.change.identity))


def in_force(latest: Sequence[JudgedNight], known: Iterable[Acceptance], at: datetime.datetime) -> list[Acceptance]:
    """Acceptances that cover a step at an instant: their date has not passed, and no figure came back to its level.

    Parameters
    ----------
    latest : sequence of JudgedNight
        The last night of each machine class.
    known : iterable of Acceptance
    at : datetime
    """
    steps = [
        (step.night, tuple(name.name for name in names_since(step.night, row.told.identity, row.earlier)))
        for judged in latest for row in judged.above.values() for step in row.steps
    ]  # fmt: skip
    steps += [(change.since, change.names) for judged in latest for change in (*judged.news, *judged.stepped)]
    return [one for one in holding(known, at) if any(one.reaches(night, night, names) for night, names in steps)]


def still_holding(judged: JudgedNight) -> list[Change]:
    """States that are worse than they were on earlier nights, whether accepted or not."""
    tonight = {change.id for change in judged.tonight}
    return [state.change for state in standing(judged) if state.change.id not in tonight]


def every_change(judged: JudgedNight) -> list[Change]:
    """Changes that a night tells or that hold on it, those that are not reproducible first."""
    found = {change.id: change for change in (*judged.tonight, *still_holding(judged), *judged.stepped)}
    return sorted(found.values(), key=lambda change: (not change.irreproducible, change.since))


def standing_of(row: Level, known: Sequence[Acceptance]) -> Standing:
    """State of a figure above its level; `known` are acceptances that have not ended, the latest one last.

    An acceptance of a step raises what the figure may be to the value of that step, if no earlier step is open; one
    that reaches back to the open step accepts both. One of a step beside an open one raises it by that factor alone. A
    figure that becomes better afterwards may be no worse again. That its absence is accepted accepts no step before it.
    """
    found = state_of(row, known)
    if row.told.missing and found.acceptance is not None:
        before = state_of(row._replace(told=row.last), known)
        return before if before.acceptance is None else found
    return found


def state_of(row: Level, known: Sequence[Acceptance]) -> Standing:
    """State of a figure by the steps that lead to what it is now."""
    allowed, before, result = row.level, row.level, row.level  # what it may be, what it was; the last that is there
    most = row.level  # what it may be at most: the same, and more beside an accepted step
    opened: list[Step] = []  # steps for the worse that nobody accepted
    covering, steps = None, steps_of_now(row)
    beside: list[str] = []  # accepted steps that raised what it may be
    for step in steps:
        if allowed.missing and not step.now.missing:
            allowed = most = result
        names = [i.name for i in names_since(step.night, row.told.identity, row.earlier)]
        since = opened[0].night if opened else step.night
        whole, alone = ([one for one in known if one.reaches(step.night, n, names)] for n in (since, step.night))
        if whole:
            covering = whole[-1]
            beside = [accepted_words(step, covering)] if opened or is_above(before, step.now) else beside
            allowed, most, opened = step.now, step.now, []
        elif alone:
            covering = alone[-1]
            allowed, most = raised(allowed, before, step.now), raised(most, before, step.now, ELSEWHERE)
            beside += [accepted_words(step, covering)] if is_above(before, step.now) else []
            opened = opened if is_above(most, step.now) else []
        elif not differs(most, step.now, Direction.WORSE):
            allowed, most = (allowed, most) if opened else (step.now, step.now)
            opened = []
        elif not opened or is_above(before, step.now):
            opened.append(step)
        before, result = step.now, (result if allowed.missing else allowed)
    if not opened and is_above(most, row.told):
        opened = [steps[-1]]
    if opened or covering is None:
        more = f" with the accepted step of {' and of '.join(beside)}" if beside else ""
        own, was, earlier, covering = opened or steps, allowed, f"what it may be{more}", None
    else:
        own, was, earlier = steps, row.level, ""
    newest = change_since(row, was, own[-1:]) if len(own) > 1 else None
    return Standing(change_since(row, was, own, earlier), covering, newest)


def steps_of_now(row: Level) -> Sequence[Step]:
    """Steps that lead to what a figure is now.

    Of a missing one those since it is missing, of a result that is there those of results: what made a figure vanish
    did not make it larger.
    """
    there = [step for step in row.steps if not step.now.missing]
    if not row.told.missing:
        return there or row.steps
    return row.steps[row.steps.index(there[-1]) + 1 :] if there else row.steps


def accepted_words(step: Step, acceptance: Acceptance) -> str:
    """Day of an accepted step, with who accepted it and why."""
    return f"{step.night[:10]} ({acceptance.who}: {acceptance.reason})"


def raised(allowed: Figure, was: Figure, now: Figure, share: float = 1.0) -> Figure:
    """What an error may be with a step that is accepted while an earlier one is not: larger by the accepted factor.

    Errors of two causes neither add nor multiply exactly: once the other cause is gone, a `share` of what was accepted
    may stay, of an accepted ×1.2 beside an open ×5 at most ×1.3.
    """
    if allowed.identity.kind is not FigureKind.ERROR or not (allowed.value and was.value and now.value):
        return allowed
    more = max(now.value / was.value - 1.0, 0.0)
    return dataclasses.replace(allowed, value=allowed.value * (1.0 + share * more))


def change_since(row: Level, was: Figure, steps: Sequence[Step], earlier: str = "") -> Change:
    """Change of some steps, as far as it holds; `earlier` names what an error is compared with."""
    first, identity, judged = steps[0], row.told.identity, compared(was, row.told)
    if earlier and identity.kind is FigureKind.ERROR and not (was.missing or row.told.missing):
        judged = judge_number(was, row.told, earlier)
    reason = judged.reason if judged is not None else "as it was accepted"
    if first.last == first.night:
        reason = f"{row.told.word} from the first night on: {row.told.reason}"
    return Change(
        identity, was, first.now, first.last, first.night, Direction.WORSE, reason,
        judged.factor if judged is not None else None,
        latest=row.told, through=steps[-1].night if len(steps) > 1 else "", steps=len(steps),
        named=names_since(first.night, identity, row.earlier), settings=first.settings,
    )  # fmt: skip


def slow_downs(stepped: Iterable[Change]) -> list[Change]:
    """Steps of times and memory for the worse that later steps have not taken back.

    Steps multiply: a slow-down holds until later ones have taken it back, up to half the least effect. One without
    later steps holds as long as it is there.
    """
    own: dict[FigureIdentity, list[Change]] = {}
    for change in sorted(stepped, key=lambda c: c.since):
        own.setdefault(change.identity, []).append(change)
    found = []
    for changes in own.values():
        for k, change in enumerate(changes):
            factor = math.prod(c.factor for c in changes[k:] if c.factor is not None)
            holds = len(changes) == k + 1 or factor >= 1.0 + LEAST_EFFECT / 2.0
            found += [change] if change.direction is Direction.WORSE and holds else []
    return found
