"""What a cost study draws from its points: orders, cost at equal error, fronts, intervals."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from adapters.registry import ENGINES
from barchain.studies.cost.errors import errors_of, under_floor
from barchain.studies.cost.findings import front_of, order_row, price_table, reach_table
from barchain.studies.cost.plan import distinct, shortened, sweeps
from barchain.studies.timing.statistics import (
    SCATTERED,
    fit_order,
    interval,
    locate,
    lower_envelope,
    median_time,
    on_front,
)
from reports.results.rows import NotRun
from scenarios import load_scene
from tests.studies.cost_points import FLOOR, engine_points, point, table, times_of
from tests.support.certified_stand_in import certified_stand_in

STEPS = [20, 40, 80, 160, 320, 640]
ROUNDING = 1e-9  # of a least-squares fit or an interpolation in logarithms, many times over


@pytest.mark.parametrize("order", [1.0, 2.0, 6.0, 8.0])
def test_a_power_law_gives_its_order_with_an_interval_of_rounding(order):
    h = 1.0 / np.array(STEPS)
    fit = fit_order(h, 0.5 * h**order)
    assert fit.order.value == pytest.approx(order, abs=ROUNDING)
    assert fit.order.high - fit.order.low < ROUNDING


def test_the_order_is_that_of_the_straight_part_between_saturation_and_floor():
    h = 1.0 / np.array([2, 4, 8, 16, 32, 64, 128, 256, 512, 1024])
    error = np.minimum(5.0 * h**2 * (1.0 + 30.0 * h**2), 2.0) + 2e-5
    fit = fit_order(h, error)
    assert fit.order.value == pytest.approx(2.0, abs=0.1)
    assert fit.error_range[1] > 2e-5


def test_a_floor_a_scatter_and_two_points_have_no_order():
    h = 1.0 / np.array(STEPS)
    assert fit_order(h, np.full(6, 1e-7)) is None
    assert fit_order(h, np.array([1e-3, 1e-9, 1e-4, 1e-10, 1e-5, 1e-11])) is None
    assert fit_order(h[:2], h[:2] ** 2) is None


def test_a_step_control_that_rounds_its_counts_still_shows_its_slope():
    wanted = 10.0 ** -np.arange(3, 12)
    evaluations = 12 * np.ceil(3.0 * wanted ** (-1.0 / 8.0))
    fit = fit_order(1.0 / evaluations, wanted, SCATTERED)
    assert fit.order.value == pytest.approx(8.0, abs=0.5)  # a step more or less in ten, at either end


def test_a_fitted_order_covers_the_true_one_as_often_as_it_says():
    h, rng = 1.0 / np.array(STEPS), np.random.default_rng(3)
    fits = [fit_order(h, h**2 * np.exp(0.02 * rng.standard_normal(6))) for _ in range(200)]
    covered = [f.order.low <= 2.0 <= f.order.high for f in fits if f and f.points == 6]
    assert len(covered) > 150
    assert np.mean(covered) > 0.90  # 95 % wanted; of 150 draws the standard error is 1.8 %


def reach_of(points, times=None):
    """Attitude over seconds, by target and engine."""
    found = reach_table(points, times or {}).query("quantity == 'attitude' and measure == 'seconds'")
    return found.set_index(["engine", "target"])


def test_interpolation_is_exact_on_power_laws():
    points = table(engine_points("a", 2.0, 1e-3, STEPS), engine_points("b", 2.0, 3e-3, STEPS))
    reach = reach_of(points, times_of(points, spread=0.0))
    assert reach.cost["a", 1e-2] == pytest.approx(1e-3 * 100.0, rel=ROUNDING)  # (10/n)² = 1e-2 at n = 100
    assert reach.over_fastest["b", 1e-2] == pytest.approx(3.0, rel=ROUNDING)
    assert reach.fastest["a", 1e-2] == "a"


def test_what_is_not_reached_stays_not_reached_and_what_the_oracle_cant_tell_has_no_verdict():
    points = table(engine_points("a", 2.0, 1e-3, STEPS))
    reach = reach_of(points).loc["a"]
    assert reach.status[1e-4] == "not reached"  # the finest has 2.4e-4
    assert reach[["cost", "over_fastest"]].loc[1e-4].isna().all()
    reach = reach_of(points.assign(attitude_floor_rad=1e-10)).loc["a"]
    assert reach.status[1e-8] == "not reached"
    assert reach.status[1e-10] == "no verdict"


def test_a_coarsest_run_that_is_good_enough_is_a_bound_not_a_measurement():
    points = table(engine_points("a", 6.0, 1e-3, [20, 40, 80]))
    assert 2.0**-6 > 1e-2
    assert reach_of(points).status["a", 1e-2] == "reached"
    reach = reach_of(points[1:])
    assert reach.status["a", 1e-2] == "at most"
    assert reach.cost["a", 1e-2] == pytest.approx(0.04)


def test_failed_points_count_for_nothing_and_cost_only_themselves():
    good = engine_points("a", 2.0, 1e-3, STEPS)
    failed = point("a", 9999, 1e-12, 1e-9) | {"outcome": "failed", "attitude_error_rad": math.nan}
    loose = point("a", 8888, 1e-12, 1e-9) | {"outcome": "joints_ignored"}
    assert not front_of(table(good, [failed, loose]))[-2:].any()
    left, right = (reach_table(table(good, extra), {}) for extra in ([], [failed, loose]))
    pd.testing.assert_frame_equal(left.drop(columns="reason"), right.drop(columns="reason"))


@pytest.mark.parametrize(
    ("outcome", "shown"),
    [
        ("timed_out", "timed out"),
        (NotRun.LIMIT, "not run: time limit"),
        (NotRun.BLURRED, "not reached"),
    ],
)
def test_a_cell_says_why_an_error_was_not_reached(outcome, shown):
    finest = point("a", 9999, 1e-5, 1.0) | {"outcome": str(outcome), "reason": ""}
    late = [p | {"outcome": str(outcome), "reason": ""} for p in engine_points("b", 2.0, 1e-3, STEPS)]
    found = reach_of(table(engine_points("a", 2.0, 1e-3, STEPS), [finest], late))
    for engine in "ab":  # of which b was never good
        last = found.loc[engine, 1e-8]
        assert (last.reason or last.status) == shown


def test_the_front_is_what_no_other_point_beats():
    error, cost = np.array([1e-2, 1e-3, 1e-4, 1e-3, np.nan, 1e-5]), np.array([1.0, 2.0, 3.0, 2.5, 0.1, 3.0])
    assert on_front(error, cost).tolist() == [True, True, False, False, False, True]
    envelope = lower_envelope(error.tolist(), cost.tolist())
    assert (np.diff(envelope.error) < 0).all()
    assert (np.diff(envelope.cost) > 0).all()
    assert locate(envelope, 1e-6) is None


def test_one_more_digit_costs_the_root_of_ten_at_second_order():
    points = table(engine_points("a", 2.0, 1e-3, STEPS), engine_points("b", 8.0, 1e-3, [20, 30, 40, 50]))
    price = price_table(points).query("measure == 'seconds'").set_index("engine").factor
    assert price["a"] == pytest.approx(10 ** (1 / 2), rel=ROUNDING)
    assert price["b"] == pytest.approx(10 ** (1 / 8), rel=ROUNDING)


def test_the_order_row_leaves_out_what_lies_under_the_oracles_floor():
    rows = table(engine_points("a", 6.0, 1e-3, [20, 40, 80, 160, 320, 640, 1280, 2560, 5120], least=3.0 * FLOOR))
    row = order_row(rows, "attitude", 6.0)
    assert row["order"] == pytest.approx(6.0, abs=ROUNDING)
    assert row["error_to"] >= 10.0 * FLOOR


def test_a_bootstrap_interval_covers_a_ratio_as_often_as_it_says():
    rng = np.random.default_rng(5)
    covered = 0
    for _ in range(100):
        a, b = (np.exp(0.1 * rng.standard_normal(15)) for _ in range(2))
        spread = interval(float(np.median(a) / np.median(b)), [(1.0, a), (-1.0, b)])
        covered += spread.low <= 1.0 <= spread.high
    assert covered > 85  # 95 % wanted; percentile intervals of a median of 15 are known to fall a little short


def test_few_times_give_their_range_and_one_gives_none():
    assert median_time(np.array([1.0, 2.0, 4.0])).low == pytest.approx(1.0)
    assert median_time(np.array([1.0, 2.0, 4.0])).high == pytest.approx(4.0)
    assert math.isnan(median_time(np.array([1.0])).low)
    assert median_time(np.full(7, 2.0)) == interval(2.0, [(1.0, np.full(7, 2.0))])


@pytest.fixture(scope="module")
def solution():
    return certified_stand_in(shortened(load_scene("basics/two_bars_free")))


def test_errors_are_the_largest_up_to_the_truths_horizon(solution):
    seen = solution.trajectory
    off = np.linspace(0.0, 1e-6, len(seen.t_s))
    moved = seen.replace(angle_rad=seen.angle_rad + off[:, None])
    assert errors_of(solution, moved)["attitude_error_rad"] == pytest.approx(1e-6)
    bound = solution.error | {"attitude": np.where(np.arange(len(off)) > 10, 1.0, 1e-12)}
    parted = SimpleNamespace(**{**vars(solution), "error": bound})
    assert errors_of(parted, moved)["attitude_error_rad"] == pytest.approx(off[10])


def test_errors_near_the_oracles_own_are_marked(solution):
    seen = solution.trajectory
    moved = seen.replace(angle_rad=seen.angle_rad + 9e-12, com_m=seen.com_m + 1e-3)
    marked = under_floor(errors_of(solution, moved))
    assert "attitude" in marked
    assert "com" not in marked
    assert "attitude" not in under_floor(errors_of(solution, seen.replace(angle_rad=seen.angle_rad + 2e-11)))


def test_a_particle_is_judged_on_its_own_track_and_has_no_other_errors():
    scene = shortened(load_scene("paper/fig09"), 0.2)
    solution = certified_stand_in(scene)
    loaded = ENGINES["rebound"].load()
    errors = errors_of(solution, loaded().run(scene))
    assert set(errors) == {"com_error_m", "com_floor_m"}
    assert errors["com_error_m"] < 10.0 * errors["com_floor_m"] < 1e-2  # m: the chain leaves Kepler by that much


def test_settings_that_round_to_the_same_steps_are_run_once():
    scene, loaded = shortened(load_scene("paper/fig05")), ENGINES["exudyn-tree"].load()
    found = distinct(scene, dataclasses.replace(loaded.sweep, values=(10, 20, 40, 80)))
    assert [s.value for s in found] == [10, 80]


def test_engines_that_cant_run_a_scene_are_named_with_the_reason():
    scene = shortened(load_scene("paper/fig17"))
    missing = dataclasses.replace(ENGINES["exudyn"], module="no_such_module_here")
    runs, out = sweeps(scene, {"exudyn": missing, "pymunk": ENGINES["pymunk"], "reference": ENGINES["reference"]})
    assert list(runs) == ["reference"]
    assert {o.engine: str(o.outcome) for o in out} == {"exudyn": "missing", "pymunk": "unsupported"}
    assert all(len(o.reason.split()) > 3 for o in out)
