"""One contract, kept by every engine on every scene."""

import dataclasses
import functools
import os

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.registry import ENGINES
from adapters.trajectory import Observable, Trajectory, from_frame, to_frame
from barchain.runs.trajectory_checks import fault
from scenarios import load_scene
from tests.support.changed import lasting
from tests.support.scene_lists import ALL, TAME
from tests.support.slow import left_to_later
from tests.support.solutions import run

SHARE = 0.04  # of the run: long enough to move, short enough for every pair
SAMPLES = 9
# A coarse setting each: the contract is about meaning, accuracy is the comparison's business.
# Reactions of index 3 in inertial coordinates get worse as the square of the number of steps: of short bars, at once.
# An arm that is pushed moves at once, in 60 s of an orbit: of steps per orbit it needs many.
BY_STEPS = ("exudyn", "exudyn-index3", "exudyn-absolute", "exudyn-absolute-index3", "pymunk", "pymunk-absolute")
COARSE = {
    ("exudyn-absolute-index3", "effects/slews"): 1000,
    ("exudyn-absolute-index3", "effects/joint_motors"): 4000,
    **{(engine, "effects/free_flyer"): 40000 if "pymunk" in engine else 20000 for engine in BY_STEPS},
}
scene_named = functools.cache(load_scene)  # read once, not once for each engine
HERE = {name: registration for name, registration in ENGINES.items() if registration.missing is None}
EXTERNAL = [name for name, registration in HERE.items() if registration.external]


def shortened(name):
    scene = scene_named(name)
    return lasting(scene, SHARE * scene.run.duration_s, SAMPLES)


COMPILES_FOR_SECONDS = {
    "heyoka": ("effects/everything",),
    "heyoka-long": ("paper/fig13",),
    "heyoka-quad": ("basics/kepler_circular",),
}
"""Engines that compile each scene for seconds, with the scenes on which every run of the tests tries them"""


PAIRS = [
    (engine, name)
    for engine, registration in HERE.items()
    for name in TAME
    if registration.load().unsupported(scene_named(name)) is None
]


SHARE_OF_PAIRS = 4
STEPS_FOR_SECONDS = [("ida-index2", "published/tips")]
"""Pairs that take 15 000 steps for 4 % of the run"""


def quick(engine, name):
    """Whether the default run tries a pair: each engine on each fourth scene, and each scene in each fourth engine."""
    if (engine, name) in STEPS_FOR_SECONDS:
        return False
    if engine in COMPILES_FOR_SECONDS:
        return name in COMPILES_FOR_SECONDS[engine]
    return (list(HERE).index(engine) + TAME.index(name)) % SHARE_OF_PAIRS == 0


