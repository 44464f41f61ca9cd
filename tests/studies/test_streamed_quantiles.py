"""Quantiles from counts: within their error bounds, the same bits in any order and after a kill, in little memory."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tracemalloc
from contextlib import nullcontext
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from barchain.cli.main import run as barchain
from barchain.runs.executors import LocalProcesses
from barchain.studies.ensemble import kept_parts, plan
from barchain.studies.ensemble import tasks as tasks_module
from barchain.studies.ensemble.bins import BELOW, BINS, DIGITS, PILOT_RUNS
from barchain.studies.ensemble.counts import BinCounts
from barchain.studies.ensemble.execution import ensemble
from barchain.studies.ensemble.plan import EnsembleOptions
from barchain.studies.ensemble.rows import rows_text, run_columns
from barchain.studies.ensemble.study import EnsembleStudy
from barchain.studies.ensemble.tasks import run_task, tasks
from barchain.studies.study import Reporter, run_study
from reports.tables.ensemble import FILES
from reports.tables.reading import TABLES
from tests.support.page_policy import check_policy

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.studies.ensemble.plan import EnsemblePlan
    from reference_impl.model.arrays import Array

WANTED = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
RUNS = 20_000
VARY = ["angle_deg=normal(0, 1)", "mass_kg[2]=lognormal(100, 0.2)"]
FEW = PILOT_RUNS + BINS + 177
"""Runs of which no samples are held; the last part and the last counts are not full"""
U = np.finfo(float).eps


def values() -> Array:
    """Columns of values (columns, runs)."""
    random = np.random.default_rng(1)
    return np.stack([
        random.normal(5.0, 1e-3, RUNS), random.lognormal(0.0, 2.0, RUNS), np.full(RUNS, 3.0), np.zeros(RUNS),
        random.uniform(-1.0, 1.0, RUNS), np.where(random.random(RUNS) < 0.3, np.nan, random.normal(0.0, 1.0, RUNS)),
        np.where(random.random(RUNS) < 0.5, -1.0, 1e-9), random.standard_cauchy(RUNS),
    ])  # fmt: skip


def counted(parts: list[Array], pilot: Array) -> BinCounts:
    found = BinCounts.around(pilot)
    for part in parts:
        padded = np.full((len(part), -(-part.shape[1] // 8) * 8), np.nan)
        padded[:, : part.shape[1]] = part
        found.add(padded)
    return found


@pytest.fixture
def few_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ensembles count samples as soon as they have more runs than bins."""
    monkeypatch.setattr(plan, "MOST_HELD", 0)


def planned(runs: int = FEW, **options: Any) -> EnsemblePlan:
    chosen: dict[str, Any] = {"orbits": 0.02, "samples": 3, "executor": LocalProcesses(2)} | options
    return plan.make_plan(EnsembleOptions("paper/fig05", VARY, runs, **chosen))


