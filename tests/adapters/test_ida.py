"""IDA's own: residual and Jacobian, orders, joints, and what index 3 can't do."""

import functools

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.ida.adapter import IdaGgl, IdaIndex1, IdaIndex2, IdaIndex3
from adapters.ida.chain import Form, RedundantChain
from scenarios import load_scene
from tests.support.generic_scenes import of_bars, solution, steep, worst

pytest.importorskip("sksundae")
EPS = np.finfo(float).eps
ENGINES = [IdaIndex1, IdaIndex2, IdaGgl, IdaIndex3]
each = pytest.mark.parametrize("engine", ENGINES)


@functools.lru_cache(16)
def run(engine, scene, rtol):
    return engine().run(scene, Setting(AccuracyParameter.RTOL, rtol))


def begun(scene, form=Form.INDEX_1):
    """A chain with its consistent state and slopes at t = 0."""
    chain = RedundantChain(scene, form)
    return chain, *chain.consistent(0.0, chain.start(initial_state(scene)) / chain.units)


@pytest.mark.parametrize("form", list(Form))
def test_the_start_satisfies_every_form_of_the_constraints(form):
    chain, y, slopes = begun(of_bars(steep(), 20), form)
    assert np.abs(chain.residual(0.0, y, slopes)).max() < 16 * EPS * np.abs(y).max()  # reactions of a long chain


@pytest.mark.parametrize("form", list(Form))
@pytest.mark.parametrize("effect", ["joint_springs", "drag"])
def test_the_jacobian_is_that_of_the_residual(form, effect):
    scene = load_scene(f"effects/{effect}")
    chain, y, slopes = begun(scene, form)
    rng, c, step = np.random.default_rng(5), 30.0, 1e-5
    y[4 : chain.extra.start] += 1e-2 * rng.normal(size=chain.extra.start - 4)
    slopes += 0.1 * rng.normal(size=len(y))
    columns = []
    for unit in np.eye(len(y)):
        ahead, back = (chain.residual(0.0, y + s * unit, slopes + c * s * unit) for s in (step, -step))
        columns.append((ahead - back) / (2.0 * step))
    wrong = np.abs(chain.jacobian(0.0, y, slopes, c) - np.array(columns).T)
    wrong[chain.v, :4] = 0.0  # left out: the loads' dependence on the origin
    assert wrong.max() < 1e-5 * c  # loads are differenced over 1e-7, to u/1e-7 and the square of that step


@pytest.mark.parametrize("engine", ENGINES[:3])
def test_the_order_is_that_of_the_fifth_formula(engine):
    """Steps taken against the error: a step's own error falls with their sixth power, the sum with the fifth."""
    scene, tolerances = steep(name="paper/fig09", orbits=0.5), np.geomspace(1e-8, 1e-11, 3)
    runs = [run(engine, scene, rtol) for rtol in tolerances]
    error = [worst(found.angle_rad, solution(scene).angle_rad) for found in runs]
    order = -np.polyfit(np.log([found.info["steps"] for found in runs]), np.log(error), 1)[0]
    assert 3.0 < order < 9.0  # the steps are chosen anew in each run


def test_reactions_of_index_3_go_with_a_lower_power_of_the_request():
    scene, tolerances = steep(name="paper/fig13"), np.geomspace(1e-3, 1e-6, 4)
    error = [worst(run(IdaIndex3, scene, rtol).reaction_N, solution(scene).reaction_N) for rtol in tolerances]
    power = np.polyfit(np.log(tolerances), np.log(error), 1)[0]
    assert 0.4 < power < 0.9  # 2/3 by differences over steps of rtol^(1/6)


def test_joints_drift_at_index_1_and_2_and_stay_closed_with_constraints_of_positions():
    scene = steep(name="paper/fig13")
    gap = {engine: run(engine, scene, 1e-7).gap_m.max() / 100.0 for engine in ENGINES}
    # of a bar: errors of some hundred steps; the constraint's own error, and that of reading between steps
    assert gap[IdaIndex1] > 10.0 * gap[IdaGgl]
    assert gap[IdaIndex2] > gap[IdaGgl]
    assert gap[IdaIndex1] < 1e-7 * 1000
    assert gap[IdaGgl] < 1e-7 * 10
    assert gap[IdaIndex3] < 1e-7


@pytest.mark.slow
def test_with_rates_in_the_error_test_index_3_does_not_get_through(monkeypatch):
    own = RedundantChain.__init__

    def tested(self, scene, form):
        own(self, scene, form)
        self.differential[self.v] = 1.0

    monkeypatch.setattr(RedundantChain, "__init__", tested)
    monkeypatch.setattr("adapters.ida.adapter.MOST_STEPS", 2000)
    with pytest.raises(EngineError, match=r"IDA, index_3: IDASolve failed: IDA_(ERR_FAIL|CONV_FAIL|TOO_MUCH_WORK)"):
        run(IdaIndex3, steep(name="paper/fig05"), 1e-6)


@each
def test_the_last_multipliers_are_as_good_as_the_others(engine):
    """A step that is cut short at the end would spoil them."""
    scene = load_scene("conform/joint_springs_alone")
    wrong = np.abs(run(engine, scene, 1e-7).reaction_N - solution(scene).reaction_N).max(axis=(1, 2))
    assert wrong[-1] <= 3.0 * wrong[:-1].max()


def test_an_error_in_the_equations_comes_out(monkeypatch):
    def lost(self, t, y, slopes, c):
        raise ArithmeticError("no such matrix")

    monkeypatch.setattr(RedundantChain, "jacobian", lost)
    with pytest.raises(EngineError, match="no such matrix"):
        run(IdaIndex2, steep(orbits=0.1), 1e-6)
