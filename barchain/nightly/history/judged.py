"""Judgement of a stored night, and the acceptances beside it."""

from __future__ import annotations

import datetime
import fnmatch
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from barchain.nightly.history.changes.accepted import Acceptance, acceptance_of, accepting
from barchain.nightly.history.changes.judging import comparable, judge_night, same_class
from barchain.nightly.history.changes.model import Direction
from barchain.nightly.history.changes.standing import still_holding
from barchain.nightly.history.changes.times import FALSE_ALARMS, WINDOW
from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.kept.told import told_steps
from barchain.nightly.history.model.figures import STEPPED, FigureKind
from barchain.nightly.history.presence import StoredPresence
from barchain.nightly.history.series import load
from barchain.nightly.history.sparse import load_gone, load_levels
from barchain.nightly.history.storage.connection import told, writing
from barchain.nightly.history.storage.tables import acceptances
from barchain.nightly.history.storage.vocabulary import insert_new
from scenarios.nearest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.changes.model import Change
    from barchain.nightly.history.store import NightStore

NO_ACCEPTANCE = "a run that is not reproducible can't be accepted"
COLUMNS = ("figure", "was", "became", "value", "word", "since", "who", "accepted", "reason", "until")


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
    chosen, every = store.summary(name), store.nights()
    before = list(every[: [night.number for night in every].index(chosen.number) + 1])
    if chosen.void is not None:
        return judge_night((), before, false_alarms)
    before = comparable(before)
    stepped = same_class(before)[-WINDOW:]
    settled = [kind for kind in FigureKind if kind not in STEPPED]
    series = (
        *load_levels(store, before, settled),
        *load(store, stepped, kinds=STEPPED),
        *load_gone(store, before, stepped, STEPPED),
    )
    return judge_night(series, before, false_alarms, StoredPresence(store, before), told_steps(store, chosen.name))


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
        return named or [change_named(judged, name)]
    fitting = [change for change in every if fits(change, name)]
    if not fitting:
        refused = any(fits(change, name) for change in judged.changes)
        changed = len({change.identity for change in judged.changes})
        fault = NO_ACCEPTANCE if refused else f"fits none of {changed} changed figures up to {judged.night.name}"
        raise HistoryError(f"{name[:80]}: {fault}")
    return fitting


def acceptable(judged: JudgedNight) -> list[Change]:
    """Changes that a name or a pattern accepts: those that hold, new steps, and the last ones of all other figures."""
    steps = [change for change in judged.tonight if change.identity.kind in STEPPED]
    found = [*still_holding(judged), *steps]  # not a recovery in part after a change that holds
    last = {change.identity: change for change in sorted(judged.changes, key=lambda c: c.since)}
    taken = {change.identity for change in found}
    found += [change for identity, change in last.items() if identity not in taken]
    return [change for change in found if not change.irreproducible]


def fits(change: Change, pattern: str) -> bool:
    """Whether the name of a change's figure fits a pattern, in which * stands for any text."""
    return fnmatch.fnmatchcase(change.identity.name, pattern.replace("[", "[[]"))


def irreproducible(judged: JudgedNight, names: Sequence[str]) -> int:
    """Number of tonight's runs that are not reproducible and fit a pattern: an acceptance leaves them out."""
    wild = [change for change in judged.tonight if change.irreproducible]
    return sum(any("*" in name and fits(change, name) for name in names) for change in wild)


def accept(
    store: NightStore, changes: Sequence[Change], who: str, reason: str, until: datetime.datetime | None = None
) -> list[Acceptance]:
    """Store that somebody accepts some changes: all of them, or none.

    Raises
    ------
    HistoryError
        If a change is that a run is not reproducible, or the end has passed already.
    """
    now = datetime.datetime.now(datetime.UTC)
    refused = next((change for change in changes if change.irreproducible), None)
    if refused is not None:
        raise HistoryError(f"{refused.identity.name}: {NO_ACCEPTANCE}; nothing was accepted")
    if until is not None and until <= now:
        raise HistoryError(f"--until {until.date()}: has passed; allowed: a later date")
    made = [acceptance_of(change, who, now, reason, until) for change in changes]
    with told(store.given), writing(store.engine) as connection:
        insert_new(connection, acceptances, [acceptance_row(one) for one in made])
    return made


def acceptance_row(made: Acceptance) -> dict[str, Any]:
    """Row of an acceptance."""
    row = {column: getattr(made, column) for column in COLUMNS} | {"digest": made.digest}
    row["series"] = row.pop("figure")
    return row


def accepted(store: NightStore) -> tuple[Acceptance, ...]:
    """All acceptances, in the order in which they were given."""
    with told(store.given), store.engine.connect() as connection:
        rows = connection.execute(sa.select(acceptances).order_by(acceptances.c.accepted, acceptances.c.id)).all()
    return tuple(
        Acceptance(r.series, r.was, r.became, r.value, r.word, r.since, r.who, r.accepted, r.reason, r.until)
        for r in rows
    )


def worse_and_not_accepted(judged: JudgedNight, known: Sequence[Acceptance], at: datetime.datetime) -> list[Change]:
    """Changes for the worse that a night tells first and that no acceptance covers."""
    return [c for c in judged.tonight if c.direction is Direction.WORSE and accepting(c, known, at) is None]
