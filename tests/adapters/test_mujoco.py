"""MuJoCo against the reference: accelerations and reactions at a state, order of its RK4, silence and errors."""

import dataclasses
import math

import numpy as np
import pytest

from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.mujoco.adapter import Mujoco
from scenarios import Gravity, load_scene
from tests.support.generic_scenes import generic, of_bars, solution, solution_at_start, steep, worst
from tests.support.slow import one_in
from tests.support.step_order import JUMPING, SMOOTH, by_steps, effect_scene, errors

mujoco = pytest.importorskip("mujoco")
EPS = np.finfo(float).eps
CHANNELS = ["angle_rad", "rate_rad_s", "reaction_N"]


def run(scene, steps):
    return Mujoco().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, steps))


def brief(scene):
    """Two samples an instant apart: what is read at the first is the initial state's."""
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=1e-3, samples=2))


def first_accelerations(scene):
    """Angular accelerations that MuJoCo has at t = 0, the reactions there, and the mass matrix' condition."""
    engine = Mujoco()
    engine.build(brief(scene), Mujoco.sweep.setting())
    engine.simulate()
    engine.seen = engine.seen[:1]
    reaction = engine.read().reaction_N[0]
    mass = np.zeros((scene.bars + 2,) * 2)
    mujoco.mj_fullM(engine.model, engine.data, mass)
    unit = np.sqrt(np.diag(mass))  # metres and radians apart
    return np.cumsum(engine.data.qacc[2:]), reaction, float(np.linalg.cond(mass / np.outer(unit, unit)))


@pytest.mark.parametrize("gravity", list(Gravity))
@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
def test_accelerations_and_reactions_are_the_references_to_round_off(size, gravity):
    for seed in range(5):
        scene = generic(seed, size=size, gravity=gravity)
        angular, reaction, condition = first_accelerations(scene)
        true = solution_at_start(scene)
        lost = 4.0 * EPS * condition  # by a mass matrix in joint angles: three digits or four for unequal bars
        assert lost < 1e-11
        assert worst(angular, true.angle_rad_s2) < lost * np.abs(true.angle_rad_s2).max()
        assert worst(reaction, true.reaction_N) < lost * np.abs(true.reaction_N).max()


@pytest.mark.parametrize("bars", [50, 100, 200])
def test_reactions_of_long_chains_lose_no_more_than_a_rounding_a_bar(bars):
    scene = of_bars(steep(), bars)
    _, reaction, _ = first_accelerations(scene)
    true = solution_at_start(scene).reaction_N
    assert worst(reaction, true) < 16.0 * EPS * bars * np.abs(true).max()


@pytest.mark.parametrize("channel", CHANNELS)
def test_order_is_four_by_richardson_and_against_the_reference(channel):
    scene = steep()
    a, b, c = (getattr(run(scene, n), channel) for n in (200, 400, 800))
    assert math.log2(worst(a, b) / worst(b, c)) == pytest.approx(4.0, abs=0.3)
    true = getattr(solution(scene), channel)
    assert math.log2(worst(b, true) / worst(c, true)) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize("speed_factor", [0.9, 1.0, 1.6])
def test_other_orbits_agree_to_the_error_of_the_step(speed_factor, channel):
    scene = steep(orbits=0.5, name="paper/fig15", speed_factor=speed_factor, longitude_rad=2.5)
    coarse, fine = (getattr(run(scene, n), channel) for n in (500, 1000))
    # halving the step takes 15/16 of the error away; twice that for the next order
    assert worst(fine, getattr(solution(scene), channel)) < 2.0 * worst(fine, coarse) / 15.0


def test_the_first_orbit_of_fig05_agrees_to_a_nanoradian():
    scene = steep(name="paper/fig05")
    assert worst(run(scene, 1000).angle_rad, solution(scene).angle_rad) < 1e-9
    assert worst(run(scene, 1000).reaction_N, solution(scene).reaction_N) < 1e-10


