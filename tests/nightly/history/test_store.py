"""The folder of nights: what is added comes back, once, is merged by copying, and goes only when it is pruned."""

from __future__ import annotations

import datetime
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings

from barchain.nightly.attribution.attribute import Attribution, keep_attribution
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.table import CHARTED, FIGURES
from barchain.nightly.history.judging import judge
from barchain.nightly.history.news import attributed_words, keep_judgement
from barchain.nightly.history.nights import RECORD, NightStore, export_parquet, open_store
from barchain.nightly.history.pruning import prune_runs
from barchain.nightly.history.standing import every_change
from tests.nightly.history.synthetic import FIRST, count, error, large_night, night, nights, ratio, verdict

if TYPE_CHECKING:
    from barchain.nightly.figures.figure import Night
    from barchain.nightly.history.levels import JudgedNight


def folder(store: NightStore, name: str = "") -> Path:
    """Folder of a night."""
    return Path(store.place.root) / name


def test_reading_a_night_starts_no_pool_of_threads(store: NightStore) -> None:
    store.add(night(error(), verdict(), count()))
    lines = (
        "import sys, psutil, pyarrow",
        "from barchain.nightly.figures.table import read_figures",
        "pyarrow.set_cpu_count(8)",
        "before = psutil.Process().num_threads()",
        "read_figures(open(sys.argv[1], 'rb').read())",
        "print(psutil.Process().num_threads() - before)",
    )
    path = str(folder(store, store.nights()[0].name) / FIGURES)
    ended = subprocess.run(
        [sys.executable, "-P", "-c", "\n".join(lines), path], capture_output=True, text=True, check=True
    )
    assert int(ended.stdout) <= 1, "a pool has a thread for each of eight processors"


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(made=nights())
def test_every_night_comes_back_bit_for_bit(store: NightStore, made: Night) -> None:
    store.add(made)
    found = store.night(made.name)
    assert (found.name, replace(found, label=made.label)) == (made.name, made)
    numbers = store.numbers().among([one for one in store.nights() if one.name == made.name])
    found = {(identity, value) for identity in numbers.identities for value in numbers.series(identity).values.tolist()}
    charted = [figure for figure in made.figures if figure.identity.kind in CHARTED]
    assert found == {(figure.identity, figure.value) for figure in charted if not figure.missing}


def test_adding_twice_changes_nothing(store: NightStore) -> None:
    made = large_night(0, 50)
    assert store.add(made)
    written = [path.stat().st_mtime_ns for path in sorted(folder(store).rglob("*"))]
    assert not store.add(made)
    assert [path.stat().st_mtime_ns for path in sorted(folder(store).rglob("*"))] == written


def test_a_resumed_night_replaces_the_incomplete_one(store: NightStore) -> None:
    half, whole = night(error(), complete=False, label="own"), night(error(), verdict(), label="own")
    store.add(half)
    assert store.add(whole)
    assert [(n.name, n.complete, n.figures) for n in store.nights()] == [(half.name, True, 2)]
    assert not store.add(half)
    assert [(n.name, n.complete, n.figures) for n in store.nights()] == [(half.name, True, 2)]


def test_histories_of_two_machines_are_merged_by_copying(tmp_path: Path, store: NightStore) -> None:
    store.add(night(error(1e-5), number=0))
    other = open_store(str(tmp_path / "other"), create=True)
    other.add(night(error(1e-5), number=1))
    shutil.copytree(folder(other), folder(store), dirs_exist_ok=True)
    assert [n.started.day for n in store.nights()] == [1, 2]
    assert judge(store).judged == 1


def test_a_torn_night_is_named_and_left_out(store: NightStore) -> None:
    made = [night(error(), number=k) for k in range(4)]
    for each in made:
        store.add(each)
    (folder(store, made[0].name) / RECORD).unlink()
    (folder(store, made[1].name) / FIGURES).write_bytes(b"PAR1")
    (folder(store, made[2].name) / FIGURES).unlink()
    assert [n.name for n in store.nights()] == [made[3].name]
    assert list(store.left_out()) == [each.name for each in made[:3]]


def test_a_night_that_stands_there_once_more_under_another_name_counts_once(store: NightStore) -> None:
    half, made = night(error(), complete=False, number=0, label="own"), night(error(), number=1)
    store.add(half)
    store.add(made)
    shutil.copytree(folder(store, made.name), folder(store, f"{made.name}-copy"))
    shutil.copytree(folder(store, half.name), folder(store, "before"))
    store.add(night(error(), number=0, label="own"))
    assert [n.name for n in store.nights()] == [half.name, made.name]
    assert store.left_out() == {
        "before": f"it is a copy of {half.name}", f"{made.name}-copy": f"it is a copy of {made.name}"
    }  # fmt: skip
    assert store.night(made.name[:12]).name == made.name  # the beginning of a name will do
    with pytest.raises(HistoryError, match=r"left out of the history: it is a copy of"):
        store.night(f"{made.name}-copy")