@pytest.mark.parametrize(("engine", "name"), left_to_later((pytest.param(*pair), quick(*pair)) for pair in PAIRS))
def test_an_engine_returns_what_it_declares_in_the_common_units_axes_and_signs(
    engine, name, tmp_path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    scene, loaded = shortened(name), ENGINES[engine].load()
    setting = loaded.sweep.finer(loaded.sweep.setting(COARSE.get((engine, name))))
    seen = loaded().run(scene, setting)
    assert fault(scene, loaded, seen) is None
    assert seen.observables - {Observable.TORQUE, Observable.IMPULSE} <= loaded.observables
    printed = capfd.readouterr()
    assert printed.out + printed.err == ""
    assert list(tmp_path.iterdir()) == []
    starts_at_the_initial_state(scene, seen)
    means_the_same(scene, seen, run(scene, 1e-12))


def starts_at_the_initial_state(scene, seen):
    start = initial_state(scene)
    assert np.abs(seen.com_m[0] - start.com_m).max() <= 4 * np.spacing(scene.radius0_m)
    assert np.abs(seen.com_velocity_m_s[0] - start.com_velocity_m_s).max() <= 1e-9 * max(scene.speed0_m_s, 1.0)
    if seen.angle_rad is not None:
        # an angle got back from absolute positions carries their rounding
        assert np.abs(seen.angle_rad[0] - start.angle_rad).max() <= 4 * np.spacing(scene.radius0_m) / min(
            scene.chain.length_m
        )


def means_the_same(scene, seen, solution):
    """Signs, frames and order of joints: a tenth of a percent of the largest value tells them apart."""
    tenth_percent = 1e-3
    assert np.abs(seen.com_m - solution.com_m).max() <= 1e-6 * scene.radius0_m
    for mine, theirs in ((seen.angle_rad, solution.angle_rad), (seen.rate_rad_s, solution.rate_rad_s)):
        if mine is not None:
            assert np.abs(mine - theirs).max() <= tenth_percent * max(np.abs(theirs - theirs[0]).max(), 1e-3)
    scale = (
        scene.mass_kg * max(scene.chain.length_m) * scene.mean_motion_rad_s**2
    )  # m n² l: the horizontal chain's own vanish
    for mine, theirs in ((seen.reaction_N, solution.reaction_N), (seen.torque_N_m, solution.torque_N_m)):
        if mine is not None and mine.size:
            # index 3 starts its multipliers with an error of first order in the step and damps it in some 50 steps
            assert np.abs(mine - theirs).max() <= 20 * tenth_percent * max(np.abs(theirs).max(), scale)


def test_no_engine_is_left_out_everywhere():
    assert {engine for engine, _ in PAIRS} == set(HERE)


@pytest.mark.skipif("BARCHAIN_ALL_ENGINES" not in os.environ, reason="extras are optional; CI has all of them")
def test_no_engine_is_missing():
    missing = {name: r.missing for name, r in ENGINES.items() if r.missing}
    assert missing.keys() <= {"drake"}, missing  # the extra `all` leaves Drake out: it requires a proprietary wheel


@pytest.mark.parametrize("name", TAME)
def test_every_scene_is_carried_by_an_external_engine_with_reactions_or_has_none(name):
    carried = {e for e, scene in PAIRS if scene == name and e in EXTERNAL}
    assert carried - {"rebound"}


@pytest.mark.parametrize("engine", HERE)
def test_an_unsupported_effect_has_a_reason(engine):
    loaded = ENGINES[engine].load()
    for name in ALL:
        scene = scene_named(name)
        reason = loaded.unsupported(scene)
        assert reason is None or len(reason.split()) > 3, (engine, name, reason)


@pytest.mark.parametrize("engine", HERE)
def test_ladders_run_from_coarse_to_fine_and_hold_their_default(engine):
    sweep = ENGINES[engine].load().sweep
    finer = np.diff(sweep.values) < 0 if sweep.parameter == "rtol" else np.diff(sweep.values) > 0
    assert finer.all()
    assert sweep.default in sweep.values


def test_torques_keep_their_bars_in_a_table_in_the_order_of_the_rotations():
    t, com = np.arange(3.0), np.ones((3, 2))
    torque = np.array([[5.0, 2.0], [50.0, 20.0], [0.0, 1.0]])
    seen = Trajectory(t, com, com, torque_N_m=torque, torque_bars=(5, 2))
    frame = to_frame(seen)
    assert frame["torque_bar_5_N_m"].tolist() == [5.0, 50.0, 0.0]
    back = from_frame(frame)
    assert back.torque_bars == (5, 2)
    np.testing.assert_array_equal(back.torque_N_m, torque)


@pytest.mark.parametrize("name", ["torque_{}_N_m", "torque_law_{}_N_m"])
def test_torques_named_by_the_number_of_the_rotation_are_still_read(name):
    t, com = np.arange(3.0), np.ones((3, 2))
    torque = np.array([[5.0, 2.0], [50.0, 20.0], [0.0, 1.0]])
    old = to_frame(Trajectory(t, com, com)).assign(**{name.format(p + 1): torque[:, p] for p in range(2)})
    np.testing.assert_array_equal(from_frame(old).torque_N_m, torque)
    assert from_frame(old).torque_bars == ()


@pytest.mark.parametrize("engine", ["reference", "rebound", "exudyn"])
def test_a_trajectory_survives_its_table(engine):
    name = "basics/two_bars_free"
    seen = ENGINES[engine].load()().run(shortened(name))
    back = from_frame(to_frame(seen))
    for field in dataclasses.fields(seen):
        mine, theirs = getattr(seen, field.name), getattr(back, field.name)
        if isinstance(mine, np.ndarray) and mine.size:
            np.testing.assert_array_equal(mine, theirs)