@pytest.mark.parametrize("name", ["kepler_circular", "kepler_elliptic", "kepler_hyperbolic"])
def test_a_point_follows_kepler(name):
    scene = load_scene(f"basics/{name}")
    start = np.array([scene.radius0_m, 0.0]), np.array([0.0, scene.speed0_m_s])
    place, _ = propagate(scene.central_body.mu_m3_s2, *start, scene.times_s)
    found = run(scene, 1000)
    rounded_m = 4.0 * EPS * scene.speed0_m_s * scene.run.duration_s + np.spacing(np.abs(place).max())
    assert worst(found.com_m, place) < rounded_m
    assert found.reaction_N.shape == (scene.run.samples, 0, 2)


def test_the_place_of_injection_does_not_matter():
    one, other = steep(orbits=0.5), steep(orbits=0.5, longitude_rad=1.0)
    a, b = run(one, 1000), run(other, 1000)
    assert worst(b.angle_rad - 1.0, a.angle_rad) < 1000 * 10.0 * EPS  # one rounding of some radians a step


def test_fall_ends_at_the_surface_within_a_step():
    scene = steep(orbits=0.2, samples=28, name="paper/fig15", speed_factor=0.0)
    found, true = run(scene, 2000), solution(scene)
    instant, expected = (float(t.ended.split()[-2]) for t in (found, true))
    assert "a bar reached the surface" in found.ended
    assert abs(instant - expected) < 1.01 * found.info["dt_s"]
    assert len(found.t_s) == len(found.angle_rad) == len(found.reaction_N) == len(true.t_s) < scene.run.samples


def test_a_chain_that_touches_the_surface_at_its_last_sample_only_ends_there():
    fall = steep(orbits=0.2, samples=28, name="paper/fig15", speed_factor=0.0)
    until = float(solution(fall).ended.split()[-2])
    scene = dataclasses.replace(fall, run=dataclasses.replace(fall.run, duration_s=until + 1e-3, samples=2))
    found = run(scene, 2000)
    assert "reached the surface" in found.ended
    assert len(found.t_s) == 1


def test_a_state_that_is_not_finite_is_an_error_and_leaves_no_log(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    engine = Mujoco()
    engine.build(dataclasses.replace(generic(1, gravity=Gravity.NONE)), Mujoco.sweep.setting())
    engine.data.qvel[3] = math.nan
    with pytest.raises(EngineError, match="MuJoCo"):
        engine.simulate()
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


def test_an_exception_in_the_callback_comes_out_and_the_callbacks_are_put_back(monkeypatch):
    def fails(*_):
        raise ZeroDivisionError("no distance")

    before = mujoco.get_mjcb_control(), mujoco.get_mju_user_warning()
    engine = Mujoco()
    engine.build(steep(), Mujoco.sweep.setting())
    monkeypatch.setattr("adapters.mujoco.adapter.MovingLoads.load", fails)
    with pytest.raises(EngineError, match="no distance"):
        engine.simulate()
    assert (mujoco.get_mjcb_control(), mujoco.get_mju_user_warning()) == before


def test_what_it_can_not_do_is_said_with_a_reason():
    assert "soft" in Mujoco.unsupported(load_scene("paper/fig17"))


@pytest.mark.parametrize("name", one_in(3, SMOOTH + JUMPING))
def test_every_effect_is_carried_to_the_methods_order(name):
    """Against the reference: twice the steps leave 1/16, with events and impulses."""
    scene = effect_scene(name, 0.4)
    coarse, fine = (errors(by_steps(Mujoco, scene, n), scene) for n in (4, 8))
    assert ("impulse_N_s" in fine) == (name == "impulse")
    for channel, error in fine.items():
        assert math.log2(coarse[channel] / error) == pytest.approx(4.0, abs=0.6), channel


def test_the_shadow_and_events_within_a_step_are_rejected():
    assert "shadow's edge" in Mujoco.unsupported(effect_scene("solar_shadow"))
    assert "midway between two" in Mujoco.unsupported(effect_scene("thrust_table", 0.9975))