def test_a_night_of_a_later_barchain_is_one_line(store: NightStore) -> None:
    made = night(error())
    store.add(made)
    path = folder(store, made.name) / RECORD
    path.write_text(path.read_text("utf-8").replace('"format": 1', '"format": 99'), "utf-8")
    with pytest.raises(HistoryError, match="a later barchain wrote this night"):
        open_store(store.place.url).nights()


def test_nights_lie_at_any_address_that_fsspec_knows() -> None:
    store = open_store("memory://nights", create=True)
    made = [night(error(1e-5 * (k + 1)), number=k) for k in range(3)]
    for each in (made[1], made[0], made[2]):
        assert store.add(each)
    assert [n.name for n in store.nights()] == [each.name for each in made]  # in the order of their starts
    assert store.night("latest").figures == made[-1].figures
    assert len(judge(store).tonight) == 1
    assert len(store.prune(keep=1)) == 2
    assert [n.name for n in store.nights()] == [made[-1].name]


def test_a_read_only_history_is_read_and_can_not_be_written(store: NightStore, monkeypatch: pytest.MonkeyPatch) -> None:
    store.add(night(error()))

    def refused(*_: object) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr("os.fsync", refused)
    assert judge(store).night.figures == 1
    with pytest.raises(HistoryError, match="can't be written or read"):
        store.add(night(error(), number=1))


def test_pruning_by_age_leaves_the_last_nights(store: NightStore) -> None:
    for k in range(4):
        store.add(night(error(), number=k))
    later = FIRST + datetime.timedelta(days=100)
    assert len(store.prune(before=FIRST + datetime.timedelta(days=1, seconds=-1))) == 1
    assert len(store.prune(keep=2, before=later)) == 1
    assert [n.started.day for n in store.nights()] == [3, 4]
    assert store.prune(keep=2) == ()


def test_the_parquet_file_has_every_number(store: NightStore, tmp_path: Path) -> None:
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


def test_an_attribution_goes_with_a_night_that_goes_on(store: NightStore) -> None:
    store.add(night(error(1e-5), number=0))
    store.add(night(error(3e-5), number=1, complete=False, label="own"))
    (change,) = judge(store).tonight
    made = Attribution(change.id, change.identity.name, change.last, change.since, "confirmed", ("a",), "yes")
    keep_attribution(store, made)
    store.add(night(error(3e-5), verdict(), number=1, label="own"))
    changes = judge(store).tonight
    assert attributed_words(store, changes) == {changes[0].id: "yes"}


def judged_and_told(store: NightStore, name: str = "latest") -> JudgedNight:
    """Judgement of a night, which is kept."""
    judged = judge(store, name)
    keep_judgement(store, judged)
    return judged


def test_a_night_that_is_added_late_is_judged_itself_and_makes_no_later_one_red(store: NightStore) -> None:
    for k in (0, 1, 3):
        store.add(night(error(3e-5), number=k))
        judged_and_told(store)
    late = night(error(1e-5), number=2)
    store.add(late)
    assert [c.direction for c in judged_and_told(store, late.name).tonight] == ["better"]
    assert every_change(judge(store)) == []
    store.add(night(error(3e-5), number=4))
    assert every_change(judged_and_told(store)) == []


def test_changes_after_the_fact_are_those_that_were_told(store: NightStore) -> None:
    for k, value in enumerate((1e-5, 1e-5, 3e-5)):
        store.add(night(error(value), number=k))
        before = [c.id for c in judged_and_told(store).tonight]
    name = store.nights()[-1].name
    store.add(night(error(9e-5), number=1, label="late"))
    assert [c.id for c in judge(store, name).tonight] == before != []


def test_runs_and_levels_of_quiet_nights_go_after_a_fortnight_and_rows_stay(store: NightStore) -> None:
    for k in range(20):
        made = night(error(3e-5 if k == 2 else 1e-5), number=k)
        store.add(made)
        judged_and_told(store)
        for kind in ("trajectories", "rows"):
            (folder(store, made.name) / "core" / kind).mkdir(parents=True)
    prune_runs(store, folder(store))
    kept = [(folder(store, each.name) / "core" / "trajectories").is_dir() for each in store.nights()]
    assert kept == [k in (2, 3) or k >= 6 for k in range(20)]
    assert all((folder(store, each.name) / "core" / "rows").is_dir() for each in store.nights())
    nights = store.nights()
    assert [(folder(store, each.name) / "levels.z").is_file() for each in nights] == [k >= 6 for k in range(20)]
    assert [c.direction for c in judge(store, nights[2].name).tonight] == ["worse"]


def test_figures_that_are_not_those_of_the_record_are_one_line(store: NightStore) -> None:
    made = night(error())
    store.add(made)
    path = folder(store, made.name) / FIGURES
    path.write_bytes(b"x" * path.stat().st_size)
    with pytest.raises(HistoryError, match=r"figures\.parquet is damaged; copy the night again"):
        store.night(made.name)
