"""What each night told: numbers for the calendar, and changes, which later nights hold on to."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import sqlalchemy as sa

from barchain.nightly.history.changes.model import Direction, ToldChange
from barchain.nightly.history.model.figures import STEPPED
from barchain.nightly.history.model.identity import content_digest
from barchain.nightly.history.storage.connection import told, writing
from barchain.nightly.history.storage.tables import judgements, nights, series, told_changes
from barchain.nightly.history.storage.vocabulary import identity_of, insert_new, pieces

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from sqlalchemy import Connection

    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.model.figures import FigureIdentity
    from barchain.nightly.history.store import NightStore


def keep_judgement(store: NightStore, judged: JudgedNight, accepted: Collection[str] = ()) -> None:
    """Keep which changes a night told; an earlier judgement of the night is replaced.

    Parameters
    ----------
    store : NightStore
    judged : JudgedNight
    accepted : collection of str
        Ids of its changes that are accepted.
    """
    night = judged.night
    worse = sum(change.direction is Direction.WORSE for change in judged.tonight)
    row = {"worse": worse, "changes": len(judged.tonight), "judged": judged.judged, "night_id": night.number}
    changes = [
        {
            "night": night.name, "change": c.id, "figure": content_digest(c.identity), "since": c.since,
            "direction": str(c.direction), "accepted": c.id in accepted,
        }
        for c in judged.tonight
    ]  # fmt: skip
    with told(store.given), writing(store.engine) as connection:
        connection.execute(sa.delete(judgements).where(judgements.c.night_id == night.number))
        connection.execute(sa.insert(judgements), [row])
        connection.execute(sa.delete(told_changes).where(told_changes.c.night == night.name))
        insert_new(connection, told_changes, changes)


def note_accepted(connection: Connection, changes: Sequence[str]) -> None:
    """Note that changes of some ids are accepted, on the nights that told them."""
    for some in pieces(changes):
        connection.execute(sa.update(told_changes).where(told_changes.c.change.in_(some)).values(accepted=True))


def kept_judgements(store: NightStore) -> dict[str, tuple[int, int]]:
    """Numbers of changes for the worse, accepted ones left out, and of all changes, by the night that told them."""
    forgiven = (
        sa.select(told_changes.c.night, sa.func.count().label("many"))
        .where(told_changes.c.accepted, told_changes.c.direction == str(Direction.WORSE))
        .group_by(told_changes.c.night)
        .subquery()
    )
    query = (
        sa.select(nights.c.name, judgements.c.worse, judgements.c.changes, forgiven.c.many)
        .join(judgements, judgements.c.night_id == nights.c.id)
        .outerjoin(forgiven, forgiven.c.night == nights.c.name)
    )
    with told(store.given), store.engine.connect() as connection:
        rows = connection.execute(query).all()
    return {row.name: (row.worse - (row.many or 0), row.changes) for row in rows}


def told_steps(store: NightStore, before: str) -> dict[FigureIdentity, list[ToldChange]]:
    """Steps of times and memory that were told on the nights before one, by figure, in the order of the nights."""
    query = (
        sa.select(told_changes.c.since, told_changes.c.direction, series)
        .join(series, series.c.digest == told_changes.c.figure)
        .where(told_changes.c.night < before, series.c.kind.in_(sorted(map(str, STEPPED))))
        .order_by(told_changes.c.night)
    )
    found: dict[FigureIdentity, list[ToldChange]] = defaultdict(list)
    with told(store.given), store.engine.connect() as connection:
        for row in connection.execute(query):
            found[identity_of(row)].append(ToldChange(row.since, Direction(row.direction)))
    return found
