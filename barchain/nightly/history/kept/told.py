"""Changes that each night told, which later nights hold on to, and their numbers for the calendar."""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from barchain.nightly.history.changes.model import Direction, ToldChange
from barchain.nightly.history.model.figures import STEPPED
from barchain.nightly.history.storage.connection import told, writing
from barchain.nightly.history.storage.tables import acceptances, judgements, nights, told_changes
from barchain.nightly.history.storage.vocabulary import insert_new

if TYPE_CHECKING:
    import datetime
    from collections.abc import Iterator

    from sqlalchemy import Connection

    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.changes.model import Change
    from barchain.nightly.history.store import NightStore

STEPS = sorted(map(str, STEPPED))
"""Kinds of figures that change by steps"""


def keep_judgement(store: NightStore, judged: JudgedNight) -> None:
    """Keep which changes a night told; an earlier judgement of the night is replaced.

    A step that no night recorded, because the night that told it was not judged here, is recorded with this one: later
    nights hold on to it, too. Once later nights have told changes, the steps of a night stay as they were recorded.
    """
    night = judged.night
    worse = sum(change.direction is Direction.WORSE for change in judged.tonight)
    row = {"worse": worse, "changes": len(judged.tonight), "judged": judged.judged, "night_id": night.number}
    known = {(figure, one) for figure, own in told_steps(store, night.name).items() for one in own}
    tonight = {change.id for change in judged.tonight}
    unrecorded = {c.id for c in judged.changes if is_step(c) and (c.identity.name, told_change(c)) not in known}
    kept = [c for c in judged.changes if c.id in tonight | unrecorded]
    with told(store.given), writing(store.engine) as connection:
        connection.execute(sa.delete(judgements).where(judgements.c.night_id == night.number))
        connection.execute(sa.insert(judgements), [row])
        later = connection.execute(sa.select(told_changes.c.night).where(told_changes.c.night > night.name)).first()
        replaced = sa.delete(told_changes).where(told_changes.c.night == night.name)
        connection.execute(replaced.where(told_changes.c.kind.not_in(STEPS)) if later else replaced)
        rows = [told_row(night.name, c, c.id in tonight) for c in kept if not (later and is_step(c))]
        insert_new(connection, told_changes, rows)


def is_step(change: Change) -> bool:
    """Whether a change is a step of times or memory."""
    return change.identity.kind in STEPPED and not change.now.missing


def told_change(change: Change) -> ToldChange:
    """Change as later nights know it."""
    return ToldChange(change.since, change.direction)


def told_row(night: str, change: Change, tonight: bool) -> dict[str, Any]:
    """Row of a change that a night told."""
    return {
        "night": night, "change": change.id, "figure": change.identity.name, "kind": str(change.identity.kind),
        "since": change.since, "direction": str(change.direction), "tonight": tonight,
    }  # fmt: skip


def kept_judgements(store: NightStore, at: datetime.datetime) -> dict[str, tuple[int, int]]:
    """Numbers of changes for the worse and of all changes, by the name of the night that told them.

    Changes for the worse that somebody accepted are left out, unless the acceptance ended before `at`.
    """
    query = sa.select(nights.c.name, judgements.c.worse, judgements.c.changes).join(
        judgements, judgements.c.night_id == nights.c.id
    )
    with told(store.given), store.engine.connect() as connection:
        rows, forgiven = connection.execute(query).all(), Counter(forgiven_nights(connection, at))
    return {row.name: (row.worse - forgiven[row.name], row.changes) for row in rows}


def forgiven_nights(connection: Connection, at: datetime.datetime) -> Iterator[str]:
    """Names of the nights that told changes for the worse, once for each that is accepted at an instant."""
    query = (
        sa.select(told_changes.c.night, told_changes.c.change)
        .join(
            acceptances,
            sa.and_(acceptances.c.series == told_changes.c.figure, acceptances.c.since == told_changes.c.since),
        )
        .where(told_changes.c.tonight, told_changes.c.direction == str(Direction.WORSE))
        .where(sa.or_(acceptances.c.until.is_(None), acceptances.c.until > at))
        .distinct()
    )
    for row in connection.execute(query):
        yield row.night


def told_steps(store: NightStore, before: str) -> dict[str, list[ToldChange]]:
    """Steps of times and memory that were told on the nights before one, by name of the figure, in order of nights."""
    query = (
        sa.select(told_changes.c.figure, told_changes.c.since, told_changes.c.direction)
        .where(told_changes.c.night < before, told_changes.c.kind.in_(STEPS))
        .order_by(told_changes.c.night)
    )
    found: dict[str, list[ToldChange]] = defaultdict(list)
    with told(store.given), store.engine.connect() as connection:
        for row in connection.execute(query):
            found[row.figure].append(ToldChange(row.since, Direction(row.direction)))
    return found
