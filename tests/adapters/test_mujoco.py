"""MuJoCo's own: the order of its RK4, orbits, the surface, silence and errors."""

import dataclasses
import functools
import math

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.mujoco.adapter import Mujoco
from scenarios import Gravity
from tests.support.generic_scenes import generic, solution, steep, worst

mujoco = pytest.importorskip("mujoco")
EPS = np.finfo(float).eps
CHANNELS = ["angle_rad", "rate_rad_s", "reaction_N"]


@functools.lru_cache(16)
def run(scene, steps):
    return Mujoco().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, steps))


def test_order_is_four_by_richardson_and_against_the_reference():
    scene = steep()
    for channel in CHANNELS:
        a, b, c = (getattr(run(scene, n), channel) for n in (200, 400, 800))
        assert math.log2(worst(a, b) / worst(b, c)) == pytest.approx(4.0, abs=0.3), channel
        true = getattr(solution(scene), channel)
        assert math.log2(worst(b, true) / worst(c, true)) == pytest.approx(4.0, abs=0.3), channel


@pytest.mark.parametrize("speed_factor", [0.9, 1.0, 1.6])
def test_other_orbits_agree_to_the_error_of_the_step(speed_factor):
    scene = steep(orbits=0.5, name="paper/fig15", speed_factor=speed_factor, longitude_rad=2.5)
    for channel in CHANNELS:
        coarse, fine = (getattr(run(scene, n), channel) for n in (500, 1000))
        # halving the step takes 15/16 of the error away; twice that for the next order
        assert worst(fine, getattr(solution(scene), channel)) < 2.0 * worst(fine, coarse) / 15.0, channel


def test_the_first_orbit_of_fig05_agrees_to_a_nanoradian():
    scene = steep(name="paper/fig05")
    assert worst(run(scene, 1000).angle_rad, solution(scene).angle_rad) < 1e-9
    assert worst(run(scene, 1000).reaction_N, solution(scene).reaction_N) < 1e-10


def test_the_place_of_injection_does_not_matter():
    one, other = steep(orbits=0.5), steep(orbits=0.5, longitude_rad=1.0)
    a, b = run(one, 1000), run(other, 1000)
    assert worst(b.angle_rad - 1.0, a.angle_rad) < 1000 * 10.0 * EPS  # one rounding of some radians a step


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
