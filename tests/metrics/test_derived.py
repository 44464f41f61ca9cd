"""Derived channels against closed forms: joints, forces, energies, the osculating orbit."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import barchain
from adapters.common.kepler import propagate
from adapters.trajectory import Array, Trajectory
from barchain.metrics.derived import BY_EFFECT, FUNCTIONS, DerivedError, Motion, chosen_columns, columns_of
from scenarios import Scene, change_scene, load_scene
from scenarios.channels import STORED
from scenarios.derived_channels import DERIVED, DERIVED_CHANNELS
from tests.support.solutions import run

RTOL = 1e-12
SLACK = 1e3 * RTOL
"""Errors of a run at that tolerance, relative to a quantity's size: growth over few turns"""
SPLINE = 7
EVERYTHING = "effects/everything"
assert barchain.Trajectory is Trajectory  # registers derived channels


def moved(scene: Scene, samples: int = 0, duration_s: float = 0.0) -> Trajectory:
    times = dataclasses.replace(
        scene.run, samples=samples or scene.run.samples, duration_s=duration_s or scene.run.duration_s
    )
    scene = dataclasses.replace(scene, run=times)
    return run(scene, RTOL).of_run(scene)


def changed(name: str, **changes: Mapping[str, Any]) -> Scene:
    return change_scene(load_scene(name), changes)


def value(seen: Trajectory, name: str) -> Array:
    return FUNCTIONS[name](Motion(seen))


def slope(t_s: Array, values: Array) -> Array:
    found: Array = make_interp_spline(t_s, values, SPLINE).derivative()(t_s)
    return found


@pytest.fixture(scope="module")
def five_bars() -> Trajectory:
    return moved(load_scene("paper/fig05"), samples=101)


def test_every_entry_has_one_function_and_no_name_twice() -> None:
    names = [channel.name for channel in (*STORED, *DERIVED)]
    assert len(set(names)) == len(names)
    assert {*FUNCTIONS, *BY_EFFECT} == DERIVED_CHANNELS.keys()


def test_every_channel_has_the_columns_of_its_entry() -> None:
    seen = moved(load_scene(EVERYTHING), samples=5)
    frame = seen.to_frame(derived=list(DERIVED_CHANNELS))
    assert not frame.columns.duplicated().any()
    for channel in DERIVED:
        stems = [stem.replace("effect", "drag", 1) for stem in channel.stems]
        names = dataclasses.replace(channel, stems=tuple(stems)).names(load_scene(EVERYTHING))
        assert {name + channel.ending for name in names} <= set(frame.columns)
    assert np.isfinite(frame.to_numpy(float)).all()


def test_joint_angles_sum_to_the_turn_of_the_last_bar_from_the_first(five_bars: Trajectory) -> None:
    for name, of_bars in (("joint_angle", five_bars.angle_rad), ("joint_rate", five_bars.rate_rad_s)):
        between = value(five_bars, name)
        apart = np.abs(between.sum(axis=1) - (of_bars[:, -1] - of_bars[:, 0])).max()
        assert between.shape[1] == of_bars.shape[1] - 1
        assert apart <= 8 * np.finfo(float).eps * np.abs(of_bars).max()


def test_the_angle_from_the_vertical_starts_as_the_scene_gives_it(five_bars: Trajectory) -> None:
    """Scenes count from the local horizontal, which is the vertical turned by -90°."""
    from_vertical = np.array(five_bars.run_scene.chain.angle_rad) - 0.5 * math.pi
    assert value(five_bars, "vertical_angle")[0] == pytest.approx(from_vertical, abs=1e-14)


def test_bars_balance_about_the_centre_of_mass_and_joints_are_half_a_bar_from_both_bars(five_bars: Trajectory) -> None:
    scene = five_bars.run_scene
    bars, joints = value(five_bars, "bar_from_com"), value(five_bars, "joint_from_com")
    half = 0.5 * np.array(scene.chain.length_m)
    rounding = 1e-14 * sum(scene.chain.length_m)
    assert np.abs(np.array(scene.chain.mass_kg) @ bars).max() <= rounding * scene.mass_kg
    assert np.linalg.norm(joints - bars[:, :-1], axis=-1) == pytest.approx(np.tile(half[:-1], (len(bars), 1)))
    assert np.linalg.norm(joints - bars[:, 1:], axis=-1) == pytest.approx(np.tile(half[1:], (len(bars), 1)))


def test_frames_differ_by_the_centre_of_mass_and_by_a_turn(five_bars: Trajectory) -> None:
    com = five_bars.com_m
    for what in ("bar", "joint", "end"):
        about, inertial, local = (
            value(five_bars, f"{what}_{frame}").reshape(len(com), -1, 2) for frame in ("from_com", "position", "local")
        )
        assert np.array_equal(inertial, com[:, None] + about)
        assert np.linalg.norm(local, axis=-1) == pytest.approx(np.linalg.norm(about, axis=-1))
        vertical = (com / np.linalg.norm(com, axis=-1, keepdims=True))[:, None]
        assert local[..., 0] == pytest.approx(np.sum(about * vertical, axis=-1), abs=1e-9)


