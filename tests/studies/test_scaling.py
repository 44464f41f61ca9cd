"""What more bars cost: the chain is cut right, growth is fitted and foreseen right; times are never asserted."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pytest

from adapters.common.initial_state import initial_state
from adapters.registry import ENGINES, Registration
from barchain.record.study_store import StudyStore
from barchain.runs.job import Job, Role
from barchain.runs.phases import Peak, mark
from barchain.studies.defaults import FAST
from barchain.studies.scaling.point import ScalingTask, own_point
from barchain.studies.scaling.study import (
    LEAST_MEMORY_B,
    SHARES,
    ScalingRun,
    ScalingStudy,
    affordable,
    exponent,
    fits_table,
    predicted,
    scaling_study,
    targets,
)
from barchain.studies.study import Reporter, run_study
from barchain.studies.timing.evaluation import DIRECT, calibrated, divided, evaluation_times, loop_of
from reports.render import render_study
from reports.results.outcome import Outcome
from reports.results.rows import NOT_RUN
from reports.results.scaling import FILES, POINTS
from scenarios import load_scene
from tests.studies.scaling_tables import MEGABYTE, SCENE, synthetic, write
from tests.support.results import read_table

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize("bars", [2, 7, 1000])
def test_the_chain_keeps_its_length_mass_angle_and_rate(bars: int) -> None:
    whole, cut = load_scene(SCENE), divided(load_scene(SCENE), bars, 0.1)
    assert cut.bars == bars
    assert (cut.mass_kg, cut.size_m) == pytest.approx((whole.mass_kg, whole.size_m), rel=1e-14)
    assert cut.chain.inertia_kg_m2[0] == pytest.approx(cut.chain.mass_kg[0] * cut.chain.length_m[0] ** 2 / 12.0)
    assert {*cut.chain.angle_rad} == {whole.chain.angle_rad[0]}
    assert {*cut.chain.rate_factor} == {whole.chain.rate_factor[0]}
    assert cut.run.duration_s == pytest.approx(0.1 * whole.period_s)
    assert np.ptp(initial_state(cut).angle_rad) == 0.0


def test_the_smallest_share_of_an_orbit_leaves_every_engine_its_own_step() -> None:
    from adapters.common.equal_steps import step_s
    from adapters.engine import AccuracyParameter

    scene = divided(load_scene(SCENE), 2, SHARES[-1])
    for name, registration in ENGINES.items():
        setting = None if registration.missing else registration.load().sweep.setting()
        if setting and setting.parameter is AccuracyParameter.STEPS_PER_ORBIT:
            # rounded up to an even number of steps between samples: with k of them by one in k at most
            assert step_s(scene, setting.value) > 0.7 * scene.step_period_s / setting.value, name


def test_growth_is_foreseen_by_the_last_points() -> None:
    bars, cost = [5, 10, 20, 50, 100], [1.0, 1.0, 4.0, 25.0, 100.0]  # flat at first, then N²
    assert predicted(bars, cost, 200) == pytest.approx(400.0)
    assert predicted([], [], 10) == 0.0
    assert predicted([2, 5], [1.0, 1000.0], 10) == pytest.approx(4000.0)  # two points are not believed to grow so fast
    assert predicted([2, 5, 10], [3.0, 2.0, 1.0], 20) == pytest.approx(1.0)  # nothing gets cheaper
    assert predicted([2, 5], [math.nan, 1.0], 10) == pytest.approx(4.0)
    assert [affordable(cost_s, 10.0) for cost_s in (0.0, 10.0, 45.0, 201.0)] == [1.0, 1.0, 0.2, 0.0]


def test_an_exact_power_is_fitted_exactly() -> None:
    bars = np.array([20.0, 50.0, 100.0, 500.0])
    found = exponent(bars, 3e-9 * bars**1.5)
    assert (found.value, found.low, found.high) == pytest.approx((1.5, 1.5, 1.5), abs=1e-9)
    assert exponent(bars, np.array([1.0, 2.0, math.nan, 0.0])) is None


def test_the_interval_of_a_scattered_power_holds_it_as_often_as_it_says() -> None:
    rng, bars = np.random.default_rng(5), np.array([100.0, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000])
    inside = 0
    for _ in range(400):
        found = exponent(bars, bars * np.exp(0.05 * rng.standard_normal(len(bars))))
        inside += found.low <= 1.0 <= found.high
    assert abs(inside - 0.95 * 400) < 4.0 * math.sqrt(400 * 0.95 * 0.05)  # four standard deviations


def run_of(study: ScalingStudy, folder: Path) -> ScalingRun:
    """A run with an empty store, not started."""
    return ScalingRun(study, StudyStore(FILES, folder), Reporter())


def test_cheap_points_come_first(tmp_path: Path) -> None:
    """An engine that gets expensive waits until the cheap one is through; cheap ones take turns."""
    plan = dataclasses.replace(scaling_study(["reference"], (2, 5, 10), time_limit_s=100.0), engines={})
    study = run_of(plan, tmp_path)
    study.rows += [{"engine": e, "bars": 2, "build_s": 0.1, "orbit_s": s} for e, s in (("cheap", 0.1), ("dear", 20.0))]
    study.done |= {"cheap": 1, "dear": 1}
    prices = [study.price(*at) for at in (("new", 2), ("cheap", 5), ("cheap", 10), ("dear", 5))]
    assert prices == sorted(set(prices))
    assert (study.next_bars("cheap"), study.next_bars("new")) == (5, 2)
    study.done["cheap"] = 3
    assert study.next_bars("cheap") == 0
    # nobody goes beyond a hundred before all are there
    assert study.price("dear", 100) < study.price("cheap", 200)


def test_a_model_that_would_fill_the_memory_is_not_built(tmp_path: Path) -> None:
    study = run_of(scaling_study(["reference"], (2, 5, 10)), tmp_path)
    study.rows.append({"engine": "big", "bars": 2, "build_s": 0.1, "orbit_s": 0.1, "memory_B": 1e18})
    assert study.share("big", 5) == (0.0, "its model would take about 6.2e+09 GB of memory")
    study.rows.append({"engine": "long", "bars": 2, "build_s": 0.1, "orbit_s": 3000.0})
    assert study.share("long", 5) == (0.0, "would take about 5.2 h, the smallest share 16 min")
    assert study.share("new", 5) == (1.0, "")


def test_each_fit_keeps_to_its_range() -> None:
    fits = fits_table(synthetic()).set_index(["engine", "quantity"])
    fast, slow = fits.loc[FAST, "evaluation"], fits.loc["stepper", "evaluation"]
    assert (fast.bars_from, fast.bars_to) == (100, 100_000)
    assert (slow.bars_from, slow.bars_to, slow.points, slow.per) == (20, 100, 3, "steps")
    assert fast.exponent == pytest.approx(1.0)
    assert slow.exponent == pytest.approx(1.5)
    assert fits.loc[(FAST, "evaluations per orbit"), "exponent"] == pytest.approx(1.0)
    assert fits.loc[("stepper", "steps per orbit"), "exponent"] == pytest.approx(0.0, abs=1e-12)
    assert fits.loc[(FAST, "memory"), "bars_from"] * 200 > LEAST_MEMORY_B


def test_aims_are_judged_where_they_were_measured() -> None:
    def judged(points: pd.DataFrame) -> dict[str, bool]:
        return {t["what"]: t["met"] for t in targets(points, fits_table(points))}

    points = synthetic()
    whole = judged(points)
    assert list(whole.values()) == [True] * 4
    slower = judged(points.assign(evaluation_s=3.0 * points.evaluation_s))
    assert list(slower.values()) == [True, False, False, True]
    short = judged(points[points.bars <= 2000])  # what was not measured to its end is not judged
    assert list(short) == list(whole)[:2]
    assert judged(points[points.engine == "stepper"]) == {}


def test_the_chapter_says_growth_reasons_and_aims(tmp_path: Path) -> None:
    html = render_study("scaling", write(tmp_path)).page.read_text()
    for words in ("about 2.1 N times", "would take about &lt;300&gt; s", "1.50 (1.50 to 1.50)", "met"):
        assert words in html
    assert "nan" not in html.lower()


def test_a_batch_is_filled_whatever_one_call_takes() -> None:
    calls = []
    assert calibrated(calls.append, 0.0) == 1
    assert calls == [1, 1]  # once to compile, once to measure
    assert evaluation_times([calls.append], 3, 0.0).shape == (3, 1)


@pytest.mark.parametrize("engine", DIRECT)
def test_evaluations_are_timed_by_themselves(engine: str) -> None:
    times = evaluation_times([loop_of(engine, divided(load_scene(SCENE), 5))], 2, 1e-4)
    assert times.shape == (2, 1)
    assert (times > 0.0).all()


def test_the_timed_loop_evaluates_the_chain_at_its_start() -> None:
    """Same operations in the same order as one call, contracted or not: some roundings of the terms that enter."""
    from adapters.common.reference_model import chain_model
    from reference_impl.kernel import layout
    from reference_impl.kernel.library import Evaluation
    from reference_impl.model.kinematics import consistent_state
    from tests.support.compiled_evaluation import compiled_accelerations
    from tests.support.joint_roundoff import C, Case, U, magnitudes

    scene = divided(load_scene(SCENE), 20)
    start, model = initial_state(scene), chain_model(scene)
    state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
    y = layout.pack(*state)
    before, rates = y.copy(), np.zeros_like(y)
    Evaluation(y, rates, layout.compiled_chain(model), layout.workspace(scene.bars, 0)).repeat(3)
    np.testing.assert_array_equal(y, before)
    once = consistent_state(model, *state)
    expected = compiled_accelerations(model, 0.0, once)
    size = magnitudes(Case(model, once), expected).angular.max()
    np.testing.assert_allclose(rates[22:42], expected.angle_rad_s2, rtol=0, atol=C * U * size)


def test_the_peak_sees_what_was_held_and_let_go() -> None:
    if not math.isfinite(mark()):
        pytest.skip("this system does not tell its processes' memory")
    peak = Peak()
    held = np.ones(8 * 2**20)  # 64 MiB
    del held
    assert 60 * MEGABYTE < peak.beyond() < 80 * MEGABYTE


def test_an_engine_that_fails_where_it_is_warmed_up_says_so() -> None:
    scene = divided(load_scene(SCENE), 2, SHARES[-1])
    registration = Registration("tests.support.faulty_engines:GivesUp")
    job = Job(scene, "GivesUp", registration, registration.load().sweep.setting(), Role.MAIN)
    found = own_point(ScalingTask(job, job, 1.0, 1), 1.0)
    assert found["outcome"] == Outcome.FAILED.value
    assert found["reason"] == "step size became zero (on three bars, to warm up)"


@pytest.fixture(scope="module")
def resumed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, pd.DataFrame]:
    """Folder of a study that went on after it was cut off, and the points that it had before."""
    folder, plan = tmp_path_factory.mktemp("scaling"), scaling_study(["reference"], (2, 5), repeats=1)

    def cut(*_: str) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(plan, folder, reporter=Reporter(cut))
    first = read_table(folder, "scaling", "points")
    run_study(plan, folder, resume=True)
    return folder, first


@pytest.mark.slow
def test_a_good_point_has_all_that_was_asked_for(resumed: tuple[Path, pd.DataFrame]) -> None:
    own = read_table(resumed[0], "scaling", "points")
    assert list(own.columns) == list(POINTS.columns)
    assert own.outcome.tolist() == ["pass", "pass"]
    assert (own.share == 1.0).all()
    assert set(own.per) == {"right-hand side"}
    # a whole orbit at 1e-10: some fifty steps of DOP853 with dense output at ten samples
    assert own.evaluations.between(500, 2000).all()
    for column in ("evaluation_s", "orbit_s", "build_s"):
        assert (own[column] > 0.0).all()
    assert own.simulate_s.equals(own.orbit_s)
    if math.isfinite(mark()):
        assert (own.memory_B >= 0.0).all()


@pytest.mark.slow
def test_a_study_that_was_cut_off_measures_only_what_is_missing(resumed: tuple[Path, pd.DataFrame]) -> None:
    folder, first = resumed
    assert first.bars.tolist() == [2]
    points = read_table(folder, "scaling", "points")
    assert points.outcome.tolist() == ["pass", "pass"]
    pd.testing.assert_frame_equal(points[:1], first)
    run_study(scaling_study(["reference"], (2, 5), repeats=1), folder, resume=True)
    pd.testing.assert_frame_equal(read_table(folder, "scaling", "points"), points)


@pytest.mark.parametrize(
    ("engine", "bars", "minutes", "outcome", "reason"),
    [
        ("reference", (2, 5), 0.0, NOT_RUN, "the study's 0 minutes were over"),
        ("pymunk", (100, 200), 10.0, "unsupported", "sweeps"),
    ],
)
def test_a_study_without_time_or_of_too_many_bars_runs_nothing_and_says_why(
    engine: str, bars: tuple[int, int], minutes: float, outcome: str, reason: str, tmp_path: Path
) -> None:
    run_study(scaling_study([engine], bars, minutes=minutes), tmp_path)
    (point,) = read_table(tmp_path, "scaling", "points").itertuples()
    assert (point.bars, point.outcome) == (bars[0], outcome)
    assert reason in point.reason
    assert "No engine has three points" in render_study("scaling", tmp_path).page.read_text()
