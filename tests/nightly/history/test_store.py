"""The store over SQLite and PostgreSQL: what is added comes back, once, and goes only when it is pruned."""

from __future__ import annotations

import datetime
from dataclasses import replace
from typing import TYPE_CHECKING

import pandas as pd
import pytest
import sqlalchemy as sa
from hypothesis import HealthCheck, given, settings

from barchain.nightly.history.faults import HistoryError, NewerSchemaError, UnknownFigureError, UnknownNightError
from barchain.nightly.history.judged import judge
from barchain.nightly.history.kept.attributed import Attribution, attributed_words, keep_attribution
from barchain.nightly.history.location import full_url
from barchain.nightly.history.model.figures import FigureKind, Night
from barchain.nightly.history.series import all_series, export_parquet, figure_series
from barchain.nightly.history.storage.connection import new_engine, writing
from barchain.nightly.history.storage.migrating import known_revisions
from barchain.nightly.history.storage.tables import HEAD, metadata
from barchain.nightly.history.store import NightStore, open_store
from tests.nightly.history.synthetic import FIRST, bits, count, error, large_night, night, nights, ratio, verdict

if TYPE_CHECKING:
    from pathlib import Path


def rows_in(store: NightStore) -> dict[str, int]:
    with store.engine.connect() as connection:
        counts = {t.name: connection.execute(sa.select(sa.func.count()).select_from(t)) for t in metadata.sorted_tables}
        return {name: found.scalar_one() for name, found in counts.items()}


def test_a_night_comes_back_as_it_was_added(store: NightStore) -> None:
    made = night(
        error(), bits(), verdict(), count(), ratio(2.0, low=1.9, high=2.2), commit="abc", void="a fault missed"
    )
    assert store.add(made)
    assert store.night(made.name) == made
    assert store.night("latest") == made


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=nights())
def test_every_night_comes_back_bit_for_bit(store: NightStore, made: Night) -> None:
    store.add(made)
    found = store.night(made.name)
    assert found == made
    assert found.identity == made.identity


def test_adding_twice_changes_nothing(store: NightStore) -> None:
    made = large_night(0, 50)
    assert store.add(made)
    before = rows_in(store)
    assert not store.add(made)
    assert rows_in(store) == before


def test_nights_that_share_figures_share_their_names(store: NightStore) -> None:
    store.add(large_night(0, 50))
    before = rows_in(store)
    store.add(large_night(1, 50))
    after = rows_in(store)
    assert after["figures"] == 2 * before["figures"]
    assert {t: after[t] for t in ("series", "texts", "parts", "environments")} == {
        t: before[t] for t in ("series", "texts", "parts", "environments")
    }


def test_a_resumed_night_replaces_the_incomplete_one(store: NightStore) -> None:
    half, whole = night(error(), complete=False), night(error(), verdict())
    store.add(half)
    assert store.add(whole, replaces=half.name)
    assert [n.name for n in store.nights()] == [whole.name]
    with pytest.raises(HistoryError, match="is complete"):
        store.add(night(number=1), replaces=whole.name)
    assert [n.name for n in store.nights()] == [whole.name]


def test_nights_are_listed_in_the_order_of_their_starts(store: NightStore) -> None:
    made = [night(error(), number=k) for k in (3, 1, 2)]
    for each in made:
        store.add(each)
    assert [n.started.day for n in store.nights()] == [2, 3, 4]
    assert [n.started.day for n in store.nights(last=2)] == [3, 4]
    assert store.summary("latest").figures == 1
    assert store.nights()[0].started == FIRST + datetime.timedelta(days=1)


def test_a_night_is_found_by_the_beginning_of_its_name_and_an_unknown_one_gets_the_nearest(store: NightStore) -> None:
    with pytest.raises(UnknownNightError, match="no nights"):
        store.night("latest")
    made = [night(error(), number=k) for k in range(2)]
    for each in made:
        store.add(each)
    assert store.night(made[1].name[:12]) == made[1]
    with pytest.raises(UnknownNightError, match="2 nights begin so"):
        store.night("2026")
    with pytest.raises(UnknownNightError, match=f"did you mean {made[0].name}"):
        store.night(made[0].name[:-1] + "_")


