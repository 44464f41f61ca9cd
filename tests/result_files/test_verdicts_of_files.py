"""Verdicts on files: what diverged, what was written at other times, and what declares no accuracy."""

import dataclasses
import math
import re

import numpy as np
import pytest

from adapters.common.kepler import propagate
from adapters.trajectory import to_frame
from barchain import change_scene, load_scene, simulate
from barchain.judge.diagnosis.trials import moved_start
from barchain.judge.written import Declared
from barchain.metrics.quantities import differences, drifts
from barchain.result_files.judging import solution_of as judging_solution
from barchain.result_files.table import TableError
from barchain.solutions.at_times import solution_at
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import closely_sampled
from reports.results.outcome import Outcome
from scenarios.scene import Run
from tests.result_files.examples import DRAG, HINGED, TRACK, diverged, frame_of

FREE = "basics/two_bars_free"
NOTHING = Declared()
STATES = "^(t_s|com_[xyv]|angle|rate)"
"""Columns of the states"""


@pytest.mark.parametrize("kind", ["angle", "reaction", "com_x"])
def test_a_diverged_quantity_has_no_error_bar_of_its_own_size_nor_of_another_such_file(right, verdict_alone, kind):
    wrong = diverged(right, kind, 0.6)
    assert not verdict_alone(wrong, Declared(rtol=1e-9)).passed
    one = right.copy()
    column = next(name for name in right if name.startswith(kind))
    one.loc[150, column] = 1e19
    assert not verdict_alone(one[["t_s", column]], Declared(rtol=1e-9)).passed
    for order in None, 2.0:
        assert not verdict_alone(wrong, Declared(order=order), diverged(right, kind, 0.55)).passed


@pytest.mark.parametrize(
    ("change", "declared", "said"),
    [
        (lambda f: f.assign(angle_1_rad=f.angle_1_rad + 1e-3 * (f.index == 150)).iloc[::5], Declared(rtol=1e-9),
         "One sample is off: angles 0.001 rad of .*at t = 1500 s alone"),
        (lambda f: f.assign(com_x_m=f.com_x_m + 3.0), NOTHING, "start|initial|off"),
        (lambda f: f.assign(angle_1_rad=f.angle_1_rad + 1e-2 * np.cos(f.t_s / 70.0)).iloc[::4], Declared(rtol=1e-9),
         "at t = 0 the attitude is 0.01 rad off the scene's start"),
        (lambda f: f.assign(angle_1_rad=f.angle_1_rad * 1e8 ** (f.t_s > 1800.0)).iloc[::4], NOTHING,
         "departs at t = 1840 s"),
        (lambda f: f.assign(reaction_1_x_N=-f.reaction_1_y_N, reaction_1_y_N=0.0).drop(columns="com_x_m").iloc[::25],
         Declared(rtol=1e-9), ""),
    ],
    ids=["one cell", "another start", "start of a swing", "diverged at its end", "and a part of the track lacks"],
)  # fmt: skip
def test_a_wrong_file_agrees_at_no_request_and_what_is_wrong_is_told(right, judged, change, declared, said):
    found = judged(change(right), declared)
    assert found.outcome is Outcome.INCONSISTENT
    assert not any(sentence.startswith("agrees at") for sentence in found.advice)
    assert re.search(said, " ".join([found.mistakes, *found.advice]), re.DOTALL)


def test_a_mistake_is_named_in_a_single_column_and_not_of_columns_that_the_file_lacks(right, judged):
    one = right[["t_s", "angle_1_rad"]]
    assert judged(one).passed
    found = judged(one.assign(angle_1_rad=np.degrees(one.angle_1_rad)), Declared(rtol=1e-9))
    assert found.advice == []
    assert "Your angles are in degrees" in found.mistakes
    assert "rates" not in found.mistakes


