"""Drake and DART against the reference: accelerations and reactions at a state, their runs, their traps."""

import importlib.util
from itertools import pairwise

import numpy as np
import pytest

from adapters.common.kepler import propagate
from adapters.dart.adapter import Dart
from adapters.drake.adapter import Drake
from adapters.drake.integrator import DrakeIntegrator
from adapters.engine import AccuracyParameter, EngineError, Setting
from scenarios import Gravity, load_scene
from tests.support.generic_scenes import generic, of_bars, solution, solution_at_start, steep, worst
from tests.support.slow import slow_but
from tests.support.step_order import JUMPING, SMOOTH, effect_scene, errors

EPS = np.finfo(float).eps
MODULES = {Drake: "pydrake", Dart: "dartpy"}
PRESENT = [engine for engine, module in MODULES.items() if importlib.util.find_spec(module)]
needs_drake = pytest.mark.skipif(Drake not in PRESENT, reason="drake is not installed")
pytestmark = pytest.mark.skipif(not PRESENT, reason="neither Drake nor DART is installed")
each = pytest.mark.parametrize("engine", PRESENT)


def run(engine, scene, rtol):
    return engine().run(scene, Setting(AccuracyParameter.RTOL, rtol))


def built(engine, scene):
    made = engine()
    made.build(scene, engine.sweep.setting())
    return made


def accelerations_and_reactions(made, scene, state):
    rate = made.chain.rate(0.0, state)
    return np.cumsum(rate[-scene.bars :]), made.chain.reactions(state)


@each
@pytest.mark.parametrize("gravity", list(Gravity))
@pytest.mark.parametrize("size", [1.0, 1e-4])
def test_accelerations_and_reactions_are_the_references_to_round_off(engine, size, gravity):
    for seed in range(3):
        scene = generic(seed, size=size, gravity=gravity)
        made, true = built(engine, scene), solution_at_start(scene)
        angular, reaction = accelerations_and_reactions(made, scene, made.problem.y0)
        assert worst(angular, true.angle_rad_s2) < 100.0 * EPS * np.abs(true.angle_rad_s2).max()
        assert worst(reaction, true.reaction_N) < 100.0 * EPS * np.abs(true.reaction_N).max()


@each
def test_reactions_of_long_chains_lose_no_more_than_a_rounding_a_bar(engine):
    scene = of_bars(steep(), 50)
    made, true = built(engine, scene), solution_at_start(scene).reaction_N
    _, reaction = accelerations_and_reactions(made, scene, made.problem.y0)
    assert worst(reaction, true) < 16.0 * EPS * 50 * np.abs(true).max()


@each
def test_a_state_leaves_nothing_behind_for_the_next(engine):
    """DART would turn a force by the pose of the state before."""
    scene = generic(4)
    made = built(engine, scene)
    first = accelerations_and_reactions(made, scene, made.problem.y0)
    turned = made.problem.y0.copy()
    turned[6:] += 1.0
    made.chain.rate(0.0, turned)
    again = accelerations_and_reactions(made, scene, made.problem.y0)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


@each
@pytest.mark.parametrize("channel", ["angle_rad", "rate_rad_s", "reaction_N"])
def test_runs_agree_with_the_reference(engine, channel):
    scene = steep(orbits=0.5, name="paper/fig15", speed_factor=1.1, longitude_rad=2.5)
    found, true = getattr(run(engine, scene, 1e-11), channel), getattr(solution(scene), channel)
    # a step asks for 1e-11 rad; RK5 takes some 300 steps, whose errors are of either sign
    assert worst(found, true) < 100.0 * 1e-11 * max(1.0, np.abs(true).max())


@each
def test_a_tenth_of_the_tolerance_is_a_tenth_of_the_error(engine):
    """Drake's RK5 gains somewhat less: it propagates the fifth order and estimates the error of the fourth."""
    scene = steep(name="paper/fig13")
    error = [worst(run(engine, scene, rtol).angle_rad, solution(scene).angle_rad) for rtol in (1e-6, 1e-8, 1e-10)]
    for coarse, fine in pairwise(error):
        assert 30.0 < coarse / fine < 300.0