def recorded(out: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(FILES.record_path(out).read_text())
    return found


def table_bytes(out: Path) -> dict[str, bytes]:
    return {table: FILES.path(out, table).read_bytes() for table in FILES.tables}


def test_an_estimate_is_within_its_error_bound_and_the_bound_within_that_of_the_bins():
    """Bins are no wider than 2^-DIGITS of the distance from the centre, or 2^(1-BELOW) of the scale at the centre.

    Both neighbours of a quantile lie within the farthest distance of exact quantile, estimate and their widths. An
    edge is rounded by half a unit in the last place of a product and of a sum.
    """
    given = values()
    pilot = given[:, :PILOT_RUNS]
    found, bins = counted([given], pilot).quantiles(WANTED), BinCounts.around(pilot)
    exact = np.nanquantile(given, WANTED, axis=1)
    rounding = 2.0 * U * (np.abs(exact) + np.abs(bins.centre) + bins.scale)
    assert np.all(np.abs(found.value - exact) <= found.error_bound + rounding)
    np.testing.assert_array_equal(found.runs, (~np.isnan(given)).sum(axis=1))
    inner = slice(1, -1)  # the least and the most value may lie in the outermost bins, which have no end
    farthest = np.abs(found.value - bins.centre)[inner] + found.error_bound[inner]
    widest = np.maximum(2.0**-DIGITS * farthest, 2.0 ** (1 - BELOW) * bins.scale)
    assert np.all(found.error_bound[inner] <= widest + rounding[inner])


def test_constants_and_the_outermost_values_are_exact():
    given = values()
    found = counted([given], given[:, :PILOT_RUNS]).quantiles(WANTED)
    for column, value in ((2, 3.0), (3, 0.0)):
        np.testing.assert_array_equal(found.value[:, column], value)
        np.testing.assert_array_equal(found.error_bound[:, column], 0.0)
    assert np.all(found.value[0] >= np.nanmin(given, axis=1))
    assert np.all(found.value[-1] <= np.nanmax(given, axis=1))


def test_no_order_and_no_partition_changes_a_bit():
    given = values()
    pilot, shuffled = given[:, :PILOT_RUNS], np.random.default_rng(2).permutation(given, axis=1)
    whole, parts = counted([given], pilot), counted(np.array_split(shuffled, 7, axis=1), pilot)
    for field in fields(BinCounts):
        np.testing.assert_array_equal(getattr(whole, field.name), getattr(parts, field.name))
    np.testing.assert_array_equal(whole.quantiles(WANTED).value, parts.quantiles(WANTED).value)


def test_a_column_that_no_run_reaches_has_no_quantile():
    given = np.full((1, 24), np.nan)
    found = counted([given], given).quantiles(WANTED)
    assert np.isnan(found.value).all()
    assert found.runs[0] == 0


@pytest.mark.parametrize("samples", [3, 8])
def test_estimates_of_an_ensemble_are_within_their_bounds_on_any_number_of_workers(samples, monkeypatch):
    options = {"runs": FEW, "samples": samples, "orbits": 0.05}
    exact = ensemble("paper/fig05", VARY, **options)
    monkeypatch.setattr(plan, "MOST_HELD", 0)
    one, two = (ensemble("paper/fig05", VARY, executor=LocalProcesses(n), **options) for n in (1, 2))
    assert one.estimated
    assert not exact.estimated
    assert one.angle_rad is None
    assert one.quantiles.equals(two.quantiles)
    assert one.runs.equals(exact.runs)
    keys = ["t_s", "quantity", "item", "quantile", "unit", "runs"]
    assert one.quantiles[keys].equals(exact.quantiles[keys])
    assert (exact.quantiles["error_bound"] == 0.0).all()
    difference = np.abs(one.quantiles["value"] - exact.quantiles["value"])
    rounding = 8.0 * U * np.abs(exact.quantiles["value"]).max()
    np.testing.assert_array_less(difference, one.quantiles["error_bound"] + rounding)
    spread = exact.quantiles.groupby(["t_s", "quantity", "item"])["value"].transform(lambda v: v.max() - v.min())
    # a quantile between 5 and 95 % is no farther from the median than their range
    np.testing.assert_array_less(one.quantiles["error_bound"], 2.0**-DIGITS * 1.1 * spread + rounding)


def test_samples_are_held_as_long_as_they_take_no_more_room_than_bins(monkeypatch):
    assert planned(10_000, samples=101).exact
    assert not planned(20_000, samples=101).exact
    monkeypatch.setattr(plan, "MOST_HELD", 0)
    assert planned(PILOT_RUNS + BINS).exact
    assert not planned(PILOT_RUNS + BINS + 1).exact


def test_draws_do_not_depend_on_the_number_of_copies_drawn_at_a_time():
    plan_ = planned(600)
    parts = [task.part for task in tasks(plan_)]
    whole = next(plan.populations(plan_.scene, plan_.variations, 600, plan_.seed, 600))
    for name in ("angle_rad", "mass_kg", "inertia_kg_m2"):
        np.testing.assert_array_equal(np.concatenate([getattr(p, name) for p in parts]), getattr(whole, name))
    later = next(tasks(plan_, 500))
    np.testing.assert_array_equal(later.part.angle_rad, whole.angle_rad[500:])
    assert later.first == 500


def test_rows_are_the_text_that_pandas_writes():
    task = next(tasks(planned(30)))
    rows = run_columns(task, run_task(task), planned(30).variations)
    rows["reason"] = ["", "=1", "a, b", 'say "x"', *rows["reason"][4:]]
    text = kept_parts.header_text(rows) + rows_text(rows)
    assert kept_parts.table([rows]).to_csv(index=False).encode() == text


KILLED = """
import os, signal, sys
from contextlib import contextmanager
from pathlib import Path
from barchain.studies.ensemble import kept_parts, plan
from barchain.studies.ensemble import tasks as tasks_module
from barchain.studies.study import Reporter, run_study
from tests.studies.test_streamed_quantiles import EnsembleStudy, planned
from tests.support.kernel import needs_kernel
plan.MOST_HELD, kept_parts.MOST_TEXT = int(sys.argv[2]), 20_000
pytestmark = needs_kernel


@contextmanager
def counted(*_):
    done = [0]
    def count(more):
        done[0] += more
        if done[0] >= 2600:
            os.kill(os.getpid(), signal.SIGKILL)
    yield count
run_study(EnsembleStudy(), planned(), Path(sys.argv[1]), reporter=Reporter(counted=counted))
"""


@pytest.mark.parametrize("held", [0, pytest.param(10_000_000, marks=pytest.mark.slow)], ids=["counted", "held"])
@pytest.mark.slow
def test_a_killed_ensemble_goes_on_to_the_same_tables(held, tmp_path, monkeypatch):
    command = [sys.executable, "-c", KILLED, str(tmp_path / "cut"), str(held)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    assert subprocess.run(command, env=environment, check=False).returncode == -signal.SIGKILL
    assert kept_parts.WHOLE in recorded(tmp_path / "cut")[TABLES]
    monkeypatch.setattr(plan, "MOST_HELD", held)
    begun: list[int] = []
    reporter = Reporter(counted=lambda *_: nullcontext(begun.append))
    run_study(EnsembleStudy(), planned(executor=LocalProcesses(1)), tmp_path / "cut", reporter=reporter, resume=True)
    assert 0 < begun[0] < 2600
    assert sum(begun) == FEW
    run_study(EnsembleStudy(), planned(), tmp_path / "whole")
    assert table_bytes(tmp_path / "cut") == table_bytes(tmp_path / "whole")
    assert not (tmp_path / "cut" / "ensemble" / "parts").exists()
    for entry in ("outcomes", "evaluations", "estimated"):
        assert recorded(tmp_path / "cut")[entry] == recorded(tmp_path / "whole")[entry]


def interrupted_after(runs: int, out: Path, chosen: EnsemblePlan) -> None:
    """Run an ensemble up to an interrupt."""
    done = 0

    def count(more: int) -> None:
        nonlocal done
        done += more
        if done >= runs:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(EnsembleStudy(), chosen, out, reporter=Reporter(counted=lambda *_: nullcontext(count)))


@pytest.mark.parametrize("runs", [500, 1000, 2750])
def test_an_interrupt_within_the_pilot_or_later_changes_no_bit(runs, tmp_path, few_held):
    interrupted_after(runs, tmp_path / "cut", planned())
    run_study(EnsembleStudy(), planned(), tmp_path / "cut", resume=True)
    run_study(EnsembleStudy(), planned(), tmp_path / "whole")
    assert table_bytes(tmp_path / "cut") == table_bytes(tmp_path / "whole")


@pytest.mark.parametrize("damaged", ["whole", "0000000000"])
def test_a_damaged_checkpoint_makes_all_runs_again(damaged, tmp_path, few_held):
    interrupted_after(2000, tmp_path, planned())
    (tmp_path / "ensemble" / "parts" / f"{damaged}.npz").write_bytes(b"other")
    begun: list[int] = []
    reporter = Reporter(counted=lambda *_: nullcontext(begun.append))
    found = run_study(EnsembleStudy(), planned(), tmp_path, reporter=reporter, resume=True)
    assert begun[0] == 0
    assert found.tally.outcomes == {"finished": FEW}
    assert len(FILES.read(tmp_path, "runs")) == FEW


def test_an_interrupt_waits_until_a_part_is_taken_whole():
    steps = []

    def take() -> None:
        with kept_parts.uninterrupted():
            signal.raise_signal(signal.SIGINT)
            steps.append("whole")

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a run in the background ignores interrupts
    try:
        with pytest.raises(KeyboardInterrupt):
            take()
    finally:
        signal.signal(signal.SIGINT, before)
    assert steps == ["whole"]


@pytest.mark.slow
def test_memory_does_not_grow_with_runs(tmp_path, monkeypatch, few_held):
    """Allowed: the draws and results of the two parts that may be under way, and the rows between two checkpoints.

    Were further samples, draws or rows held, memory would grow by more.
    """
    monkeypatch.setattr(kept_parts, "MOST_TEXT", 10_000)
    monkeypatch.setattr(tasks_module, "MOST_WAITING", 0)
    few, many = (planned(n, orbits=0.005, executor=LocalProcesses(1)) for n in (FEW, FEW + 8_000))
    peaks = []
    for k, chosen in enumerate((few, many)):
        tracemalloc.start()
        run_study(EnsembleStudy(), chosen, tmp_path / str(k))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    task = next(tasks(many))
    drawn = 8 * (5 * many.scene.bars + 3)
    samples, rows = task.result_bytes // task.part.runs, len(table_bytes(tmp_path / "1")["runs"]) // many.runs
    allowed = 2 * task.part.runs * (samples + drawn) + 2 * 10_000
    assert peaks[1] - peaks[0] < allowed
    assert allowed < 8_000 * min(samples, drawn, rows)


def test_record_and_page_say_that_quantiles_are_estimated(tmp_path, few_held):
    few = ["--orbits", "0.02", "--samples", "3", "--vary", VARY[0]]
    assert barchain(["-q", "ensemble", "paper/fig05", "--runs", str(FEW), *few, "--out", str(tmp_path)]) == 0
    assert recorded(tmp_path)["estimated"] == {"relative_error": 2.0**-DIGITS, "pilot_runs": PILOT_RUNS}
    check_policy(tmp_path / "ensemble.html")
    page = (tmp_path / "ensemble.html").read_text(encoding="utf-8")
    assert "estimated from counts in bins: to within 1.6&nbsp;% of their distance" in page
    assert "Error at most" in page
    assert FILES.read(tmp_path, "quantiles")["error_bound"].max() > 0.0
