"""Pinocchio against the reference: accelerations and reactions at a state, its runs, its traps."""

import dataclasses

import numpy as np
import pytest

from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.pinocchio.adapter import Pinocchio
from scenarios import Gravity, load_scene
from tests.support.generic_scenes import generic, of_bars, solution, solution_at_start, steep, worst
from tests.support.slow import slow_but
from tests.support.step_order import JUMPING, SMOOTH, effect_scene, errors

pytest.importorskip("pinocchio")
EPS = np.finfo(float).eps
CHANNELS = ["angle_rad", "rate_rad_s", "reaction_N"]


def run(scene, rtol):
    return Pinocchio().run(scene, Setting(AccuracyParameter.RTOL, rtol))


def built(scene):
    engine = Pinocchio()
    engine.build(scene, Pinocchio.sweep.setting())
    return engine


def first_accelerations(scene):
    """Angular accelerations that Pinocchio has at t = 0, and the reactions there."""
    engine = built(scene)
    rate = engine.chain.rate(0.0, engine.problem.y0)
    return np.cumsum(rate[-scene.bars :]), engine.chain.reactions(engine.problem.y0)


@pytest.mark.parametrize("gravity", list(Gravity))
@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
def test_accelerations_and_reactions_are_the_references_to_round_off(size, gravity):
    for seed in range(5):
        scene = generic(seed, size=size, gravity=gravity)
        angular, reaction = first_accelerations(scene)
        true = solution_at_start(scene)
        assert worst(angular, true.angle_rad_s2) < 100.0 * EPS * np.abs(true.angle_rad_s2).max()
        assert worst(reaction, true.reaction_N) < 100.0 * EPS * np.abs(true.reaction_N).max()


@pytest.mark.parametrize("bars", [50, 100])
def test_reactions_of_long_chains_lose_no_more_than_a_rounding_a_bar(bars):
    scene = of_bars(steep(), bars)
    _, reaction = first_accelerations(scene)
    true = solution_at_start(scene).reaction_N
    assert worst(reaction, true) < 16.0 * EPS * bars * np.abs(true).max()


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize("speed_factor", [0.9, 1.0, 1.1, 1.6])
def test_runs_agree_with_the_reference(speed_factor, channel):
    scene = steep(orbits=0.5, name="paper/fig15", speed_factor=speed_factor, longitude_rad=2.5)
    found, true = getattr(run(scene, 1e-12), channel), getattr(solution(scene), channel)
    # a step asks for 1e-12 rad and takes some radians; a few dozen steps
    assert worst(found, true) < 100.0 * 1e-12 * max(1.0, np.abs(true).max())


def test_a_tenth_of_the_tolerance_is_a_tenth_of_the_error():
    scene = steep(name="paper/fig05")
    error = [worst(run(scene, rtol).angle_rad, solution(scene).angle_rad) for rtol in (1e-6, 1e-8, 1e-10)]
    assert error[0] / error[1] == pytest.approx(100.0, rel=0.5)
    assert error[1] / error[2] == pytest.approx(100.0, rel=0.5)


def test_the_centre_of_mass_follows_kepler_where_there_is_but_one_bar():
    scene = load_scene("basics/kepler_elliptic")
    start = np.array([scene.radius0_m, 0.0]), np.array([0.0, scene.speed0_m_s])
    place, _ = propagate(scene.central_body.mu_m3_s2, *start, scene.times_s)
    found = run(scene, 1e-12)
    # the track is integrated with the chain: 1e-12 of the radius in each step, run along it by 1 + 3 n t
    run_along = 1.0 + 3.0 * 2.0 * np.pi * scene.run.duration_s / scene.step_period_s
    assert worst(found.com_m, place) < 1e-12 * scene.radius0_m * found.info["steps"] * run_along
    assert found.reaction_N.shape == (scene.run.samples, 0, 2)


def test_fall_ends_at_the_surface():
    scene = steep(orbits=0.2, samples=28, name="paper/fig15", speed_factor=0.0)
    found, true = run(scene, 1e-10), solution(scene)
    instant, expected = (float(t.ended.split()[-2]) for t in (found, true))
    assert instant == pytest.approx(expected, abs=2e-6)  # as printed
    assert len(found.t_s) == len(found.reaction_N) == len(true.t_s) < scene.run.samples


def test_there_is_a_force_for_every_joint():
    """Of a shorter list Pinocchio reads what lies behind it, in silence."""
    chain = built(generic(1)).chain
    assert len(chain.forces) == chain.model.njoints


def test_a_state_that_is_not_finite_is_an_error():
    engine = built(generic(1))
    engine.problem.y0[6] = np.nan
    with pytest.raises(EngineError, match="not finite"):
        engine.simulate()


def test_nothing_is_printed_or_written(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    run(steep(orbits=0.05), 1e-8)
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


def test_what_it_can_not_do_is_said_with_a_reason():
    assert "takes torques" in Pinocchio.unsupported(load_scene("paper/fig17"))


@pytest.mark.parametrize("name", slow_but([*SMOOTH, *JUMPING, "solar_pressure"], ["drag"]))
def test_every_effect_is_carried_to_the_accuracy_asked_for(name):
    """In units of each channel's size: 1e-12 a step, some hundred steps, twice that for the reference's own."""
    scene = effect_scene(name)
    found, true = run(scene, 1e-12), solution(scene)
    for channel, error in errors(found, scene).items():
        assert error < 200.0 * 1e-12 * max(np.abs(getattr(true, channel)).max(), channel == "angle_rad"), channel


def test_the_shadow_is_rejected():
    assert "depend on the motion" in Pinocchio.unsupported(effect_scene("solar_shadow"))


def test_a_blow_at_the_first_instant_shows_at_once():
    scene = effect_scene("impulse", 0.2)
    blow = dataclasses.replace(scene.effects.impulse[0], at_s=0.0)
    scene = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, impulse=(blow,)))
    found = run(scene, 1e-12)
    assert worst(found.impulse_N_s[1:], solution(scene).impulse_N_s[1:]) < 1e-10
    assert worst(found.rate_rad_s[1:], solution(scene).rate_rad_s[1:]) < 1e-13
    assert np.array_equal(found.impulse_N_s[0], found.impulse_N_s[1])
