"""Exudyn's five engines against the reference, their order, their frames and their silence."""

from __future__ import annotations

import dataclasses
import math
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import pytest

import adapters.exudyn.solver as solver_module
from adapters.common.kepler import propagate
from adapters.engine import Engine, EngineError
from adapters.exudyn.adapter import Exudyn, ExudynAbsolute, ExudynAbsoluteIndex3, ExudynIndex3, ExudynTree
from adapters.exudyn.effects import encke
from adapters.exudyn.frames import KeplerOrbit, OrbitFrame, turned
from adapters.exudyn.time_inputs import Steps, tabulated
from adapters.trajectory import Observable, Trajectory
from scenarios import Actuator, Frame, Scene, load_scene, make_scene, scene_names
from scenarios.scene import Orbit
from tests.support.changed import lasting, on_orbit, under
from tests.support.generic_scenes import solution
from tests.support.slow import one_in, rows

if TYPE_CHECKING:
    from adapters.exudyn.adapter import ExudynEngine

ENGINES = (Exudyn, ExudynIndex3, ExudynAbsolute, ExudynAbsoluteIndex3, ExudynTree)
REFERENCE_RAD = 1e-10  # the reference's own error over an orbit of an unstable chain at rtol 1e-13
MU = 3.986004418e14


def shortened(name: str, orbits: float, samples: int) -> Scene:
    scene = load_scene(name)
    return lasting(scene, orbits * scene.period_s, samples)


def run(engine: type[Engine], scene: Scene, steps: float | None = None) -> Trajectory:
    return engine().run(scene, engine.sweep.setting(steps))


def error(found: Trajectory, scene: Scene, name: str) -> float:
    difference = getattr(found, name) - getattr(solution(scene), name)
    return float(np.abs(difference).max(initial=0.0))


def scale(scene: Scene, name: str) -> float:
    return float(np.abs(getattr(solution(scene), name)).max(initial=0.0))


def observed_ratio(engine: type[Engine], scene: Scene, steps: float, name: str) -> float:
    return error(run(engine, scene, steps), scene, name) / error(run(engine, scene, 2 * steps), scene, name)


def explained(coarse: Trajectory, fine: Trajectory, scene: Scene, name: str, *, floor: float) -> bool:
    """Whether the fine run's error is the third of its change from the coarse one that order 2 allows."""
    ratio = (float(fine.info["steps"]) / float(coarse.info["steps"])) ** 2
    change = float(np.abs(getattr(fine, name) - getattr(coarse, name)).max(initial=0.0))
    return error(fine, scene, name) <= 1.3 * change / (ratio - 1.0) + floor


def test_the_first_orbit_of_fig05_agrees_to_a_microradian_and_a_tenth_of_a_micronewton() -> None:
    scene = shortened("paper/fig05", 1.0, 11)
    found = run(Exudyn, scene, 10000)
    assert error(found, scene, "angle_rad") < 1e-6
    assert error(found, scene, "reaction_N") < 1e-7


def test_the_tree_agrees_on_fig05_to_the_references_own_accuracy() -> None:
    scene = shortened("paper/fig05", 1.0, 11)
    found = run(ExudynTree, scene)
    assert error(found, scene, "angle_rad") < REFERENCE_RAD
    assert error(found, scene, "reaction_N") < 1e-11  # 1e-10 rad of a chain whose 0.04 N follow from some radians
    assert found.gap_m is None
    assert Observable.GAP not in ExudynTree.observables


@pytest.mark.parametrize("engine", [Exudyn, ExudynIndex3, ExudynAbsolute])
@pytest.mark.parametrize("scene", one_in(2, ["paper/fig13", "paper/fig09"]))
def test_halving_the_step_quarters_the_error(engine: type[Engine], scene: str) -> None:
    short = shortened(scene, 0.5, 6)
    # index 3 starts with a transient in its multipliers that dies by 0.9 a step: 5e-10 at the first sample
    steps = 2000 if engine is ExudynIndex3 else 500
    assert 3.6 < observed_ratio(engine, short, steps, "angle_rad") < 4.4
    assert 3.6 < observed_ratio(engine, short, steps, "reaction_N") < 4.4


def test_the_tree_is_of_sixth_order() -> None:
    short = shortened("paper/fig13", 1.0, 6)
    assert 5.0 < math.log2(observed_ratio(ExudynTree, short, 50, "angle_rad")) < 7.5


@pytest.mark.parametrize("name", one_in(2, ["paper/fig13", "paper/fig15"]))
def test_eccentric_orbits_are_carried_exactly(name: str) -> None:
    scene = shortened(name, 1.0, 21)
    coarse, fine = run(Exudyn, scene, 1000), run(Exudyn, scene, 2000)
    for quantity in ("angle_rad", "rate_rad_s", "reaction_N"):
        assert explained(coarse, fine, scene, quantity, floor=1e-9 * scale(scene, quantity))
    tree = run(ExudynTree, scene)
    assert error(tree, scene, "angle_rad") < 1e-8
    assert error(tree, scene, "reaction_N") < 1e-8 * scale(scene, "reaction_N")
    assert error(tree, scene, "com_m") < 1e-12 * scale(scene, "com_m")  # 7 micrometres


