"""SciPy's and SUNDIALS' solvers on the compiled reference's equations."""

import dataclasses
import functools

import numpy as np
import pytest

from adapters.common.face_reversal import incidences
from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.common.solver_driver import Problem, ScipySolver, drive
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.ode_solvers.adapter import CvodeAdams, CvodeBdf, ScipyDop853, ScipyRadau, compiled_order
from adapters.registry import ENGINES
from reference_impl.integrate.simulate import Simulation
from scenarios import load_scene
from tests.support.changed import lasting, under
from tests.support.generic_scenes import generic, solution, steep, worst
from tests.support.kernel import skip_without_kernel

ALL = pytest.mark.parametrize("engine", [ScipyDop853, ScipyRadau, CvodeAdams, CvodeBdf])
EPS = np.finfo(float).eps


@pytest.fixture(autouse=True)
def _libraries_are_there(request):
    engine = request.node.callspec.params.get("engine") if hasattr(request.node, "callspec") else None
    if engine in (CvodeAdams, CvodeBdf):
        pytest.importorskip("sksundae")
    skip_without_kernel()


@functools.cache
def run(engine, scene, rtol):
    return engine().run(scene, Setting(AccuracyParameter.RTOL, rtol))


@functools.cache
def slewed():
    """Fig. 17's slew, started after a while, and a sample on either side of its ends."""
    scene = load_scene("paper/fig17")
    law = dataclasses.replace(scene.effects.prescribed_rotation[0], start_s=33.3)
    return lasting(under(scene, prescribed_rotation=(law,)), 200.0, 21)


@ALL
def test_error_follows_the_tolerance(engine):
    scene = steep(orbits=0.5)
    error = [worst(run(engine, scene, rtol).angle_rad, solution(scene).angle_rad) for rtol in (1e-5, 1e-7, 1e-9)]
    assert error[0] > 10.0 * error[1] > 100.0 * error[2]  # at least ten times better for a hundredth
    assert error[2] < 1e3 * 1e-9  # some hundred steps' requests, and steps' errors add up


@pytest.mark.parametrize("engine", [ScipyDop853, ScipyRadau])
def test_errors_stay_within_the_steps_requests_where_bars_turn_their_other_face_to_the_sun(engine):
    """The slope of the force jumps there: no error estimate of a step across it holds."""
    scene = load_scene("effects/solar_pressure")
    scene = lasting(scene, 0.5 * scene.period_s, 41)
    (light,) = incidences(scene, solution(scene))
    assert np.count_nonzero(np.diff(light.face, axis=0)) >= 3
    seen = run(engine, scene, 1e-9)
    assert worst(seen.angle_rad, solution(scene).angle_rad) < 1e-9 * seen.info["steps"]


@ALL
def test_a_sample_on_a_break_and_none_since_the_last_one_is_where_it_is_asked_for(engine):
    """CVODE shows its own steps when it is asked for one instant: the first of them is not that instant."""
    full = slewed()
    _, end = full.effects.prescribed_rotation[0].breaks_s
    alone = lasting(full, 2.0 * end, 3)
    seen, right = run(engine, alone, 1e-9), solution(alone)
    assert np.linalg.norm(seen.com_m - right.com_m, axis=1).max() < 1.0  # a step of its own is kilometres off


@ALL
def test_no_step_straddles_a_break(engine, monkeypatch):
    """Each segment is a run of its own, so that no solver looks beyond a break before it has stopped there."""
    asked = []
    own = engine.solver

    def watched(self, rtol, atol):
        solver = own(self, rtol, atol)

        class Watched:
            def solve(self, problem, start_s, instants_s, y):
                asked.append((start_s, instants_s[-1]))
                return solver.solve(problem, start_s, instants_s, y)

        return Watched()

    monkeypatch.setattr(engine, "solver", watched)
    found = engine().run(slewed(), Setting(AccuracyParameter.RTOL, 1e-9))
    assert np.array(asked) == pytest.approx(np.array([(0.0, 33.3), (33.3, 93.3), (93.3, 200.0)]))
    assert len(found.t_s) == 21
    # the torque answers to the state; 1e-9 of some radians in each of some dozen steps
    scale = np.abs(solution(slewed()).torque_N_m).max()
    assert worst(found.torque_N_m, solution(slewed()).torque_N_m) < 1e-5 * scale
    assert worst(found.angle_rad, solution(slewed()).angle_rad) < 1e-6


@ALL
def test_steps_evaluations_and_jacobians_are_counted(engine):
    scene = steep(orbits=0.5, samples=101)
    a, b = (run(engine, lasting(scene, scene.run.duration_s, samples), 1e-6).info for samples in (3, 101))
    assert a["evaluations"] > a["steps"] > 5
    assert a["steps"] == pytest.approx(b["steps"], rel=0.3)  # not samples, though those are looked at besides
    assert (a["jacobians"] > 0) == (engine in (ScipyRadau, CvodeBdf))


def decay():
    return Problem(lambda t, y: -y, np.array([1.0]), lambda y: 1.0)


def test_a_tolerance_below_scipys_least_one_is_no_warning():
    run(ScipyDop853, steep(orbits=0.05), 1e-14)


