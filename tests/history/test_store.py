"""The store keeps every night once, whole, whoever writes at the same time."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TYPE_CHECKING

import pytest
import sqlalchemy as sa

from barchain.history.errors import HistoryError
from barchain.history.export import table_of
from barchain.history.figures import Figure, FigureError
from barchain.history.store import HistoryStore
from tests.history.nights import BITS, ERROR, STEPS, VERDICT, night

if TYPE_CHECKING:
    from pathlib import Path


def test_a_night_comes_back_as_it_was_added(store: HistoryStore) -> None:
    added = night(1)
    assert store.add(added)
    assert store.night(added.id) == added
    assert store.night(added.id[:6]) == store.night("latest") == added


def test_adding_a_night_twice_changes_nothing(store: HistoryStore) -> None:
    assert store.add(night(1))
    assert not store.add(night(1))
    assert [n.figures for n in store.nights()] == [4]


def test_nights_are_in_order_of_time_and_those_of_other_machines_can_be_left_out(store: HistoryStore) -> None:
    for day in (3, 1, 2):
        store.add(night(day, machine="other" if day == 2 else "here"))
    assert [n.started[8:10] for n in store.nights()] == ["01", "02", "03"]
    assert [n.started[8:10] for n in store.nights("here")] == ["01", "03"]


def test_values_of_a_series_are_in_order_of_time(store: HistoryStore) -> None:
    for day in (2, 1, 3):
        store.add(night(day, value=day * 1e-6))
    assert [figure.value for _, figure in store.values_of([ERROR])] == [1e-6, 2e-6, 3e-6]
    assert {figure.series for _, figure in store.values()} == {ERROR, VERDICT, BITS, STEPS}


def test_an_unknown_night_is_named_with_the_nearest_one(store: HistoryStore) -> None:
    with pytest.raises(HistoryError, match="the history is empty"):
        store.night("latest")
    store.add(night(1))
    known = night(1).id
    with pytest.raises(HistoryError, match=f"did you mean {known}"):
        store.night(known[:-1] + "x")


def test_pruning_leaves_the_latest_nights_and_no_name_without_figures(store: HistoryStore) -> None:
    old = night(1, figures=(Figure(STEPS, value=1.0),))
    for each in (old, night(2, figures=night(2).figures[:1]), night(3, figures=night(3).figures[:1])):
        store.add(each)
    assert store.prune(2) == [old.id]
    assert [n.started[8:10] for n in store.nights()] == ["02", "03"]
    with store.transaction() as connection:
        assert connection.execute(sa.text("select count(*) from series")).scalar() == 1
    with pytest.raises(HistoryError, match="at least 1"):
        store.prune(0)


def test_the_exported_table_has_every_figure(store: HistoryStore) -> None:
    store.add(night(1))
    store.add(night(2, value=2e-6))
    table = table_of(store)
    assert len(table) == 8
    assert list(table.loc[table["metric"] == "max", "value"]) == [1e-6, 2e-6]
    assert set(table.loc[table["metric"] == "outcome", "word"]) == {"pass"}


def test_tables_of_a_newer_barchain_are_left_alone(url: str) -> None:
    with HistoryStore(url) as store, store.transaction(writes=True) as connection:
        connection.execute(sa.text("update alembic_version set version_num = '9999'"))
    with pytest.raises(HistoryError, match="made by a newer barchain"):
        HistoryStore(url)


def test_the_steps_of_alembic_make_the_tables_that_the_store_uses(store: HistoryStore) -> None:
    from alembic.autogenerate import compare_metadata
    from alembic.migration import MigrationContext

    from barchain.history.tables import METADATA

    with store.transaction() as connection:
        found = compare_metadata(MigrationContext.configure(connection), METADATA)
    assert [change for change in found if "alembic_version" not in str(change)] == []


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("mysql://there/db", "allowed: sqlite:///FILE"),
        ("://", "no URL"),
        ("postgresql+psycopg://user:secret@127.0.0.1:9/db", "connection"),
        ("/proc/none/history.sqlite", "No such file"),
    ],
)
def test_a_store_that_can_not_be_used_is_named_in_one_line_without_its_password(given: str, said: str) -> None:
    with pytest.raises(HistoryError, match=said) as caught:
        HistoryStore(given)
    assert "\n" not in str(caught.value)
    assert "secret" not in str(caught.value)


def test_a_file_that_is_no_database_is_named(tmp_path: Path) -> None:
    file = tmp_path / "history.sqlite"
    file.write_text("no database" * 100)
    with pytest.raises(HistoryError, match="not a database"):
        HistoryStore(str(file))


def add_nights(url: str, days: list[int]) -> int:
    with HistoryStore(url) as store:
        return sum(store.add(night(day)) for day in days)


def test_writers_at_the_same_time_lose_nothing_and_double_nothing(url: str) -> None:
    with ProcessPoolExecutor(3, get_context("spawn")) as pool:
        parts = [list(range(1, 11)), list(range(6, 16)), list(range(11, 21))]
        added = sum(pool.map(add_nights, [url] * 3, parts))
    with HistoryStore(url) as store:
        assert added == len(store.nights()) == 20
        assert {n.figures for n in store.nights()} == {4}


def test_a_full_disk_is_one_line_and_leaves_the_earlier_nights(tmp_path: Path) -> None:
    with HistoryStore(str(tmp_path / "history.sqlite")) as store:
        store.add(night(1))
        with store.transaction() as connection:
            pages = connection.execute(sa.text("pragma page_count")).scalar()
        sa.event.listen(store.engine, "connect", lambda c, _: c.execute(f"pragma max_page_count = {pages}"))
        store.engine.dispose()
        many = tuple(Figure(STEPS.__class__("s", "e", str(k), "q", "m", STEPS.kind), value=1.0) for k in range(2000))
        with pytest.raises(HistoryError, match="database or disk is full"):
            store.add(night(2, figures=many))
        assert [n.figures for n in store.nights()] == [4]


WRITER = """
import sys
from barchain.history.store import HistoryStore
from tests.history.nights import night
store = HistoryStore(sys.argv[1])
print("ready", flush=True)
for day in range(1, 29):
    store.add(night(day))
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", range(6))
def test_a_kill_at_any_instant_leaves_whole_nights_and_adding_goes_on(url: str, number: int) -> None:
    HistoryStore(url).close()
    writer = subprocess.Popen([sys.executable, "-c", WRITER, url], stdout=subprocess.PIPE)
    assert writer.stdout
    writer.stdout.readline()
    time.sleep(random.Random(number).uniform(0.0, 0.3))
    os.kill(writer.pid, signal.SIGKILL)
    writer.communicate()
    with HistoryStore(url) as store:
        before = store.nights()
        assert {n.figures for n in before} <= {4}
        assert sum(store.add(night(day)) for day in range(1, 29)) == 28 - len(before)
        assert len(store.nights()) == 28


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"series": ERROR}, "no value, and no reason"),
        ({"series": ERROR, "value": float("nan")}, "no finite number"),
        ({"series": ERROR, "word": "pass"}, "needs a number"),
        ({"series": VERDICT, "value": 1.0}, "needs a word"),
    ],
)
def test_a_figure_has_the_value_that_its_kind_needs(entries: dict[str, object], said: str) -> None:
    with pytest.raises(FigureError, match=said):
        Figure(**entries)  # type: ignore[arg-type]