@pytest.mark.parametrize(
    ("engine", "frame", "actuator", "bar"),
    one_in(7, rows(product([Exudyn, ExudynIndex3], [f for f in Frame if f.of_bar], Actuator, [1, 3]))),
)
def test_every_way_of_prescribing_a_rotation(engine: type[Engine], frame: Frame, actuator: Actuator, bar: int) -> None:
    scene = shortened("paper/fig17", 1 / 80, 4)
    law = dataclasses.replace(scene.effects.prescribed_rotation[0], bar=bar, frame=frame, actuator=actuator)
    scene = under(scene, prescribed_rotation=(law,))
    coarse, fine = run(engine, scene, 10000), run(engine, scene, 20000)
    for quantity in ("angle_rad", "torque_N_m", "reaction_N"):
        floor = 1e-10 if quantity == "angle_rad" else 5e-5 * scale(scene, quantity)  # what rings from t = 0
        assert explained(coarse, fine, scene, quantity, floor=floor)


@pytest.mark.parametrize("name", one_in(9, [n for n in scene_names() if n.startswith("basics/")]))
def test_every_basic_scene_is_within_its_own_error_estimate(name: str) -> None:
    scene = load_scene(name)
    for engine in (Exudyn, ExudynIndex3):
        coarse, fine = run(engine, scene, 1500), run(engine, scene, 3000)
        assert explained(coarse, fine, scene, "angle_rad", floor=1e-10)
        assert error(fine, scene, "com_m") < 1e-11 * scale(scene, "com_m")
    tree = run(ExudynTree, scene)
    assert error(tree, scene, "angle_rad") < 1e-6
    assert error(tree, scene, "com_m") < 1e-11 * scale(scene, "com_m")
    coarse, fine = run(ExudynAbsolute, scene, 1500), run(ExudynAbsolute, scene, 3000)
    assert explained(coarse, fine, scene, "com_m", floor=1e-11 * scale(scene, "com_m"))


@pytest.mark.parametrize("engine", [Exudyn, ExudynTree])
def test_the_longitude_only_turns_everything(engine: type[Engine]) -> None:
    scene = shortened("paper/fig13", 0.6, 7)
    by = 2.3
    here, there = run(engine, scene, 400), run(engine, on_orbit(scene, longitude_rad=by), 400)
    assert here.angle_rad is not None
    assert here.reaction_N is not None
    np.testing.assert_allclose(there.angle_rad, here.angle_rad + by, rtol=0, atol=1e-10)
    np.testing.assert_allclose(there.com_m, turned(here.com_m, np.array(by)), rtol=0, atol=1e-12 * 7e6)
    np.testing.assert_allclose(there.reaction_N, turned(here.reaction_N, np.array(by)), rtol=0, atol=1e-10)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("speed_factor", [0.0, 0.5])
def test_a_bar_below_the_surface_ends_the_run(engine: type[Engine], speed_factor: float) -> None:
    scene = lasting(on_orbit(load_scene("paper/fig05"), speed_factor=speed_factor), 900.0, 46)
    found = run(engine, scene, 1000)
    assert "surface" in found.ended
    assert len(found.t_s) == len(solution(scene).t_s) < 46


def test_springs_far_stiffer_than_the_motion_is_fast_are_carried_to_the_end() -> None:
    """Newton's method can't go below the rounding of their torques: this run stopped after 19.5 s of 30 s."""
    scene = make_scene(
        {
            "title": "PD", "source": "made up", "orbit": {"altitude_m": 500e3},
            "run": {"duration_s": 30.0, "samples": 61},
            "chain": {
                "bars": 4, "mass_kg": [30.0, 20.0, 8.0], "length_m": [2.0, 1.5, 0.8], "angle_from": "inertial",
                "angle_deg": [90.0, 30.0, -10.0, -50.0], "rate_rad_s": 0.0,
                "end_body": [{"at": "first", "mass_kg": 500.0, "inertia_kg_m2": 180.0, "joint_m": 0.7}],
            },
            "effects": {
                "gravity": "none",
                "joint_spring_damper": {
                    "stiffness_N_m_rad": [40.0, 15.0, 5.0], "damping_N_m_s_rad": [60.0, 30.0, 8.0],
                    "rest_deg": [-60.0, -40.0, -40.0],
                    "set_point": [{"joint": 2, "times_s": [10.0, 30.0], "angle_deg": [-40.0, -10.0]}],
                },
            },
        }
    )  # fmt: skip
    seen = Exudyn().run(scene, Exudyn.sweep.setting())
    assert seen.t_s[-1] == scene.run.duration_s


