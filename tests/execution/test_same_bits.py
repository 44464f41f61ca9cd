"""Tables from a cluster are those of this machine to the last bit, even if a worker is killed or the scheduler lost."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
import pytest

pytest.importorskip("distributed")

from barchain.cli.main import run as barchain
from barchain.runs.cluster.connection import ClusterLostError
from barchain.runs.executors import DaskCluster, LocalProcesses
from barchain.studies.comparison.run import run_comparison
from barchain.studies.study import Reporter
from tests.support.local_cluster import LocalCluster, kill
from tests.support.results import read_table, series_folder

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from barchain.runs.executors import Executor

PATIENT_S = 120.0
ENGINES = ("rebound", "pymunk")
QUICK = ("basics/kepler_circular",)
SEVERAL = ("basics/kepler_circular", "basics/free_rotation")


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[LocalCluster]:
    (tmp_path / "cluster").mkdir()
    made = LocalCluster(tmp_path / "cluster")
    yield made
    made.close()


def compared(
    out: Path, scenes: tuple[str, ...], executor: Executor, act: Callable[[], None] = lambda: None, **options: bool
) -> pd.DataFrame:
    """Metrics of a comparison; `act` is called after the first verdict."""
    acts = iter([act])

    def act_once(_scene: str, _engine: str, _outcome: str) -> None:
        next(acts, lambda: None)()

    run_comparison(scenes, ENGINES, out, executor=executor, reporter=Reporter(act_once), **options)
    return read_table(out)


def same(first: pd.DataFrame, second: pd.DataFrame) -> None:
    pd.testing.assert_frame_equal(first, second, check_exact=True)


@pytest.mark.exhaustive
def test_a_comparison_on_a_cluster_gives_the_tables_of_this_machine(tmp_path: Path, cluster: LocalCluster) -> None:
    cluster.worker()
    there = compared(tmp_path / "there", QUICK, DaskCluster(cluster.address, PATIENT_S))
    here = compared(tmp_path / "here", QUICK, LocalProcesses())
    same(there, here)
    stored = {path.relative_to(tmp_path / "here") for path in series_folder(tmp_path / "here").rglob("*.parquet")}
    assert stored
    for path in stored:
        assert (tmp_path / "there" / path).read_bytes() == (tmp_path / "here" / path).read_bytes(), path


@pytest.mark.exhaustive
def test_a_comparison_whose_scheduler_is_lost_goes_on_from_its_rows(tmp_path: Path, cluster: LocalCluster) -> None:
    cluster.worker()
    out = tmp_path / "out"
    with pytest.raises(ClusterLostError, match="the scheduler was lost"):
        compared(out, SEVERAL, DaskCluster(cluster.address, PATIENT_S), lambda: kill(cluster.scheduler))
    assert len(read_table(out)) > 0
    assert any((series_folder(out) / "trajectories").rglob("*.parquet"))
    resumed = compared(out, SEVERAL, LocalProcesses(), resume=True)
    same(resumed, compared(tmp_path / "whole", SEVERAL, LocalProcesses()))


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("line", "study", "tables"),
    [
        ("stability hard/vertical_fall --engine rebound", "stability", ["outcomes"]),
        ("selftest basics/kepler_circular --fault scale-rate --fault sign-reaction", "selftest", ["fates", "readings"]),
        ("roundoff --part evaluation", "roundoff", ["evaluation", "longitudes"]),
    ],
)
def test_a_study_on_a_cluster_gives_the_tables_of_this_machine(
    line: str, study: str, tables: list[str], tmp_path: Path, cluster: LocalCluster
) -> None:
    cluster.worker()
    cluster.worker()
    codes = [
        barchain(["-q", *line.split(), "--out", str(tmp_path / "here")]),
        barchain(
            ["-q", *line.split(), "--out", str(tmp_path / "there"), "--dask", cluster.address, "--dask-wait", "120"]
        ),
    ]
    assert codes[0] == codes[1]
    for table in tables:
        same(*(read_table(tmp_path / place, study, table) for place in ("there", "here")))


@pytest.mark.parametrize("line", ["cost paper/fig05", "scaling"])
def test_a_study_that_times_its_runs_takes_no_cluster(
    line: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert barchain([*line.split(), "--out", str(tmp_path / "out"), "--dask", "tcp://127.0.0.1:1"]) == 2
    said = capfd.readouterr().err
    assert "No such option '--dask'" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_workers_of_this_machine_are_not_counted_on_a_cluster(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    line = ["compare", *QUICK, "--out", str(tmp_path / "out"), "--dask", "tcp://127.0.0.1:1", "--workers", "2"]
    assert barchain(line) == 2
    assert "--workers counts runs on this machine" in capfd.readouterr().err