def test_two_files_whose_invariants_drift_alike_by_chance_pass_as_their_states_do(verdict_alone):
    coarse, fine = (simulate(FREE, "reference", rtol=rtol) for rtol in (1e-7, 1e-8))
    one, two = (drifts(load_scene(FREE), run)["angular_momentum"][1] for run in (coarse, fine))
    assert abs(one - two) < 0.1 * one, "the change says less than a fifth of the first sample's drift"
    assert verdict_alone(coarse.to_frame(), finer=fine.to_frame()).passed
    lost = fine.to_frame().assign(rate_2_rad_s=lambda f: f.rate_2_rad_s * (1.0 + 1e-7 * f.t_s / 2000.0))
    assert not verdict_alone(lost, finer=lost.assign(angle_1_rad=lost.angle_1_rad + 1e-9)).passed


@pytest.mark.slow
def test_what_is_right_in_a_wrong_file_is_not_told_as_wrong(right, verdict_alone):
    found = verdict_alone(right.assign(angle_1_rad=right.angle_1_rad + 1e-3 * (right.t_s > 1500.0)))
    assert not found.passed
    assert any("attitude" in reason for reason in found.reasons)
    assert not any(reason.startswith(("rate", "reaction")) for reason in found.reasons)


def test_no_start_is_tried_whose_run_would_not_end():
    scene = load_scene(FREE)
    amounts = np.zeros(4 + 2 * scene.bars)
    assert moved_start(scene, True, amounts, np.array([0.0, 10.0])) is not None
    amounts[-1] = 1e9
    assert moved_start(scene, True, amounts, np.array([0.0, 10.0])) is None


def test_a_quantity_that_is_there_and_says_nothing_is_no_pass(right, verdict_alone):
    angles = right[["t_s", "angle_1_rad", "rate_1_rad_s"]].round({"angle_1_rad": 6}).assign(rate_1_rad_s=0.0)
    found = verdict_alone(angles, float_format="%.6f")
    assert found.outcome is Outcome.INCONSISTENT, "six decimals of a rate are enough"
    found = verdict_alone(angles.assign(rate_1_rad_s="0.0"))
    assert found.outcome is Outcome.TOO_COARSE
    assert any("rate" in reason and "last digit" in reason for reason in found.reasons)


def test_the_error_bar_at_other_times_contains_keplers_track(scene_of):
    scene = scene_of(TRACK)
    t = np.append(0.0, np.sort(np.random.default_rng(7).uniform(0.0, 29_000.0, 40)))
    found = solution_at(judging_solution(closely_sampled(scene), 60.0), t)
    track = (found.trajectory.com_m, found.trajectory.com_velocity_m_s)
    kepler_track = propagate(scene.central_body.mu_m3_s2, *(each[0] for each in track), t)
    for name, seen, kepler in zip(("com", "com_velocity"), track, kepler_track, strict=True):
        rounding = 1e3 * np.finfo(float).eps * np.linalg.norm(kepler, axis=1)  # of Kepler's equation after five orbits
        assert np.all(np.linalg.norm(seen - kepler, axis=1) <= found.error[name] + rounding)
    assert found.error["com"].max() < 1e-4, "and is far below a metre"


def test_the_error_bar_at_other_times_contains_a_run_with_samples_there(scene_of):
    scene = closely_sampled(scene_of(DRAG))
    own = scene.run.samples - 1
    between = dataclasses.replace(scene, run=Run(scene.run.duration_s, 3 * own + 1))
    other = simulate(between, "reference-wide", rtol=1e-17).samples(slice(None, None, 31))
    found = solution_at(judging_solution(scene, 60.0), other.t_s)
    for name, apart in differences(found.trajectory, other).items():
        assert np.all(apart <= found.error[name]), name


@pytest.mark.parametrize("first_row", [True, False])
def test_instants_that_are_late_are_named_with_and_without_the_row_of_the_start(judged, first_row):
    scene = load_scene("conform/three_bars_gradient")
    motion = solution_at(shipped_solution(scene), np.arange(0.0, 1185.1, 15.0) + 2.5 * (np.arange(80) > first_row - 1))
    frame = motion.trajectory.to_frame().assign(t_s=np.arange(80) * 15.0)
    found = judged(frame.filter(regex=STATES), scene=scene)
    assert not found.passed
    assert "2.5 s early" in found.mistakes
    assert ("after the first row" in found.mistakes) is first_row