def test_an_engine_that_gives_up_says_so_in_one_line(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(solver_module, "FLOOR", 0.0)
    monkeypatch.setattr(solver_module, "RESIDUAL_FRACTION", 0.0)
    with pytest.raises(EngineError, match=r"^Exudyn: the solver stopped after t = .* s$"):
        run(Exudyn, shortened("paper/fig05", 0.1, 3), 100)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("path_deg", [0.0, 25.0, -70.0])
@pytest.mark.parametrize("beta", [0.4, 0.9, 1.0, 1.00001, 1.2, 1.41421, math.sqrt(2.0), 1.41422, 1.6, 3.0])
def test_the_frames_orbit_conserves_what_kepler_conserves(beta: float, path_deg: float) -> None:
    radius = 6.728e6
    unit_s = math.sqrt(radius**3 / MU)
    start = Orbit(350e3, beta, 0.4, math.radians(path_deg))
    track, longitude = KeplerOrbit(MU, radius, start).at(np.linspace(0.0, 20.0 * unit_s, 400))
    r = track.radius_m / radius
    momentum = r**2 * track.rate_rad_s * unit_s
    speed2 = (track.radial_velocity_m_s * unit_s / radius) ** 2 + (r * track.rate_rad_s * unit_s) ** 2
    near = 1.0 / r.min()  # speeds at the perigee are so much larger
    np.testing.assert_allclose(momentum, start.onward, rtol=1e-14)
    np.testing.assert_allclose(0.5 * speed2 - 1.0 / r, 0.5 * beta**2 - 1.0, rtol=0, atol=2e-14 * (1 + near + beta**2))
    np.testing.assert_allclose(track.shape, track.rate_rad_s**2 / track.pull_s2 - 1.0, rtol=0, atol=1e-13)
    assert np.all(np.diff(longitude) > 0.0)
    assert longitude[0] == 0.4


@pytest.mark.parametrize("path_deg", [0.0, 25.0, -70.0])
@pytest.mark.parametrize("beta", [0.9, 1.1, math.sqrt(2.0), 1.6])
def test_the_frames_orbit_is_the_propagated_one(beta: float, path_deg: float) -> None:
    radius, t_s = 6.728e6, np.linspace(0.0, 9000.0, 50)
    start = Orbit(350e3, beta, 0.4, math.radians(path_deg))
    axes = OrbitFrame(KeplerOrbit(MU, radius, start)).at(t_s)
    speed = math.sqrt(MU / radius)
    velocity = np.array([start.upward, start.onward]) * speed
    turn = np.array([[math.cos(0.4), math.sin(0.4)], [-math.sin(0.4), math.cos(0.4)]])
    place, moving = propagate(MU, np.array([radius, 0.0]) @ turn, velocity @ turn, t_s)
    worst = (radius / np.linalg.norm(place, axis=1)).max() ** 2  # Kepler's equation at the perigee
    assert np.abs(axes.origin_m - place).max() <= 1e-13 * worst * np.abs(place).max()
    assert np.abs(axes.origin_velocity_m_s - moving).max() <= 1e-13 * worst * np.abs(moving).max()


def test_the_orbits_numbers_hold_inside_a_step() -> None:
    orbit = KeplerOrbit(MU, 6.728e6, Orbit(350e3, 1.2, 0.0))
    steps = Steps(9000.0 / 50, 50)
    table = tabulated(OrbitFrame(orbit).time_inputs, steps, 7).reshape(51, -1, 8)
    u = -0.37
    exact, _ = orbit.at(steps.ends_s + u * steps.size_s)
    for i, number in enumerate(dataclasses.astuple(exact)):
        fitted = table[:, i] @ (2 * u + 1) ** np.arange(8)
        np.testing.assert_allclose(fitted, number, rtol=0, atol=1e-9 * np.abs(number).max())


@pytest.mark.parametrize("name", ["paper/fig05", "paper/fig13", "effects/thrust"])
@pytest.mark.parametrize("engine", [Exudyn, ExudynTree])
def test_loads_applied_twice_at_half_strength_give_the_same_motion(engine: type[ExudynEngine], name: str) -> None:
    """The loads' share of a run is timed so: their sum may differ in its last digit, which the run amplifies."""
    scene = shortened(name, 0.1, 5)
    setting = engine.sweep.setting(200)
    once, twice = engine().run(scene, setting), engine(repeated_load=True).run(scene, setting)
    for quantity in ("angle_rad", "reaction_N"):
        a, b = (getattr(found, quantity) for found in (once, twice))
        # a last digit in each of some 20 steps, and Newton's tolerance, 1e-10 of the smallest forces
        assert np.abs(a - b).max() <= 1e-9 * np.abs(a).max()


@pytest.mark.parametrize("q", [0.0, 1e-320, 1e-14, -1e-9, 3.7e-5, -0.3, 0.9, 8.0])
def test_enckes_number_is_exact_in_its_symbolic_form_too(q: float) -> None:
    from exudyn import symbolic

    mpmath = pytest.importorskip("mpmath")
    recording = symbolic.GetRecording()
    symbolic.SetRecording(True)
    try:
        found = encke(symbolic.Real("q", q), symbolic)[0].Evaluate()
    finally:
        symbolic.SetRecording(recording)
    with mpmath.workdps(400):
        exact = (1 + mpmath.mpf(q)) ** mpmath.mpf("-1.5") - 1
        off = abs(float(mpmath.mpf(found) - exact))
    # eight operations of a rounding each; a number below the smallest normal one is lost whole
    assert off <= 8 * np.finfo(float).eps * abs(float(exact)) + np.finfo(float).tiny
