"""Judgement of a stored night, and changes by their names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from barchain.nightly.history.acceptances import NO_ACCEPTANCE, accepting, fits
from barchain.nightly.history.changes.judging import comparable, judge_night, same_class
from barchain.nightly.history.changes.model import Direction
from barchain.nightly.history.changes.standing import still_holding
from barchain.nightly.history.changes.times import FALSE_ALARMS, WINDOW
from barchain.nightly.history.changes.vanished import Subject, subject_of
from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.model.figures import STEPPED, FigureKind
from barchain.nightly.history.told import comparable_nights, steps_before, told_by
from barchain.nightly.run_facts import PartState, scene_name
from scenarios.nearest import nearest

if TYPE_CHECKING:
    import datetime
    from collections.abc import Iterable, Sequence

    from barchain.nightly.history.acceptances import Acceptance
    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.changes.model import Change
    from barchain.nightly.history.model.figures import FigureIdentity
    from barchain.nightly.history.model.series_model import NightSummary
    from barchain.nightly.history.store import NightStore
    from barchain.nightly.history.table import FigureTable
    from barchain.nightly.run_facts import NightRun, PartResult

STUDY_OF_COMMAND = {"compare": "comparison"}
"""Studies whose command has another name"""


def judge(store: NightStore, name: str = "latest", *, false_alarms: float = FALSE_ALARMS) -> JudgedNight:
    """Judge a night against the earlier ones.

    Parameters
    ----------
    store : NightStore
    name : str
        Of the night.
    false_alarms : float

    Raises
    ------
    UnknownNightError
        If there is no such night.
    """
    chosen, told = store.summary(name), told_by(store)
    before = comparable_nights(store.nights(), chosen, told)
    if chosen.void is not None:
        return judge_night((), before, false_alarms)
    before, table = comparable(before), store.table()
    stepped = same_class(before)[-WINDOW:]
    settled = [kind for kind in FigureKind if kind not in STEPPED]
    series = (
        *table.levels(before, settled),
        *table.series_at(table.rows(stepped, STEPPED)),
        *table.gone(before, stepped, STEPPED),
    )
    presence = StoredPresence(table, before)
    return judge_night(series, before, false_alarms, presence, steps_before(told, chosen.name))


@dataclass(frozen=True)
class StoredPresence:
    """Nights of a history on which scenes and figures were measured."""

    table: FigureTable
    nights: Sequence[NightSummary]

    def of_figure(self, identity: FigureIdentity) -> frozenset[str]:
        """Nights that have a figure."""
        return self.nights_with([self.numbers[identity]] if identity in self.numbers else [])

    def of_subject(self, subject: Subject) -> frozenset[str]:
        """Nights on which a scene was done to its end by a study."""
        if subject not in self.known:
            study, scene, _ = subject
            whole = self.nights_with(self.members.get(subject, ()))
            self.known[subject] = frozenset(night for night in whole if self.was_done(night, study, scene))
        return self.known[subject]

    def nights_with(self, series: Sequence[int]) -> frozenset[str]:
        """Nights that have one of some series."""
        rows = self.table.rows(self.table.nights, series=series)
        return frozenset(self.table.nights[k].name for k in set(self.table.night[rows].tolist()))

    def was_done(self, night: str, study: str, scene: str) -> bool:
        """Whether a night did a scene with all engines; an incomplete one tells what it left."""
        left = self.left.get(night)
        if left is None:
            return night in self.complete
        return not {(study, scene), (study, "")} & left

    @cached_property
    def known(self) -> dict[Subject, frozenset[str]]:
        """Answers so far."""
        return {}

    @cached_property
    def complete(self) -> frozenset[str]:
        """Names of the complete nights."""
        return frozenset(night.name for night in self.nights if night.complete)

    @cached_property
    def left(self) -> dict[str, frozenset[tuple[str, str]]]:
        """Studies and scenes that each night left; of nights that know it."""
        return {night.name: left_of(night.run) for night in self.table.nights if night.run is not None}

    @cached_property
    def numbers(self) -> dict[FigureIdentity, int]:
        """Numbers of all series."""
        return {identity: k for k, identity in enumerate(self.table.identities)}

    @cached_property
    def members(self) -> dict[Subject, list[int]]:
        """Numbers of the series of each subject."""
        found: dict[Subject, list[int]] = {}
        for identity, number in self.numbers.items():
            found.setdefault(subject_of(identity), []).append(number)
        return found


def left_of(run: NightRun) -> frozenset[tuple[str, str]]:
    """Studies and scenes that a night did not do; an empty scene where it is not known which."""
    return frozenset(pair for part in run.parts if part.state is not PartState.DONE for pair in left_of_part(part))


def left_of_part(part: PartResult) -> Iterable[tuple[str, str]]:
    """Study and scenes that a part left; without a command nothing of the part was run."""
    for word in part.command.split()[1:2]:
        study = STUDY_OF_COMMAND.get(word, word)
        known = part.state is PartState.LEFT and part.left and part.left != (part.name,)
        yield from ((study, scene_name(scene)) for scene in part.left) if known else ((study, ""),)


def change_named(judged: JudgedNight, name: str) -> Change:
    """Change by its id, or by the name of its figure, of which the last one counts.

    Raises
    ------
    HistoryError
        If there is none; the message gives the nearest name.
    """
    known: dict[str, Change] = {}
    for change in sorted(judged.changes, key=lambda c: c.since):
        known[change.identity.name] = known[change.id] = change
    if name not in known:
        there = f"{len(judged.changes)} changes are there" if known else "there are none"
        raise HistoryError(f"{name[:80]}: no such change{nearest(name, known)}; {there} up to {judged.night.name}")
    return known[name]


def changes_named(judged: JudgedNight, name: str) -> list[Change]:
    """Change of an id, or the last change of each figure of a name, or that fits a pattern with ``*``.

    Raises
    ------
    HistoryError
        If there is none.
    """
    every = acceptable(judged)
    named = [change for change in every if change.identity.name == name]
    if named or "*" not in name:
        return named or event_of(change_named(judged, name), judged.changes)
    fitting = [change for change in every if fits(change.identity.name, name)]
    if not fitting:
        refused = any(fits(change.identity.name, name) for change in judged.changes)
        changed = len({change.identity for change in judged.changes})
        fault = NO_ACCEPTANCE if refused else f"fits none of {changed} changed figures up to {judged.night.name}"
        raise HistoryError(f"{name[:80]}: {fault}")
    return fitting


def event_of(change: Change, every: Sequence[Change]) -> list[Change]:
    """Change with the figures that are missing since the same run: they are told, and accepted, as one event."""
    if change.irreproducible:
        return [change]
    i = change.identity
    place = (i.scene, i.engine, change.since)
    return [change, *(c for c in every if c.now.missing and c is not change
                      and (c.identity.scene, c.identity.engine, c.since) == place)]  # fmt: skip


def acceptable(judged: JudgedNight) -> list[Change]:
    """Changes that a name or a pattern accepts: those that hold, new steps, and the last ones of all other figures."""
    steps = [change for change in judged.tonight if change.identity.kind in STEPPED]
    found = [*still_holding(judged), *steps]  # not a recovery in part after a change that holds
    last = {change.identity: change for change in sorted(judged.changes, key=lambda c: c.since)}
    taken = {change.identity for change in found}
    found += [change for identity, change in last.items() if identity not in taken]
    return [change for change in found if not change.irreproducible]


def irreproducible(judged: JudgedNight, names: Sequence[str]) -> int:
    """Number of tonight's runs that are not reproducible and fit a pattern: an acceptance leaves them out."""
    wild = [change for change in judged.tonight if change.irreproducible]
    return sum(any("*" in name and fits(change.identity.name, name) for name in names) for change in wild)


def worse_and_not_accepted(judged: JudgedNight, known: Sequence[Acceptance], at: datetime.datetime) -> list[Change]:
    """Changes for the worse that a night tells first and that no acceptance covers."""
    return [c for c in judged.tonight if c.direction is Direction.WORSE and accepting(c, known, at) is None]