@pytest.mark.parametrize("method", ["DOP853", "Radau"])
def test_scipys_failure_is_an_error_with_its_own_words(method):
    blows_up = Problem(lambda t, y: y * y, np.array([1.0]), lambda y: 1.0)  # infinite at t = 1
    with np.errstate(all="ignore"), pytest.raises(EngineError, match=f"{method}: .*step size"):
        drive(ScipySolver(method, 1e-6, 1e-9), blows_up, np.array([0.0, 2.0]))


def test_a_success_that_a_solver_claims_for_a_state_that_is_not_finite_is_an_error():
    class Claims(ScipySolver):
        def solve(self, problem, start_s, instants_s, y):
            found = super().solve(problem, start_s, instants_s, y)
            return dataclasses.replace(found, y=np.full_like(found.y, np.nan))

    with pytest.raises(EngineError, match="the state is not finite"):
        drive(Claims("DOP853", 1e-8, 1e-11), decay(), np.array([0.0, 2.0]))


def test_cvodes_failure_is_an_error(monkeypatch, capfd):
    pytest.importorskip("sksundae")
    monkeypatch.setattr("adapters.ode_solvers.adapter.MOST_STEPS", 3)
    with pytest.raises(EngineError, match="CVODE, Adams: CVode failed: CV_TOO_MUCH_WORK"):
        CvodeAdams().run(steep(), Setting(AccuracyParameter.RTOL, 1e-8))
    capfd.readouterr()


@ALL
def test_an_error_in_the_equations_comes_out(engine, monkeypatch):
    prepared = engine()
    prepared.build(steep(), engine.sweep.setting())
    calls = []

    def rhs(t, y):
        calls.append(t)
        if len(calls) > 3:
            raise np.linalg.LinAlgError("not positive definite")
        return np.zeros_like(y)

    run_ = prepared.prepared
    run_.problem.rhs = rhs
    run_.function.following = True  # such rates are called from Python, by CVODE too
    monkeypatch.setattr(run_.function, "hold", lambda modes: None)
    with pytest.raises(EngineError, match="not positive definite"):
        prepared.simulate()


def test_samples_that_fall_on_a_break_are_taken_once():
    t = np.array([0.0, 0.5, 1.0, 1.5])
    found = drive(ScipySolver("DOP853", 1e-12, 1e-15), decay(), t, (0.5, 0.7, 1.0)).walk
    np.testing.assert_array_equal(found.t_s, t)
    assert np.abs(found.y[:, 0] - np.exp(-t)).max() < 1e-11


def test_they_are_the_reference_in_another_hand_and_no_check_on_it():
    for name, registration in ENGINES.items():
        if name.startswith(("scipy-", "cvode-")):
            assert not registration.external
            assert not registration.in_default_set


@pytest.fixture(scope="module")
def compiled():
    skip_without_kernel()
    from adapters.ode_solvers import compiled

    return compiled


@pytest.mark.parametrize("seed", range(3))
def test_compiled_rates_and_height_are_those_in_numpy(compiled, seed):
    scene = generic(seed)
    model, start = chain_model(scene), initial_state(scene)
    own = Simulation(model, start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s, rtol=1e-9)
    function = compiled.RatesFunction(model)
    y = compiled_order(function, own.y0)
    expected, found = own.coordinates.rhs(0.0, own.y0), function.rates_at(0.0, y)[function.order]
    n = scene.bars
    for block in np.split(np.arange(4 + 2 * n), [2, 4, 4 + n]):  # each in its own unit
        # two walks of some tens of operations, amplified by the joint system's condition (below 1e3 here)
        assert np.abs(found[block] - expected[block]).max() <= 1e3 * EPS * np.abs(expected[block]).max()
    assert compiled.CompiledFunctions(function).height_m(y) == pytest.approx(
        own.height(own.y0), abs=4 * np.spacing(scene.radius0_m)
    )


def test_cvode_calls_no_python_function_of_the_chain_while_it_runs(monkeypatch):
    skip_without_kernel()
    pytest.importorskip("sksundae")
    engine = CvodeAdams()
    engine.build(steep(orbits=0.2), engine.sweep.setting())
    problem, calls = engine.prepared.problem, []
    own = problem.rhs
    problem.rhs = lambda t, y: calls.append(t) or own(t, y)
    engine.simulate()
    assert calls == [0.0]  # the check of the initial state
    assert engine.read().info["evaluations"] > 50


def test_where_bars_turn_faces_the_compiled_rates_take_the_faces_of_each_evaluated_state():
    """Its modes follow from the state, so that CVODE calls Python: slower, and the same motion as in NumPy."""
    skip_without_kernel()
    pytest.importorskip("sksundae")
    scene = load_scene("effects/drag")
    short = lasting(scene, 0.05 * scene.run.duration_s, 5)
    found = CvodeAdams().run(short, Setting(AccuracyParameter.RTOL, 1e-10))
    assert worst(found.angle_rad, solution(short).angle_rad) < 1e-7  # 1e-10 in each of some hundred steps


def test_a_chain_whose_joints_are_lost_in_round_off_is_an_error_in_compiled_code_too(monkeypatch):
    skip_without_kernel()
    pytest.importorskip("sksundae")
    engine = CvodeAdams()
    engine.build(steep(), engine.sweep.setting())
    engine.prepared.function.chain.bars[2] = np.nan  # inverse masses: every pivot is lost
    with pytest.raises(EngineError, match=r"not finite|not positive definite"):
        engine.simulate()
