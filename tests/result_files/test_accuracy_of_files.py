"""Accuracy that a file has, declared or found: what its bound allows, and what is told of it."""

import dataclasses
import math

import numpy as np
import pandas as pd
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.kepler import propagate
from adapters.trajectory import to_frame
from barchain import load_scene, simulate
from barchain.judge.local_errors import elastic_decay_1_s
from barchain.judge.written import Declared
from barchain.result_files.judging import solution_of as judging_solution
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import closely_sampled
from reports.results.outcome import Outcome
from tests.result_files.examples import HINGED, PANEL, TRACK, diverged

FREE = "basics/two_bars_free"
THREE = "conform/three_bars_gradient"
AT_1E7 = Declared(rtol=1e-7)


@pytest.mark.parametrize("declared", [Declared(), Declared(rtol=1e-6)])
def test_a_quantity_that_is_far_less_accurate_than_the_others_is_told(right, verdict_alone, declared):
    coarse = right.reaction_1_x_N * (1.0 + 1e-4 * (right.t_s > 1000.0))
    found = verdict_alone(right.assign(reaction_1_x_N=coarse), declared)
    assert found.passed
    assert any("reaction: no better than rtol=" in said for said in (*found.advice, *found.notes))
    plain = verdict_alone(right, declared)
    assert not any("no better than" in said for said in (*plain.advice, *plain.notes))


def test_two_files_that_show_a_lower_order_than_the_declared_one_are_warned_of(judged):
    coarse, fine = (simulate("basics/libration", "mujoco", steps_per_orbit=n).to_frame() for n in (1000, 2000))
    declared = [judged(coarse, Declared(order=order), finer=fine, scene="basics/libration") for order in (4.0, 6.0)]
    assert [any("show errors of order" in note for note in found.notes) for found in declared] == [False, True]


@pytest.mark.exhaustive
def test_a_right_file_of_a_scene_of_early_limits_passes_from_its_own_states_and_a_part_of_it_says_how_far(judged):
    scene = load_scene("hard/whip")
    whole = simulate(scene, "reference", rtol=1e-12).to_frame().filter(regex="^(t_s|com_[xyv]|angle|rate|reaction)")
    found = judged(whole, scene=scene)
    assert found.passed, found.reasons
    assert found.advice[0].startswith("agrees at rtol=1e-12")
    part = judged(whole.filter(regex="^(t_s|angle)"), scene=scene)
    assert part.outcome is Outcome.TOO_COARSE
    assert part.advice == ["it agrees at rtol=1e-12 as far as it can be judged"]


@pytest.mark.slow
def test_numbers_that_were_rounded_before_they_were_written_in_full_are_told_as_that(right, judged):
    """6728000.0 has eight digits, of which six count; reversed reactions are wrong all the same."""
    rounded = right.iloc[:21:2].map(lambda value: float(f"{value:.6g}"))
    found = judged(rounded)
    assert not found.passed
    assert not found.mistakes
    assert "--digits 6" in " ".join(found.advice)
    reversed_ones = {name: -rounded[name] for name in rounded if name.startswith("reaction")}
    assert "--digits" not in " ".join(judged(rounded.assign(**reversed_ones)).advice)


def test_a_right_file_passes_at_the_accuracy_that_it_has_and_is_told_it(right, judged, verdict_alone):
    found = judged(right)
    assert found.passed
    assert found.advice[0].startswith("agrees at rtol=1e-")
    notes = verdict_alone(right, Declared(rtol=1e-7)).notes
    assert any("requested: rtol=1e-07; reached: rtol=1e-1" in note for note in notes)
    assert not verdict_alone(diverged(right, "angle", 1e-5)).passed


def rounded(kind, size, seed, shared=0.0):
    """Certified run whose columns of a kind walk at random by a size, (1 + shared) times too large."""
    frame = to_frame(shipped_solution(closely_sampled(load_scene(THREE))).trajectory)
    columns = [name for name in frame if name.startswith(kind)]
    walk = np.random.default_rng(seed).normal(size=(len(frame), len(columns))).cumsum(axis=0) / math.sqrt(len(frame))
    return frame.assign(
        **{columns[k]: (1.0 + shared) * frame[columns[k]] + size * walk[:, k] for k in range(len(columns))}
    )


