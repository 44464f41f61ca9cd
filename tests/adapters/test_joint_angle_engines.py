"""Traps of engines in joint angles: Pinocchio's forces, DART's poses, Drake's integrator."""

import dataclasses

import numpy as np
import pytest

from adapters.drake.adapter import Drake
from adapters.drake.integrator import DrakeIntegrator
from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from tests.support.generic_scenes import generic, solution, steep, worst
from tests.support.step_order import effect_scene

HERE = [name for name in ("pinocchio", "drake", "dart") if ENGINES[name].missing is None]
needs_pinocchio = pytest.mark.skipif("pinocchio" not in HERE, reason="pinocchio is not installed")
needs_drake = pytest.mark.skipif("drake" not in HERE, reason="drake is not installed")


def built(engine, scene):
    made = ENGINES[engine].load()()
    made.build(scene, made.sweep.setting())
    return made


@needs_pinocchio
def test_there_is_a_force_for_every_joint():
    """Of a shorter list Pinocchio reads what lies behind it, in silence."""
    chain = built("pinocchio", generic(1)).chain
    assert len(chain.forces) == chain.model.njoints


@needs_pinocchio
def test_a_blow_at_the_first_instant_shows_at_once():
    scene = effect_scene("impulse", 0.2)
    blow = dataclasses.replace(scene.effects.impulse[0], at_s=0.0)
    scene = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, impulse=(blow,)))
    found = ENGINES["pinocchio"].load()().run(scene, Setting(AccuracyParameter.RTOL, 1e-12))
    assert worst(found.impulse_N_s[1:], solution(scene).impulse_N_s[1:]) < 1e-10
    assert worst(found.rate_rad_s[1:], solution(scene).rate_rad_s[1:]) < 1e-13
    assert np.array_equal(found.impulse_N_s[0], found.impulse_N_s[1])


@pytest.mark.parametrize("engine", HERE)
def test_a_state_leaves_nothing_behind_for_the_next(engine):
    """DART would turn a force by the pose of the state before."""
    made = built(engine, generic(4))

    def seen(state):
        return made.chain.rate(0.0, state).copy(), np.array(made.chain.reactions(state))

    first = seen(made.problem.y0)
    turned = made.problem.y0.copy()
    turned[6:] += 1.0
    made.chain.rate(0.0, turned)
    assert all(np.array_equal(a, b) for a, b in zip(first, seen(made.problem.y0), strict=True))


@needs_drake
def test_the_order_of_drakes_integrator_is_five():
    """Steps taken against the error: an error falls with their fifth power."""
    scene = steep(name="paper/fig05", orbits=0.5)
    runs = [Drake().run(scene, Setting(AccuracyParameter.RTOL, rtol)) for rtol in (1e-8, 1e-10, 1e-12)]
    error = [worst(found.angle_rad, solution(scene).angle_rad) for found in runs]
    steps = [found.info["steps"] for found in runs]
    order = -np.polyfit(np.log(steps), np.log(error), 1)[0]
    assert order == pytest.approx(5.0, abs=1.0)


@needs_drake
def test_rejected_steps_do_not_spoil_drakes_run():
    """With caching a rejected step is repeated with a stale derivative: benchmarks/drake_caching.py."""
    made = built("drake", steep(name="paper/fig13"))
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
