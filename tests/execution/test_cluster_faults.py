"""A fault of a Dask cluster is one line with its exit code, within a stated time; parts that were done are kept."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING

import pandas as pd
import pytest

pytest.importorskip("distributed")

import numpy as np
import psutil

from barchain.cli.main import run as barchain
from barchain.runs.cluster.connection import ANSWER_S
from tests.support import local_cluster
from tests.support.kernel import needs_kernel
from tests.support.local_cluster import LocalCluster, kill, listener
from tests.support.results import answers_folder, read_table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

pytestmark = needs_kernel
ENSEMBLE = ["ensemble", "paper/fig05", "--vary", "angle_deg=normal(0, 1)", "--orbits", "0.02", "--samples", "3"]
RUNS = 2500  # ten parts
SPARE_S = 10.0  # for a busy machine


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[LocalCluster]:
    (tmp_path / "cluster").mkdir()
    made = LocalCluster(tmp_path / "cluster")
    yield made
    made.close()


class Ended:
    """How a command ended: exit code, standard error, seconds."""

    def __init__(self, capfd: pytest.CaptureFixture[str], out: Path, address: str, *options: str) -> None:
        capfd.readouterr()
        before, start = set(threading.enumerate()), time.monotonic()
        given = ["--runs", str(RUNS), "--out", str(out), "--dask", address, *options]
        self.code = barchain(["-q", *ENSEMBLE, *given])
        self.seconds = time.monotonic() - start
        self.words = capfd.readouterr().err
        self.threads = {t for t in threading.enumerate() if not t.daemon} - before

    def check(self, code: int, words: str, within_s: float) -> None:
        print(f"{self.seconds:.1f} s: {self.words}")
        assert self.code == code, self.words
        assert words in self.words
        assert self.words.count("\n") == 1
        assert self.words.startswith("barchain: --dask ")
        assert self.seconds < within_s + SPARE_S
        assert not connections()


def connections() -> list[object]:
    """Connections of this process that are open."""
    return [c for c in psutil.Process().net_connections("tcp") if c.status == psutil.CONN_ESTABLISHED]


def stored_parts(out: Path) -> int:
    return len(list(answers_folder(out, "ensemble").glob("*")))


def interrupting(monkeypatch: pytest.MonkeyPatch, act: Callable[[], None], after: int = 500) -> None:
    """Act once after some runs of the next ensemble."""

    @contextlib.contextmanager
    def counted(_what: str, _total: int) -> Iterator[Callable[[int], None]]:
        done = [0]

        def count(more: int) -> None:
            before, done[0] = done[0], done[0] + more
            if before < after <= done[0]:
                act()

        yield count

    monkeypatch.setattr("barchain.cli.common.progress.counted", counted)


@pytest.mark.slow
def test_an_address_without_a_listener_ends_at_once_and_makes_no_folder(tmp_path, capfd):
    ended = Ended(capfd, tmp_path / "out", "tcp://127.0.0.1:1")
    ended.check(2, "no Dask scheduler answers there", 1.0)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("answer", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n", bytes(range(256)) * 40])
def test_an_address_that_is_no_scheduler_ends_in_its_time(tmp_path, capfd, monkeypatch, answer):
    monkeypatch.setattr("barchain.runs.cluster.connection.ANSWER_S", 2.0)
    with listener(answer) as address:
        Ended(capfd, tmp_path / "out", address).check(2, "no Dask scheduler answers there", 2.0)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_scheduler_without_workers_ends_in_the_stated_time(tmp_path, capfd, cluster):
    ended = Ended(capfd, tmp_path / "out", cluster.address, "--dask-wait", "1")
    ended.check(2, "has had no worker for 1 s", 1.0)
    assert not (tmp_path / "out").exists()


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("preload", "words"),
    [
        (local_cluster.OTHER_DASK, "has distributed 2020.1.0, here "),
        (local_cluster.OTHER_SOURCES, "(sources other), here "),
        (local_cluster.LACKS_BARCHAIN, "can't load barchain's code"),
    ],
)
def test_a_worker_with_other_code_is_named_before_anything_runs(tmp_path, capfd, cluster, preload, words):
    cluster.worker(preload, "--no-nanny")
    ended = Ended(capfd, tmp_path / "out", cluster.address)
    ended.check(2, words, 30.0)
    assert "; install the same versions there" in ended.words
    assert not (tmp_path / "out").exists()


@pytest.mark.exhaustive
def test_a_lost_scheduler_keeps_the_parts_that_were_done_and_resume_goes_on(tmp_path, capfd, monkeypatch, cluster):
    cluster.worker(local_cluster.SLOW, "--no-nanny")
    out, lost = tmp_path / "out", []
    interrupting(monkeypatch, lambda: (kill(cluster.scheduler), lost.append(time.monotonic())))
    ended = Ended(capfd, out, cluster.address)
    after_s = time.monotonic() - lost[0]
    ended.check(1, "the scheduler was lost; 2 of 10 tasks sent were done", 60.0)
    assert after_s < ANSWER_S
    assert stored_parts(out) == 2
    counts: list[int] = []
    interrupting(monkeypatch, lambda: counts.append(1), after=500)
    more = ["--runs", str(RUNS)]
    assert barchain(["-q", *ENSEMBLE, *more, "--out", str(out), "--resume"]) == 0
    assert stored_parts(out) == 0
    assert barchain(["-q", *ENSEMBLE, *more, "--out", str(tmp_path / "whole")]) == 0
    for table in ("runs", "quantiles"):
        first, second = (read_table(folder, "ensemble", table) for folder in (out, tmp_path / "whole"))
        pd.testing.assert_frame_equal(first, second, check_exact=True)


@pytest.mark.exhaustive
def test_a_scheduler_that_stops_answering_is_given_up(tmp_path, capfd, monkeypatch, cluster):
    cluster.worker(local_cluster.SLOW, "--no-nanny")
    monkeypatch.setattr("barchain.runs.cluster.connection.SILENT_S", 12.0)
    interrupting(monkeypatch, lambda: psutil.Process(cluster.scheduler.pid).suspend())
    Ended(capfd, tmp_path / "out", cluster.address).check(1, "no answer within 12 s", 60.0)
    assert stored_parts(tmp_path / "out") == 2


@pytest.mark.exhaustive
def test_workers_that_all_leave_are_given_up_after_the_stated_time(tmp_path, capfd, monkeypatch, cluster):
    worker = cluster.worker(local_cluster.SLOW, "--no-nanny")
    interrupting(monkeypatch, lambda: kill(worker))
    ended = Ended(capfd, tmp_path / "out", cluster.address, "--dask-wait", "15")
    ended.check(1, "has had no worker for 15 s", 60.0)
    assert stored_parts(tmp_path / "out") == 2


@pytest.mark.exhaustive
def test_a_part_that_kills_its_worker_too_often_ends_the_command(tmp_path, capfd, monkeypatch):
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    (tmp_path / "cluster").mkdir()
    cluster = LocalCluster(tmp_path / "cluster")
    try:
        cluster.worker(local_cluster.DIES, "--no-nanny")
        Ended(capfd, tmp_path / "out", cluster.address).check(1, "a task was lost with its worker (deaths: 1)", 60.0)
    finally:
        cluster.close()


@pytest.mark.slow
def test_parts_of_another_plan_are_not_taken(tmp_path, monkeypatch):
    def stop() -> None:
        raise KeyboardInterrupt

    interrupting(monkeypatch, stop)
    out = ["--out", str(tmp_path / "out")]
    assert barchain(["-q", *ENSEMBLE, "--runs", "1000", *out]) == 130
    assert stored_parts(tmp_path / "out") == 2
    interrupting(monkeypatch, lambda: None)
    assert barchain(["-q", *ENSEMBLE, "--runs", "1000", "--seed", "2", "--resume", *out]) == 0
    assert barchain(["-q", *ENSEMBLE, "--runs", "1000", "--seed", "2", "--out", str(tmp_path / "whole")]) == 0
    first, second = (
        read_table(tmp_path / name, "ensemble", "quantiles")["value"].to_numpy() for name in ("out", "whole")
    )
    np.testing.assert_array_equal(first, second)
    assert stored_parts(tmp_path / "out") == 0