@pytest.mark.parametrize(("kind", "quantity", "size"), [("com_", "com", 5e-6), ("reaction", "reaction", 1e-8)])
def test_errors_that_are_rounding_are_told_with_a_declaration_with_which_the_files_pass(judged, kind, quantity, size):
    """5e-6 m are 3300 roundings of 6728 km, as an extrapolation of order 16 in absolute coordinates leaves."""
    main, finer = (rounded(kind, size, seed) for seed in (1, 2))
    declared = Declared(order=16.0, absolute=quantity == "com")
    found = judged(main, declared, finer, THREE)
    assert found.outcome is Outcome.INCONSISTENT
    (said,) = found.advice
    assert said.startswith("Round-off")
    noise = {quantity: float(said.rpartition(f"--noise {quantity}=")[2])}
    assert size < noise[quantity] < 10.0 * size
    assert judged(main, dataclasses.replace(declared, absolute=True, noise=noise), finer, THREE).passed


@pytest.mark.parametrize(("size", "shared"), [(1e-6, 3e-12), (1e-2, 0.0)])
def test_an_error_that_two_files_share_and_one_that_is_far_larger_are_no_rounding(verdict_alone, size, shared):
    main, finer = (rounded("com_x", size, seed, shared) for seed in (1, 2))
    found = verdict_alone(main, Declared(order=16.0, absolute=True), finer, THREE)
    assert not found.passed
    assert not any("Round-off" in said for said in found.advice)


def test_a_stated_error_bar_is_what_a_file_is_judged_by_however_wide(right, verdict_alone):
    angles = right[["t_s", "angle_1_rad", "angle_2_rad"]]
    off = angles.assign(angle_1_rad=angles.angle_1_rad + 5e-5 * np.sin(angles.t_s))
    assert verdict_alone(off, Declared(noise={"attitude": 6e-5})).passed
    assert not verdict_alone(off, Declared(noise={"attitude": 1e-6})).passed
    assert not verdict_alone(off, Declared(rtol=1e-9)).passed


def test_damped_joints_decay_as_the_closed_form_of_two_bars_says(scene_of):
    """Bars of inertia J turned against each other by b: J/2 b'' + c b' + k b = 0, its envelope is exp(-c t/J)."""
    scene = scene_of(HINGED)
    solution = judging_solution(closely_sampled(scene), 60.0)
    expected = 0.25 / scene.chain.inertia_kg_m2[0]
    assert math.isclose(elastic_decay_1_s(solution), expected, rel_tol=1e-9)
    assert elastic_decay_1_s(shipped_solution(load_scene(FREE))) == 0.0


def test_a_constant_force_leaves_no_error_however_large_a_request_is(judged, scene_of):
    """A request of 1e-7 counts in the distance of 6.7e6 m; a method gives a constant force no other weight."""
    scene = scene_of(PANEL)
    t = np.linspace(0.0, 86400.0, 97)
    right = np.array([-3.648e-7, -5.472e-7])  # m/s^2: light and its reflection along the normal
    for acceleration, passes in ((right, True), ([-5.472e-7, -5.472e-7], False)):
        place = 0.5 * np.outer(t**2, acceleration) + [scene.radius0_m, 0.0]
        found = judged(pd.DataFrame({"t_s": t, "com_x_m": place[:, 0], "com_y_m": place[:, 1]}), AT_1E7, scene=scene)
        assert found.passed is passes
    assert "along the Sun's line" in found.mistakes


def test_a_mistake_inside_the_bound_of_a_request_is_told_and_a_method_s_own_error_is_none(judged, scene_of):
    scene, start = scene_of(TRACK), initial_state(scene_of(TRACK))
    t = np.linspace(0.0, 29000.0, 301)
    place, _ = propagate(1.000003 * scene.central_body.mu_m3_s2, start.com_m, start.com_velocity_m_s, t)
    frame = pd.DataFrame({"t_s": t, "com_x_m": place[:, 0], "com_y_m": place[:, 1]})
    found = judged(frame, AT_1E7, scene=scene)
    assert found.passed
    assert any("no error of a method: the gravitational parameter is" in note for note in found.notes)
    rough = simulate(scene, "reference", rtol=1e-7).to_frame()[list(frame)]
    assert not any("warning" in note for note in judged(rough, AT_1E7, scene=scene).notes)
