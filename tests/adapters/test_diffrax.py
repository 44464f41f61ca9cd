"""diffrax on barchain's equations in JAX: the same equations as in NumPy, compiled once for each shape of a run."""

import dataclasses

import numpy as np
import pytest

from adapters.common.initial_state import chain_model, initial_state
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.ode_solvers.diffrax.adapter import DiffraxDopri8
from adapters.registry import ENGINES
from reference_impl.model import relative
from reference_impl.model.state import State
from scenarios import Gravity, load_scene
from tests.support.generic_scenes import generic, of_bars, solution, steep, worst
from tests.support.slow import slow_but

pytest.importorskip("diffrax")

EPS = np.finfo(float).eps


def run(scene, rtol):
    return DiffraxDopri8().run(scene, Setting(AccuracyParameter.RTOL, rtol))


@pytest.mark.parametrize("gravity", slow_but([Gravity.NONE, Gravity.POINT, Gravity.GRADIENT], [Gravity.GRADIENT]))
@pytest.mark.parametrize("bars", slow_but([1, 2, 5, 40], [1, 5]))
def test_accelerations_and_reactions_are_those_of_the_formulation_in_numpy(gravity, bars):
    """40 bars are eliminated in a loop, fewer without one."""
    from adapters.ode_solvers.diffrax import compiled, equations

    scene = generic(1, bars, gravity=gravity)
    s = initial_state(scene)
    state = State(s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s, s.position_m, s.velocity_m_s)
    expected = relative.accelerations(chain_model(scene), 0.0, state)
    y = np.concatenate([s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s])
    found = equations.chain_rates(equations.jax_chain(scene), str(gravity), compiled.double(y))
    # some tens of roundings, amplified by the joint system's condition: 1e3 at five bars, growing with their square
    floor = 1e3 * max(1.0, (bars / 5.0) ** 2) * EPS
    for name in ("com_m_s2", "angle_rad_s2", "reaction_N"):
        a, b = np.asarray(getattr(found, name)), getattr(expected, name)
        assert np.abs(a - b).max(initial=0.0) <= floor * np.abs(b).max(initial=0.0)


@pytest.mark.slow
def test_error_follows_the_tolerance():
    scene = steep(orbits=0.5)
    error = [worst(run(scene, rtol).angle_rad, solution(scene).angle_rad) for rtol in (1e-5, 1e-7, 1e-9)]
    assert error[0] > 10.0 * error[1] > 100.0 * error[2]  # at least ten times better for a hundredth
    assert error[2] < 1e3 * 1e-9  # some hundred steps' requests, and steps' errors add up


@pytest.mark.slow
def test_fall_ends_at_the_surface():
    scene = steep(orbits=0.2, samples=28, name="paper/fig15", speed_factor=0.0)
    found, true = run(scene, 1e-9), solution(scene)
    instant, expected = (float(t.ended.split()[-2]) for t in (found, true))
    assert instant == pytest.approx(expected, abs=1e-3)  # metres a millisecond: 1e-9 of the radius in some steps
    assert len(found.t_s) == len(found.reaction_N) == len(true.t_s) < scene.run.samples


@pytest.mark.slow
def test_code_is_compiled_for_a_shape_and_serves_all_accuracies_orbits_and_masses(monkeypatch):
    from adapters.ode_solvers.diffrax import compiled

    compiled.compiled_run.cache_clear()
    scene = of_bars(steep(orbits=0.1), 3)
    heavy = dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, mass_kg=(1.0, 2.0, 3.0)))
    for one, rtol in ((scene, 1e-6), (scene, 1e-9), (heavy, 1e-6), (steep(orbits=0.2), 1e-6)):
        run(of_bars(one, 3) if one.bars != 3 else one, rtol)
    assert compiled.compiled_run.cache_info().misses == 1


@pytest.mark.slow
def test_a_run_that_diffrax_gives_up_is_an_error(monkeypatch):
    from adapters.ode_solvers.diffrax import compiled

    monkeypatch.setattr(compiled, "MOST_STEPS", 3)
    compiled.compiled_run.cache_clear()
    with pytest.raises(EngineError, match="diffrax: the run failed after 3 steps"):
        run(of_bars(steep(orbits=0.1), 1), 1e-10)
    compiled.compiled_run.cache_clear()


def test_other_effects_are_declared_unsupported():
    assert DiffraxDopri8.unsupported(load_scene("effects/drag")) == "does not support drag"
    assert "prescribed_rotation" in DiffraxDopri8.unsupported(load_scene("paper/fig17"))


def test_it_is_an_integrator_on_barchains_equations_that_only_studies_select():
    registration = ENGINES["diffrax-dopri8"]
    assert not registration.external
    assert not registration.in_default_set