@needs_drake
def test_the_order_of_drakes_integrator_is_five():
    """Steps taken against the error: an error falls with their fifth power."""
    scene = steep(name="paper/fig05", orbits=0.5)
    runs = [run(Drake, scene, rtol) for rtol in (1e-8, 1e-10, 1e-12)]
    error = [worst(found.angle_rad, solution(scene).angle_rad) for found in runs]
    steps = [found.info["steps"] for found in runs]
    order = -np.polyfit(np.log(steps), np.log(error), 1)[0]
    assert order == pytest.approx(5.0, abs=1.0)


@needs_drake
def test_rejected_steps_do_not_spoil_drakes_run():
    """With caching a rejected step is repeated with a stale derivative: benchmarks/drake_caching.py."""
    made = built(Drake, steep(name="paper/fig13"))
    y0, end_s = made.problem.y0, float(made.times_s[-1])
    integrator = DrakeIntegrator("runge_kutta5", 1e-8, made.integrator.units)
    simulator = integrator.simulator(made.problem, 0.0, end_s, y0)
    simulator.get_mutable_integrator().request_initial_step_size_target(0.1 * end_s)
    simulator.Initialize()
    simulator.AdvanceTo(end_s)
    assert simulator.get_integrator().get_num_step_shrinkages_from_error_control() > 0
    found = integrator.units * simulator.get_context().get_continuous_state_vector().CopyToVector()
    true = solution(steep(name="paper/fig13")).angle_rad[-1]
    assert worst(np.cumsum(found[6 : 6 + len(true)]), true) < 100.0 * 1e-8


@each
def test_the_centre_of_mass_follows_kepler_where_there_is_but_one_bar(engine):
    scene = load_scene("basics/kepler_elliptic")
    start = np.array([scene.radius0_m, 0.0]), np.array([0.0, scene.speed0_m_s])
    place, _ = propagate(scene.central_body.mu_m3_s2, *start, scene.times_s)
    found = run(engine, scene, 1e-11)
    # the track is integrated with the chain: 1e-11 of the radius in each step, run along it by 1 + 3 n t
    run_along = 1.0 + 3.0 * 2.0 * np.pi * scene.run.duration_s / scene.step_period_s
    assert worst(found.com_m, place) < 1e-11 * scene.radius0_m * found.info["steps"] * run_along
    assert found.reaction_N.shape == (scene.run.samples, 0, 2)


@each
def test_fall_ends_at_the_surface(engine):
    scene = steep(orbits=0.2, samples=28, name="paper/fig15", speed_factor=0.0)
    found, true = run(engine, scene, 1e-10), solution(scene)
    instant, expected = (float(t.ended.split()[-2]) for t in (found, true))
    assert instant == pytest.approx(expected, abs=2e-6)  # as printed
    assert len(found.t_s) == len(found.reaction_N) == len(true.t_s) < scene.run.samples


@each
def test_a_state_that_is_not_finite_is_an_error(engine):
    made = built(engine, generic(1))
    made.problem.y0[6] = np.nan
    with pytest.raises(EngineError, match="not finite"):
        made.simulate()


@each
def test_nothing_is_printed_or_written(engine, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    run(engine, steep(orbits=0.05), 1e-8)
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


@each
def test_unsupported_effects_have_their_reason(engine):
    assert "law" in engine.unsupported(load_scene("paper/fig17"))
    assert "depend on the motion" in engine.unsupported(effect_scene("solar_shadow"))


@each
@pytest.mark.parametrize("name", slow_but([*SMOOTH, *JUMPING, "solar_pressure"], ["drag"]))
def test_every_effect_is_supported_to_the_accuracy_asked_for(engine, name):
    """In units of each channel's size: 1e-11 a step, at most some hundred steps' worth."""
    scene = effect_scene(name)
    found, true = run(engine, scene, 1e-11), solution(scene)
    for channel, error in errors(found, scene).items():
        size = max(np.abs(getattr(true, channel)).max(), channel == "angle_rad")
        assert error < 200.0 * 1e-11 * size, channel
