"""Attributions of changes by real runs, beside the nights in the store."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import sqlalchemy as sa

from barchain.nightly.history.model.checked_text import MOST_TEXT
from barchain.nightly.history.storage.connection import told, writing
from barchain.nightly.history.storage.tables import attributions

if TYPE_CHECKING:
    import datetime
    from collections.abc import Iterable

    from barchain.nightly.history.changes.model import Change
    from barchain.nightly.history.store import NightStore


@dataclass(frozen=True)
class Attribution:
    """Result of the real runs behind one change."""

    change: str
    """Id of the change"""
    figure: str
    last: str
    since: str
    verdict: str
    """``confirmed``, ``both``, ``interaction`` or ``not reproduced``"""
    culprits: tuple[str, ...]
    """Parts that make the change"""
    words: str
    """Verdict with the states of the parts"""
    made: datetime.datetime
    """UTC"""


def keep_attribution(store: NightStore, found: Attribution) -> None:
    """Keep an attribution; an earlier one of the same change is replaced."""
    row = {
        "change": found.change, "figure": found.figure, "last": found.last, "since": found.since,
        "verdict": found.verdict, "culprits": "\n".join(found.culprits), "words": found.words[:MOST_TEXT],
        "made": found.made,
    }  # fmt: skip
    with told(store.given), writing(store.engine) as connection:
        connection.execute(sa.delete(attributions).where(attributions.c.change == found.change))
        connection.execute(sa.insert(attributions), [row])


def kept_attributions(store: NightStore) -> dict[str, Attribution]:
    """All attributions by the id of the change."""
    with told(store.given), store.engine.connect() as connection:
        rows = connection.execute(sa.select(attributions).order_by(attributions.c.made)).all()
    return {
        r.change: Attribution(
            r.change, r.figure, r.last, r.since, r.verdict, tuple(r.culprits.split("\n")) if r.culprits else (),
            r.words, r.made,
        )
        for r in rows
    }  # fmt: skip


def attributed_words(store: NightStore, changes: Iterable[Change]) -> dict[str, str]:
    """Results of attributions in words, by the id of the change.

    A night that went on has another name, and so its changes have other ids: they are found by figure and nights, too.
    """
    known = kept_attributions(store)
    placed = {(one.figure, one.last, one.since): one for one in known.values()}
    found = ((c.id, known.get(c.id) or placed.get((c.identity.name, c.last, c.since))) for c in changes)
    return {change: one.words for change, one in found if one is not None}
