"""Motors in joints: torques that are tables in time, and springs whose rest angle moves."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson

from barchain.metrics.derived import Motion, columns_of
from barchain.solutions.judging import solution_engine
from scenarios import Gravity, JointTorque, Scene, SceneError, change_scene, go_on, load_scene
from scenarios.toml.start_table import state_tables
from tests.effects.joint_runs import forms, moved

FORMS = forms("reference", "reference-fast", "reference-absolute", "heyoka")
FREE = """
title = "Two equal bars at rest"
source = "test"
[orbit]
altitude_m = 500e3
speed_factor = 0.0
[chain]
bars = 2
mass_kg = 20.0
length_m = 4.0
angle_deg = [10.0, 30.0]
rate_factor = 0.0
[effects]
gravity = "none"
{effects}
[run]
duration_s = 60.0
samples = 61
"""
SPRINGS = """
[effects.joint_spring_damper]
stiffness_N_m_rad = 1.5
damping_N_m_s_rad = 4.0
rest_deg = 20.0
"""


def scene_of(folder: Path, effects: str) -> Scene:
    """Two equal bars at rest in free space, with these effects."""
    (folder / "mine.toml").write_text(FREE.format(effects=effects))
    return load_scene(str(folder / "mine.toml"))


@pytest.mark.parametrize("engine", FORMS)
def test_scissors_open_with_the_work_of_the_motors_constant_torque(engine: str, tmp_path: Path) -> None:
    """Equal bars about their joint: with half the opening a, (J + m h^2 cos^2 a) a'^2 = T (2 a - 2 a_0).

    The centre of mass stays half way between the bars' centres, h cos a off the joint; each bar's centre moves by
    h sin a across. Some hundred steps of 1e-13 each.
    """
    seen = moved(scene_of(tmp_path, "[[effects.joint_torque]]\njoint = 1\ntorque_N_m = 0.05\n"), engine)
    angle, rate = seen.angle_rad, seen.rate_rad_s
    half, opening = 0.5 * (math.pi - np.diff(angle, axis=1)[:, 0]), np.diff(rate, axis=1)[:, 0]
    inertia = 20.0 * 4.0**2 / 12.0 + 20.0 * 2.0**2 * np.cos(half) ** 2
    work = 0.05 * (np.diff(angle, axis=1)[:, 0] - math.radians(20.0))
    np.testing.assert_allclose(inertia * (0.5 * opening) ** 2, work, atol=1e-10)
    np.testing.assert_allclose(rate.sum(axis=1), 0.0, atol=1e-13)  # no torque from outside


@pytest.mark.parametrize("engine", FORMS)
def test_a_moving_rest_angle_is_a_spring_and_a_damper_about_it(engine: str, tmp_path: Path) -> None:
    """J/2 b'' = -k (b - s) - c (b' - s') for small angles b beside a straight chain, s a ramp: sums of exponentials.

    What is left out is of the order of the angles squared, 1e-6 of them.
    """
    point = "[[effects.joint_spring_damper.set_point]]\njoint = 1\ntimes_s = [10.0, 30.0]\nangle_deg = [0.0, 0.05]\n"
    scene = scene_of(tmp_path, SPRINGS + point)
    seen = moved(dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, angle_rad=(0.0, 0.0))), engine)
    roots = np.roots([0.5 * 20.0 * 4.0**2 / 12.0, 4.0, 1.5])
    weights = np.linalg.solve([[1.0, 1.0], roots], [0.0, -1.0])  # at rest when the ramp begins

    def after(t: float) -> float:
        """Response to a ramp of slope 1 that begins at t = 0."""
        return float((t + weights @ np.exp(roots * t)).real) if t > 0.0 else 0.0

    slope = math.radians(0.05) / 20.0
    expected = slope * np.array([after(t - 10.0) - after(t - 30.0) for t in seen.t_s.tolist()])
    np.testing.assert_allclose(np.diff(seen.angle_rad, axis=1)[:, 0], expected, atol=2e-6 * math.radians(0.05))


def test_the_torque_in_a_joint_works_with_the_motion() -> None:
    """The energy of an arm without gravity changes by the work of spring, damper and motor.

    Simpson's rule at 0.1 s errs by h^4/180 of the fourth derivative: with decays of 1/s, 6e-7 of the work.
    """
    scene = load_scene("effects/joint_motors")
    effects = dataclasses.replace(scene.effects, gravity=Gravity.NONE)
    run = dataclasses.replace(scene.run, samples=2401)
    seen = Motion(moved(dataclasses.replace(scene, effects=effects, run=run), solution_engine()))
    t_s = seen.trajectory.t_s
    smooth = (t_s > 20.05) & (t_s < 39.95)  # the set point moves, and the motor of joint 1 rests
    work = simpson(sum(columns_of(seen, "joint_power").values())[smooth], t_s[smooth])
    kinetic = columns_of(seen, "kinetic_energy")["kinetic_energy_J"][smooth]
    assert work == pytest.approx(kinetic[-1] - kinetic[0], rel=1e-5)


def test_a_scene_with_motors_is_written_and_read_back(tmp_path: Path) -> None:
    scene = load_scene("effects/joint_motors")
    scene.to_toml(tmp_path / "again.toml")
    again = load_scene(str(tmp_path / "again.toml"))
    assert again.effects == scene.effects
    assert [motor.joint for motor in scene.effects.joint_torque] == [2, 1]


def test_a_set_point_that_is_written_holds_its_joint_in_a_longer_run_too(tmp_path: Path) -> None:
    """Also of a run that goes on: as a torque in time the control would end with the run."""
    scene = load_scene("conform/joint_set_point")
    state = state_tables(900.0, [6.7e6, 0.0], [0.0, 7.7e3], [0.1, 0.5, 0.3, 0.9], [1e-3] * 4)
    for one in (scene, go_on(scene, state)):
        one.to_toml(tmp_path / "again.toml")
        again = load_scene(str(tmp_path / "again.toml"))
        assert again.digest == one.digest
        later = [change_scene(each, {"run": {"duration_s": 5000.0}}) for each in (one, again)]
        assert later[0].digest == later[1].digest
        assert later[1].effects.joint_torque[0].times_s[-1] == 5000.0


def test_a_scene_that_was_changed_in_python_is_written_with_its_own_values(tmp_path: Path) -> None:
    """The springs alone are other ones: the torque of the set point stays what it was."""
    scene = load_scene("conform/joint_set_point")
    assert scene.effects.joint_spring_damper is not None
    springs = dataclasses.replace(scene.effects.joint_spring_damper, stiffness_N_m_rad=(2.0, 2.0, 2.0))
    changed = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, joint_spring_damper=springs))
    changed.to_toml(tmp_path / "again.toml")
    assert load_scene(str(tmp_path / "again.toml")).effects == changed.effects


def test_a_torque_may_jump_between_two_equal_instants(tmp_path: Path) -> None:
    table = (
        "[[effects.joint_torque]]\njoint = 1\ntimes_s = [0.0, 30.0, 30.0, 60.0]\ntorque_N_m = [1.0, 1.0, -1.0, -1.0]\n"
    )
    (motor,) = scene_of(tmp_path, table).effects.joint_torque
    assert motor == JointTorque(1, (0.0, 30.0, 30.0, 60.0), (1.0, 1.0, -1.0, -1.0))
    assert (motor.size_N_m(30.0), motor.size_N_m(31.0)) == (1.0, -1.0)  # at the jump, just before it


@pytest.mark.parametrize(
    ("effects", "fault"),
    [
        (
            "[[effects.joint_torque]]\njoint = 2\ntorque_N_m = 1.0\n",
            r"joint_torque\[1\].joint: 2 given, allowed: 1 to 1",
        ),
        ("[[effects.joint_torque]]\njoint = 1\ntorque_N_m = [1.0]\n", "lists as both torque_N_m and times_s"),
        (
            SPRINGS
            + 2
            * "[[effects.joint_spring_damper.set_point]]\njoint = 1\ntimes_s = [1.0, 2.0]\nangle_deg = [0.0, 1.0]\n",
            "1 has a set point already",
        ),
    ],
    ids=["no such joint", "no instants", "two set points"],
)
def test_a_motor_that_can_not_be_is_told(effects: str, fault: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=fault):
        scene_of(tmp_path, effects)


@pytest.mark.parametrize("engine", forms("reference", "reference-fast", "heyoka"))
def test_a_torque_in_a_joint_that_a_law_drives_changes_the_torque_of_the_law_alone(engine: str) -> None:
    """The law's motor gives what the angle needs and the other motor does not; some hundred steps of 1e-13 each."""
    alone = load_scene("effects/joint_slew")
    motor = JointTorque(1, (0.0, alone.run.duration_s), (0.1, 0.1))
    both = dataclasses.replace(alone, effects=dataclasses.replace(alone.effects, joint_torque=(motor,)))
    one, other = (moved(scene, engine) for scene in (alone, both))
    assert one.torque_N_m is not None
    assert other.torque_N_m is not None
    np.testing.assert_allclose(other.angle_rad, one.angle_rad, rtol=0.0, atol=1e-11)
    inside = slice(1, -1)  # the motor starts and ends with the run
    shift = (other.torque_N_m - one.torque_N_m)[inside]
    largest = np.abs(one.torque_N_m).max()
    np.testing.assert_allclose(shift, np.broadcast_to([-0.1, 0.0], shift.shape), rtol=0.0, atol=1e-9 * largest)