def test_two_spinning_bars_pull_at_their_joint_as_they_should_and_have_the_energy_of_one_rigid_bar() -> None:
    """The pull is the mass times half a length times the rate squared."""
    chain = {"mass_kg": [40.0, 40.0], "length_m": [60.0, 60.0], "angle_deg": [90.0, 90.0], "rate_factor": [5.0, 5.0]}
    scene = changed("basics/two_bars_free", chain=chain)
    seen, rate = moved(scene, samples=11), 5.0 * scene.orbital_rate_rad_s
    pull = 40.0 * 30.0 * rate**2
    tension, shear = value(seen, "tension"), value(seen, "shear")
    assert tension[:, 0, 1] == pytest.approx(pull, rel=SLACK)
    assert tension[:, 1, 0] == pytest.approx(pull, rel=SLACK)
    assert np.all(tension[:, 0, 0] == 0.0)
    assert np.all(tension[:, 1, 1] == 0.0)
    assert np.abs(shear).max() < SLACK * pull
    inertia = 80.0 * 120.0**2 / 12.0
    assert value(seen, "kinetic_energy") == pytest.approx(0.5 * inertia * rate**2, rel=SLACK)
    assert value(seen, "spin_momentum") == pytest.approx(inertia * rate, rel=SLACK)
    assert np.all(value(seen, "gravity_energy") == 0.0)


def test_energy_and_angular_momentum_stay_in_free_space() -> None:
    undamped = {"stiffness_N_m_rad": [2.0, 0.5], "damping_N_m_s_rad": [0.0, 0.0], "rest_deg": [10.0, -5.0]}
    for scene in (
        load_scene("basics/two_bars_free"),
        changed("conform/joint_springs_alone", effects={"gravity": "none", "joint_spring_damper": undamped}),
    ):
        seen = moved(scene)
        for name in ("total_energy", "spin_momentum"):
            found = value(seen, name)
            assert np.abs(found - found[0]).max() < SLACK * np.abs(found[0])


@pytest.mark.parametrize("name", ["effects/drag", "effects/slender"])
def test_forces_of_effects_sum_to_the_mass_times_the_acceleration_of_the_centre_of_mass(name: str) -> None:
    scene = load_scene(name)
    seen = moved(scene, samples=201, duration_s=min(scene.run.duration_s, 0.2 * scene.period_s))
    whole = np.sum([wrench[0] for wrench in Motion(seen).wrenches.values()], axis=0).sum(axis=1)
    force = np.stack([whole.real, whole.imag], axis=-1)
    pushed = scene.mass_kg * slope(seen.t_s, seen.com_velocity_m_s)
    inside = slice(10, -10)  # a spline has no neighbours at its ends
    assert np.abs(force - pushed)[inside].max() < 1e-9 * np.abs(pushed).max()


@pytest.mark.parametrize("name", ["effects/third_body", "effects/joint_springs"])
def test_tension_shear_and_effects_move_every_bar(name: str) -> None:
    """Newton's and Euler's equations about the centre of mass, with reactions by their components at each bar."""
    scene = load_scene(name)
    seen = moved(scene, samples=401, duration_s=min(scene.run.duration_s, 0.2 * scene.period_s))
    motion, inside = Motion(seen), slice(20, -20)
    mass, inertia = np.array(scene.chain.mass_kg), np.array(scene.chain.inertia_kg_m2)
    half = 0.5 * np.array(scene.chain.length_m)
    force, torque = (np.sum([w[k] for w in motion.wrenches.values()], axis=0) for k in (0, 1))
    tension, shear = value(seen, "tension"), value(seen, "shear")
    turned = torque + half * (shear[..., 0] + shear[..., 1])
    angular = slope(seen.t_s, seen.rate_rad_s)
    assert np.abs(inertia * angular - turned)[inside].max() < 1e-8 * np.abs(turned).max()
    along = np.exp(1j * seen.angle_rad)
    pull = (tension[..., 1] - tension[..., 0]) + 1j * (shear[..., 1] - shear[..., 0])
    relative = value(seen, "bar_from_com")
    accelerated = slope(seen.t_s, slope(seen.t_s, relative[..., 0] + 1j * relative[..., 1]))
    of_bar = force - np.outer(force.sum(axis=1), mass / mass.sum()) + pull * along
    assert np.abs(mass * accelerated - of_bar)[inside].max() < 1e-6 * np.abs(of_bar).max()


