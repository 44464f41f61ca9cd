"""What nights did of their plans, beside the nights in the store."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sqlalchemy as sa

from barchain.nightly.history.storage.connection import told
from barchain.nightly.history.storage.tables import runs
from barchain.nightly.run_facts import NightRun

if TYPE_CHECKING:
    from barchain.nightly.history.model.series_model import NightSummary
    from barchain.nightly.history.store import NightStore


def run_of_night(store: NightStore, night: NightSummary) -> NightRun | None:
    """Run of a night; None of a night that `barchain history add` made of a result folder."""
    with told(store.given), store.engine.connect() as connection:
        found = connection.execute(sa.select(runs.c.content).where(runs.c.night_id == night.number)).scalar()
    return None if found is None else NightRun.from_json(found)


def runs_of_nights(store: NightStore) -> dict[int, NightRun]:
    """Runs of all nights that have one, by the number of the night."""
    with told(store.given), store.engine.connect() as connection:
        rows = connection.execute(sa.select(runs.c.night_id, runs.c.content)).all()
    return {row.night_id: NightRun.from_json(row.content) for row in rows}


def last_run(store: NightStore, plan: str) -> NightRun | None:
    """Run of the last night of a plan; None before the first.

    Turns go on in the order in which nights are stored: a clock that was wrong once does not stop them.
    """
    latest = sa.select(runs.c.content).where(runs.c.plan == plan).order_by(runs.c.night_id.desc()).limit(1)
    with told(store.given), store.engine.connect() as connection:
        found = connection.execute(latest).scalar()
    return None if found is None else NightRun.from_json(found)