def test_two_mistakes_in_few_rows_of_one_column_get_no_wrong_name(judged, scene_of):
    """Rates of an undamped motion, of instants 0.05 s too late: after the first row, nothing is judged at rtol=1e-4."""
    damped = scene_of(HINGED.replace("angle_deg = 0.0", "angle_deg = [-10.0, 10.0]"))
    free = change_scene(damped, {"effects": {"joint_spring_damper": {"damping_N_m_s_rad": 0.0}}})
    motion = solution_at(judging_solution(closely_sampled(free), 60.0), np.arange(0.05, 1.0, 0.06)).trajectory
    rows = to_frame(motion)[["t_s", "rate_2_rad_s"]].round(4)
    found = judged(rows.assign(t_s=rows.t_s - 0.05), scene=damped)
    assert not found.passed
    assert not found.mistakes or found.mistakes.startswith("No known mistake"), found.mistakes
    assert any("at t = 0 the rate is" in said for said in found.advice)


@pytest.mark.parametrize("how", ["frozen", "garbage", "a step"])
def test_a_tail_beyond_the_limit_that_no_error_grows_into_fails(verdict_alone, how):
    """Of a chaotic scene: a file agrees as less accurate ones do until there, and the solution is known for longer."""
    scene = load_scene("paper/fig05")
    frame = to_frame(shipped_solution(scene).trajectory)[["t_s", *(f"angle_{j}_rad" for j in range(1, 6))]].iloc[::5]
    assert verdict_alone(frame, scene=scene).passed
    wrong = frame.copy()
    tail, angles = frame.t_s > 0.3 * scene.run.duration_s, frame.columns[1:]
    right = frame.loc[tail, angles].to_numpy()
    wrong.loc[tail, angles] = {
        "frozen": np.broadcast_to(right[0], right.shape),
        "garbage": 1e6 * np.sin(np.arange(len(right)))[:, None] + np.zeros_like(right),
        "a step": right + 1.0,
    }[how]
    found = verdict_alone(wrong, scene=scene)
    assert not found.passed
    assert any("far faster than errors grow" in reason for reason in found.reasons)


@pytest.mark.parametrize("kinds", ["com_._m", "com_"])
def test_a_track_that_moves_at_once_fails_though_parted_attitudes_could_move_it_as_far(verdict_alone, kinds):
    scene = load_scene("paper/fig05")
    frame = to_frame(shipped_solution(scene).trajectory).filter(regex=f"^(t_s|{kinds})").iloc[::5]
    assert verdict_alone(frame, Declared(rtol=1e-10), scene=scene).passed
    frame.loc[frame.t_s > 0.9 * scene.run.duration_s, "com_x_m"] += 5.0
    found = verdict_alone(frame, Declared(rtol=1e-10), scene=scene)
    assert not found.passed
    assert any("the track leaves the solution by 5 m" in reason for reason in found.reasons)


@pytest.mark.parametrize("digits", [5, 9])
def test_a_right_track_whose_numbers_gain_a_place_does_not_move_at_once(judged, digits):
    """Where a coordinate passes a power of ten, the rows on its two sides are rounded to units ten times apart."""
    scene = load_scene("paper/fig13")
    frame = to_frame(shipped_solution(scene).trajectory)[["t_s", "com_x_m", "com_y_m"]].iloc[::5]
    for column in ("com_x_m", "com_y_m"):
        frame[column] = [f"{value:.{digits}g}" for value in frame[column]]
    found = judged(frame, scene=scene)
    assert found.passed, found.reasons


def test_a_track_that_scatters_within_its_stated_error_bar_does_not_move_at_once(judged):
    scene = load_scene("paper/fig13")
    frame = to_frame(shipped_solution(scene).trajectory)[["t_s", "com_x_m", "com_y_m"]].iloc[::5]
    frame["com_x_m"] += np.random.default_rng(1).uniform(-3.0, 3.0, len(frame))
    assert judged(frame, Declared(noise={"com": 5.0}), scene=scene).passed