@pytest.mark.parametrize("sense", [1.0, -1.0], ids=["prograde", "retrograde"])
def test_elements_of_an_eccentric_orbit_are_those_of_kepler(sense: float) -> None:
    scene = load_scene("basics/kepler_elliptic")
    mu, a, e, periapsis = scene.central_body.mu_m3_s2, 2.0e7, 0.6, 0.7
    turn = np.exp(1j * periapsis)
    place, velocity = a * (1.0 - e) * turn, sense * 1j * turn * math.sqrt(mu / a * (1.0 + e) / (1.0 - e))
    period = 2.0 * math.pi * math.sqrt(a**3 / mu)
    t_s = np.linspace(0.0, 0.99 * period, 50)
    com, speed = propagate(mu, np.array([place.real, place.imag]), np.array([velocity.real, velocity.imag]), t_s)
    seen = Trajectory(t_s, com, speed).of_run(scene)
    assert value(seen, "semi_major_axis") == pytest.approx(a, rel=1e-12)
    assert value(seen, "eccentricity") == pytest.approx(e, rel=1e-12)
    assert value(seen, "periapsis") == pytest.approx(periapsis, rel=1e-11)
    assert value(seen, "altitude") == pytest.approx(np.linalg.norm(com, axis=1) - scene.central_body.radius_m)
    anomaly = value(seen, "true_anomaly")[1:]  # at the periapsis itself 0 and 2π are one
    eccentric = 2.0 * np.arctan2(math.sqrt(1.0 - e) * np.sin(0.5 * anomaly), math.sqrt(1.0 + e) * np.cos(0.5 * anomaly))
    mean = eccentric - e * np.sin(eccentric)
    assert mean == pytest.approx(2.0 * math.pi * t_s[1:] / period, abs=1e-11)


def test_channels_are_chosen_in_the_order_of_their_names(five_bars: Trajectory) -> None:
    frame = chosen_columns(five_bars, ["joint_angle", "reaction"])
    assert list(frame.columns)[:2] == ["t_s", "joint_angle_1_rad"]
    assert list(frame.columns)[-1] == "reaction_4_y_N"
    assert len(frame.columns) == 1 + 4 + 8


def test_one_column_of_a_channel_can_be_chosen(five_bars: Trajectory) -> None:
    whole = chosen_columns(five_bars, ["joint_angle", "reaction"])
    frame = chosen_columns(five_bars, ["joint_angle_2_rad", "reaction_4_y_N"])
    assert frame.equals(whole[["t_s", "joint_angle_2_rad", "reaction_4_y_N"]])
    with pytest.raises(DerivedError, match="of this channel it has joint_angle_1_rad"):
        chosen_columns(five_bars, ["joint_angle_9_rad"])


def test_a_motor_shows_what_was_before_it_was_switched_on_and_off() -> None:
    motor = {"joint": 1, "torque_N_m": 0.1, "start_s": 2.0, "duration_s": 4.0}
    tables = {
        "title": "motor", "source": "test", "orbit": {"altitude_m": 5e5}, "run": {"duration_s": 10.0, "samples": 6},
        "chain": {"bars": 2, "mass_kg": 10.0, "length_m": 10.0, "angle_deg": 90.0},
    }  # fmt: skip
    for start_s, torques in ((2.0, [0.0, 0.0, -0.1, -0.1, 0.0, 0.0]), (0.0, [-0.1, -0.1, -0.1, 0.0, 0.0, 0.0])):
        effects = {"gravity": "none", "joint_torque": [motor | {"start_s": start_s}]}
        seen = moved(barchain.make_scene(tables | {"effects": effects}))
        assert chosen_columns(seen, ["joint_torque"])["joint_torque_1_N_m"].tolist() == torques


def test_an_unknown_name_gives_one_line_with_the_nearest(five_bars: Trajectory) -> None:
    with pytest.raises(ValueError, match=r"did you mean joint_angle\?\), allowed: joint_angle, ") as error:
        five_bars.to_frame(derived=["joint_angel"])
    assert "\n" not in str(error.value)
    with pytest.raises(ValueError, match=r"allowed: a list of names, e.g. \['tension'\]"):
        five_bars.to_frame(derived="tension")


def test_what_a_particle_has_not_is_told_and_its_orbit_is_there() -> None:
    scene = load_scene("basics/kepler_elliptic")
    seen = Trajectory(np.zeros(1), np.array([[1e7, 0.0]]), np.array([[0.0, 7e3]])).of_run(scene)
    with pytest.raises(DerivedError, match=r"^joint_angle needs angles \(angle_rad\), which this trajectory lacks$"):
        columns_of(Motion(seen), "joint_angle")
    assert columns_of(Motion(seen), "eccentricity").keys() == {"eccentricity"}


def test_what_a_scene_has_not_is_told(five_bars: Trajectory) -> None:
    with pytest.raises(DerivedError, match="needs the effect joint_spring_damper or joint_torque, which paper/fig05"):
        columns_of(Motion(five_bars), "joint_torque")
    free = moved(load_scene("conform/one_bar_free"), samples=3)
    for name, lacking in (("joint_angle", "joints"), ("effect_force", "effects"), ("eccentricity", "gravity")):
        with pytest.raises(DerivedError, match=f"{name} needs {lacking}"):
            columns_of(Motion(free), name)


def test_a_trajectory_from_elsewhere_asks_for_its_scene(five_bars: Trajectory) -> None:
    bare = dataclasses.replace(five_bars, run_scene=None)
    assert "joint_angle_4_rad" in bare.to_frame(derived=["joint_angle"])
    with pytest.raises(ValueError, match=r"kinetic_energy needs the scene of the run; give it by Trajectory.of_run"):
        bare.to_frame(derived=["kinetic_energy"])
