"""Chunks of an ensemble: the same tables on any number of workers and after a kill, in little memory."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tracemalloc
from collections import namedtuple
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from barchain.runs.executors import LocalProcesses
from barchain.studies.distributions import VariationError
from barchain.studies.ensemble import chunks as chunks_module
from barchain.studies.ensemble import study
from barchain.studies.ensemble.chunks import LEAST_RUNS, MOST_CHUNKS, chunks, run_chunk
from barchain.studies.ensemble.population import populations
from barchain.studies.ensemble.study import EnsembleStudy, ensemble, ensemble_study
from barchain.studies.study import Reporter, run_study
from reports.results.ensemble import FILES
from tests.support.kernel import needs_kernel
from tests.support.results import answers_folder, read_record

if TYPE_CHECKING:
    from pathlib import Path


pytestmark = needs_kernel
VARY = ["angle_deg=normal(0, 1)", "mass_kg[2]=lognormal(100, 0.2)"]
RUNS = 4250
"""Runs in seventeen chunks"""


def planned(runs: int = RUNS, **options: Any) -> EnsembleStudy:
    chosen: dict[str, Any] = {"orbits": 0.02, "samples": 3, "executor": LocalProcesses(2)} | options
    return ensemble_study("paper/fig05", VARY, runs, **chosen)


def table_bytes(out: Path) -> dict[str, bytes]:
    return {table: (out / FILES.series_name(table)).read_bytes() for table in FILES.series}


def test_quantiles_over_all_chunks_are_those_of_all_runs_on_any_number_of_workers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    options: dict[str, Any] = {"runs": 1100, "samples": 8, "orbits": 0.05}
    one, two = (ensemble("paper/fig05", VARY, executor=LocalProcesses(n), **options) for n in (1, 2))
    assert one.quantiles.equals(two.quantiles)
    assert one.runs.equals(two.runs)
    middle = one.quantiles.query("quantity == 'attitude' and quantile == 0.5")["value"].to_numpy()
    np.testing.assert_array_equal(middle, np.quantile(one.angle_rad, 0.5, axis=0).ravel())
    monkeypatch.setattr(chunks_module, "MOST_SORTED", 1)
    monkeypatch.setattr(study, "MOST_HELD", 0)
    by_column = ensemble("paper/fig05", VARY, **options)
    assert by_column.quantiles.equals(one.quantiles)
    assert by_column.angle_rad is None


@pytest.mark.parametrize(
    ("runs", "samples", "size"),
    [
        (1000, 101, LEAST_RUNS),
        (100_000, 5, 100_000 // MOST_CHUNKS),
        (100_000, 101, chunks_module.MOST_NUMBERS // (101 * 9)),
        (1000, 5001, LEAST_RUNS),
    ],
)
def test_many_runs_have_many_chunks_and_large_samples_small_ones(runs: int, samples: int, size: int) -> None:
    assert next(chunks(planned(runs, samples=samples))).part.runs == size


def test_draws_do_not_depend_on_the_number_of_copies_drawn_at_a_time() -> None:
    plan = planned(600)
    parts = list(chunks(plan))
    whole = next(populations(plan.scene, plan.variations, 600, plan.seed, 600))
    assert [chunk.first for chunk in parts] == [0, 250, 500]
    for name in ("angle_rad", "mass_kg", "inertia_kg_m2"):
        np.testing.assert_array_equal(np.concatenate([getattr(c.part, name) for c in parts]), getattr(whole, name))


KILLED = """
import os, signal, sys
from contextlib import contextmanager
from pathlib import Path
from barchain.studies.study import Reporter, run_study
from tests.studies.test_ensemble_chunks import planned


@contextmanager
def counted(*_):
    done = [0]
    def count(more):
        done[0] += more
        if done[0] >= 2600:
            os.kill(os.getpid(), signal.SIGKILL)
    yield count
run_study(planned(), Path(sys.argv[1]), reporter=Reporter(counted=counted))
"""


@pytest.mark.slow
def test_a_killed_ensemble_goes_on_to_the_same_tables_and_makes_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = [sys.executable, "-c", KILLED, str(tmp_path / "cut")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    assert subprocess.run(command, env=environment, check=False).returncode == -signal.SIGKILL
    kept = len(list(answers_folder(tmp_path / "cut", "ensemble").glob("*")))
    made: list[int] = []

    def noted(chunk):  # type: ignore[no-untyped-def]
        made.append(chunk.first)
        return run_chunk(chunk)

    monkeypatch.setattr(chunks_module, "run_chunk", noted)
    run_study(planned(executor=LocalProcesses(1)), tmp_path / "cut", resume=True)
    assert 2600 / LEAST_RUNS <= kept < RUNS / LEAST_RUNS
    assert len(made) == RUNS / LEAST_RUNS - kept
    run_study(planned(), tmp_path / "whole")
    assert table_bytes(tmp_path / "cut") == table_bytes(tmp_path / "whole")
    assert not answers_folder(tmp_path / "cut", "ensemble").exists()
    for entry in ("outcomes", "evaluations"):
        assert read_record(tmp_path / "cut", "ensemble")[entry] == read_record(tmp_path / "whole", "ensemble")[entry]


@pytest.mark.parametrize("damage", [b"other", None])
def test_an_interrupted_ensemble_asks_again_for_what_is_missing_or_damaged(
    damage: bytes | None, tmp_path: Path
) -> None:
    done: list[int] = []

    def count(more: int) -> None:
        done.append(more)
        if sum(done) == 500:
            raise KeyboardInterrupt

    reporter = Reporter(counted=lambda *_: nullcontext(count))
    with pytest.raises(KeyboardInterrupt):
        run_study(planned(1000), tmp_path / "cut", reporter=reporter)
    if damage is not None:
        next(answers_folder(tmp_path / "cut", "ensemble").iterdir()).write_bytes(damage)
    done[:] = [1]
    run_study(planned(1000), tmp_path / "cut", reporter=reporter, resume=True)
    assert sum(done) == 1001
    run_study(planned(1000), tmp_path / "whole")
    assert table_bytes(tmp_path / "cut") == table_bytes(tmp_path / "whole")


def test_samples_that_the_file_system_has_no_room_for_are_told_beforehand(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(10**9, 10**9, 1000))
    with pytest.raises(VariationError, match="B left"):
        run_study(planned(1000), tmp_path)


@pytest.mark.slow
def test_memory_does_not_grow_with_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Allowed: more of the one column that is sorted at a time, and what is known of a file."""
    monkeypatch.setattr(chunks_module, "MOST_SORTED", 1)
    monkeypatch.setattr(chunks_module, "MOST_CHUNKS", 10**6)
    monkeypatch.setattr(chunks_module, "MOST_WAITING", 0)
    few, many = (planned(n, orbits=0.005, executor=LocalProcesses(1)) for n in (4000, 12_000))
    peaks = []
    for k, chosen in enumerate((few, many)):
        tracemalloc.start()
        run_study(chosen, tmp_path / str(k))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    more = many.runs - few.runs
    allowed = 4 * 8 * more + 4096 * more // LEAST_RUNS
    drawn = 8 * (5 * many.scene.bars + 3)
    rows = len(table_bytes(tmp_path / "1")["runs"]) // many.runs
    samples = 8 * chunks_module.columns(many.scene)
    assert peaks[1] - peaks[0] < allowed
    assert allowed < more * min(samples, drawn, 2 * rows)