def test_a_series_has_a_figure_of_each_night(store: NightStore) -> None:
    for k in range(5):
        store.add(night(error(1e-5 * (k + 1)), count(), number=k))
    found = figure_series(store, error().identity.name)
    assert [f.value for f in found[0].figures] == [1e-5 * (k + 1) for k in range(5)]
    assert [n.started.day for n in found[0].nights] == [1, 2, 3, 4, 5]
    assert {s.identity for s in figure_series(store, "paper/fig05:*")} == {error().identity, count().identity}
    assert len(all_series(store, last=2)[0].figures) == 2
    assert [s.identity.kind for s in all_series(store, kinds=[FigureKind.COUNT])] == [FigureKind.COUNT]
    with pytest.raises(UnknownFigureError, match="did you mean paper/fig05:mujoco:steps_per_orbit=1000:steps"):
        figure_series(store, "paper/fig05:mujoco:steps_per_orbit=1000:step")


def test_pruning_keeps_the_last_nights_and_nothing_that_only_the_others_used(store: NightStore) -> None:
    for k in range(4):
        store.add(large_night(k, 20))
    store.add(night(verdict("failed", reason="only here"), number=10))
    gone = store.prune(keep=1)
    assert len(gone) == 4
    assert [n.started.day for n in store.nights()] == [11]
    assert rows_in(store)["figures"] == rows_in(store)["series"] == 1
    assert store.night("latest").figures[0].reason == "only here"


def test_pruning_by_age_leaves_the_last_nights(store: NightStore) -> None:
    for k in range(4):
        store.add(night(error(), number=k))
    later = FIRST + datetime.timedelta(days=100)
    assert len(store.prune(before=FIRST + datetime.timedelta(days=1, seconds=-1))) == 1
    assert len(store.prune(keep=2, before=later)) == 1
    assert [n.started.day for n in store.nights()] == [3, 4]
    assert store.prune(keep=2) == ()


def test_the_parquet_file_has_every_figure(store: NightStore, tmp_path: Path) -> None:
    made = [night(error(), verdict(), ratio(2.0, low=1.5), number=k) for k in range(3)]
    for each in made:
        store.add(each)
    path = tmp_path / "all.parquet"
    assert export_parquet(store, path) == 9
    table = pd.read_parquet(path)
    assert len(table) == 9
    assert set(table["night"]) == {each.name for each in made}
    assert table.loc[table["kind"] == "error", "value"].tolist() == [1e-5] * 3
    assert table.loc[table["kind"] == "verdict", "word"].tolist() == ["pass"] * 3
    assert table.loc[table["kind"] == "verdict", "value"].isna().all()


def test_an_empty_history_exports_an_empty_table(store: NightStore, tmp_path: Path) -> None:
    assert export_parquet(store, tmp_path / "all.parquet") == 0
    assert len(pd.read_parquet(tmp_path / "all.parquet")) == 0


def test_migrations_make_the_tables_that_the_store_uses(store: NightStore) -> None:
    from alembic.autogenerate import compare_metadata
    from alembic.runtime.migration import MigrationContext

    assert known_revisions()[0] == HEAD
    with store.engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, metadata) == []


def test_a_later_schema_is_not_touched(url: str) -> None:
    with open_store(url, create=True) as store:
        store.add(night(error()))
        with writing(store.engine) as connection:
            connection.execute(sa.text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(NewerSchemaError, match="a later barchain wrote this history"):
        open_store(url)


def test_a_database_of_something_else_is_not_touched(url: str) -> None:
    engine = new_engine(full_url(url))
    with engine.begin() as connection:
        connection.execute(sa.text("CREATE TABLE shopping (item TEXT)"))
    engine.dispose()
    with pytest.raises(HistoryError, match="no history of barchain"):
        open_store(url, create=True)


def test_a_closed_set_is_closed_in_the_database_too(store: NightStore) -> None:
    store.add(night(error()))
    with pytest.raises(sa.exc.IntegrityError), writing(store.engine) as connection:
        connection.execute(sa.text("UPDATE series SET kind = 'guess'"))
    with pytest.raises(sa.exc.IntegrityError), writing(store.engine) as connection:
        connection.execute(sa.text("UPDATE figures SET value = NULL"))


def test_an_attribution_goes_with_a_night_that_goes_on(store: NightStore) -> None:
    store.add(night(error(1e-5), number=0))
    cut_off = night(error(3e-5), number=1, complete=False)
    store.add(cut_off)
    (change,) = judge(store).tonight
    made = Attribution(change.id, change.identity.name, change.last, change.since, "confirmed", ("a",), "yes", FIRST)
    keep_attribution(store, made)
    store.add(replace(cut_off, duration_s=cut_off.duration_s + 1.0, complete=True), replaces=cut_off.name)
    changes = judge(store).tonight
    assert attributed_words(store, changes) == {changes[0].id: "yes"}