@pytest.mark.parametrize("seed", range(2))
def test_a_right_file_at_uneven_instants_passes(judged, seed):
    """The balance of energy and momentum is a quadrature over the rows: one can't tell more than they do."""
    scene = load_scene("effects/mid_orbit")
    times = np.sort(np.random.default_rng(seed).uniform(0.0, scene.run.duration_s, 60))
    motion = solution_at(shipped_solution(scene), np.append(0.0, times)).trajectory
    found = judged(to_frame(motion).filter(regex=STATES), Declared(rtol=1e-10), scene=scene)
    assert found.passed, found.reasons


@pytest.mark.slow
def test_a_coarse_column_hides_no_error_of_the_columns_beside_it(right, verdict_alone):
    few = right[["t_s", "angle_1_rad", "angle_2_rad"]].assign(angle_2_rad=right.angle_2_rad.round(1))
    found = verdict_alone(few)
    assert found.passed
    assert any("fewer digits than columns beside it: angle_2" in note for note in found.notes)
    wrong = few.assign(angle_1_rad=few.angle_1_rad + 0.03 * np.sin(few.t_s / 300.0))
    for declared in (NOTHING, Declared(rtol=1e-9)):
        assert not verdict_alone(wrong, declared).passed
    assert not verdict_alone(few.assign(angle_2_rad=few.angle_2_rad + 0.2)).passed


def test_a_file_of_fewer_bars_than_a_scene_without_a_solution_is_refused_before_any_run(right, judged, scene_of):
    scene = scene_of(HINGED.replace("bars = 2", "bars = 10000").replace("samples = 11", "samples = 3"))
    with pytest.raises(TableError, match="has columns of 2 bars, and the scene has 10000"):
        judged(right, scene=scene)


def test_bars_that_start_at_rest_have_no_factor_of_their_rates(judged):
    few = frame_of("paper/fig13", rtol=1e-9).filter(regex=STATES).iloc[:21:4]
    rates = {name: few[name] + 1e-4 for name in few if name.startswith("rate")}
    assert not judged(few.assign(**rates), scene="paper/fig13").passed


def test_the_diagnosis_of_a_long_file_looks_at_some_of_its_rows_and_says_so(right, judged, monkeypatch):
    monkeypatch.setattr("barchain.judge.diagnosis.verdicts.MOST_SAMPLES", 101)
    found = judged(right.assign(angle_1_rad=-right.angle_1_rad))
    assert found.outcome is Outcome.INCONSISTENT
    assert "bar 1" in found.mistakes
    assert "mistakes are sought in one of 2 rows, 101 in all" in found.notes


@pytest.mark.parametrize("moved_s", [1e-6, -1e-6])
def test_states_belong_to_the_written_instants_however_near_these_are_to_samples_of_the_scene(judged, moved_s):
    """A track at 7.7 km/s moves 8 mm in a microsecond, 1e5 times the error of a run at rtol=1e-12."""
    solution = shipped_solution(closely_sampled(load_scene(FREE)))
    own = np.arange(10.0, 1990.0, 40.0)
    moved = to_frame(solution_at(solution, own + moved_s).trajectory).filter(regex=STATES)
    assert judged(moved, Declared(rtol=1e-12)).passed
    found = judged(moved.assign(t_s=own), Declared(rtol=1e-12))
    assert not found.passed
    assert "1e-06 s early" in found.mistakes if moved_s > 0.0 else "1e-06 s late" in found.mistakes


@pytest.mark.parametrize("late_s", [1e-3, 10.0])
def test_a_late_clock_is_told_where_the_first_row_shows_the_start(judged, late_s):
    motion = shipped_solution(closely_sampled(load_scene(FREE))).trajectory
    frame = to_frame(motion).filter(regex=STATES).iloc[:-60:4]
    found = judged(frame.assign(t_s=frame.t_s + late_s))
    assert not found.passed
    told = re.match(r"Your instants are (\S+) s late", found.mistakes)
    assert told, found.mistakes
    assert math.isclose(float(told[1]), late_s, rel_tol=1e-3)
