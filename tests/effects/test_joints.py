"""Joints with motors: laws of their angles, as turns or tables, torques in time, and springs whose rest angle moves."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _pytest.mark import ParameterSet
from scipy.integrate import quad, simpson
from scipy.interpolate import make_interp_spline

from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain.metrics.derived import Motion, columns_of
from barchain.solutions.judging import solution_engine
from reference_impl.model import invariants
from scenarios import Gravity, JointTorque, Scene, change_scene, go_on, load_scene
from scenarios.toml.start_table import state_tables


def forms(*names: str) -> list[ParameterSet]:
    """Engines as parameters; one that is not installed is skipped with the reason."""
    missing = {name: ENGINES[name].missing for name in names}
    return [
        pytest.param(name, marks=pytest.mark.skipif(bool(reason), reason=reason or ""))
        for name, reason in missing.items()
    ]


FORMS = forms("reference-fast", "heyoka")
WITH_NUMPY = forms("reference", "reference-fast", "heyoka")
WITH_ABSOLUTE = forms("reference", "reference-fast", "reference-absolute", "heyoka")


def moved(scene: Scene, engine: str) -> Trajectory:
    """Run of an engine, with its scene."""
    return ENGINES[engine].engine().run(scene, Setting(AccuracyParameter.RTOL, 1e-13)).of_run(scene)


# laws of angles


def arm(*laws: dict[str, Any]) -> Scene:
    """First two bars of the shipped arm, at rest without forces, with laws of their joint's angle."""
    chain = {"bars": 2, "mass_kg": [500.0, 20.0], "length_m": [2.0, 1.5], "angle_deg": [90.0, 20.0], "rate_factor": 0.0}
    turns = [{"bar": 2, "frame": "previous_bar"} | law for law in laws]
    effects = {"gravity": "none", "prescribed_rotation": turns}
    return change_scene(load_scene("effects/joint_slew"), {"chain": chain, "effects": effects})


@pytest.mark.parametrize("engine", FORMS)
def test_the_base_of_an_arm_turns_back_by_the_arms_momentum(engine: str) -> None:
    """Two bars at rest without forces: the base turns by an integral over the joint's angle, whatever the law in time.

    No angular momentum about the centre of mass: theta_1' D = -delta' (J_2 + m (h_2^2 + h_1 h_2 cos delta)) with
    D = J_1 + J_2 + m (h_1^2 + h_2^2 + 2 h_1 h_2 cos delta), m the reduced mass and h half lengths. A hundred steps
    of 1e-13 each, and quad's 1e-12.
    """
    scene = arm({"amplitude_deg": 90.0, "start_s": 30.0, "duration_s": 120.0})
    seen, c = moved(scene, engine), scene.chain
    (m1, m2), (h1, h2), (j1, j2) = c.mass_kg, np.array(c.length_m) / 2.0, c.inertia_kg_m2
    m, bent = m1 * m2 / (m1 + m2), c.angle_rad[1] - c.angle_rad[0]

    def turned(angle: float) -> float:
        far = j2 + m * (h2**2 + h1 * h2 * math.cos(angle))
        return -far / (far + j1 + m * (h1**2 + h1 * h2 * math.cos(angle)))

    expected = quad(turned, bent, bent + math.pi / 2.0, epsabs=1e-13, epsrel=1e-13)[0]
    assert seen.angle_rad[-1, 0] - seen.angle_rad[0, 0] == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("engine", FORMS)
def test_joints_follow_their_laws_and_a_locked_one_keeps_its_angle(engine: str) -> None:
    scene = load_scene("effects/joint_slew")
    seen = moved(scene, engine)
    for law in scene.effects.prescribed_rotation:
        bent = seen.angle_rad[:, law.bar - 1] - seen.angle_rad[:, law.bar - 2]
        wanted = bent[0] + np.array([law.law(t)[0] for t in seen.t_s.tolist()])
        np.testing.assert_allclose(bent, wanted, atol=1e-9)


def test_motors_give_the_chain_the_energy_of_their_power() -> None:
    """No forces: kinetic energy about the centre of mass is the integral of torque times the joint's rate.

    Simpson's rule on samples of 2 s over a law of 120 s: its error is below (2 pi 3/120 2)^4/180 of the work.
    """
    scene = load_scene("effects/joint_slew")
    scene = change_scene(scene, {"chain": {"rate_factor": 0.0}, "effects": {"gravity": "none"}})
    seen, model = moved(scene, solution_engine()), chain_model(scene)
    energy = invariants.relative_kinetic_energy(model, seen.angle_rad, seen.rate_rad_s)
    power = sum(columns_of(Motion(seen), "torque_power").values())
    middle = len(seen.t_s) // 2 // 2 * 2  # inside the law, where the arm moves
    step = seen.t_s[1]
    work = step / 3.0 * (power[0] + 4.0 * power[1:middle:2].sum() + 2.0 * power[2:middle:2].sum() + power[middle])
    assert energy[middle] > 1e-3
    assert energy[middle] - energy[0] == pytest.approx(work, abs=1e-4 * energy.max())
    assert np.abs(invariants.relative_angular_momentum(model, seen.angle_rad, seen.rate_rad_s)).max() < 1e-9


@pytest.mark.parametrize("engine", WITH_NUMPY)
@pytest.mark.parametrize("course", ["paper", "quintic"])
def test_a_joint_turned_twice_is_held_between_and_follows_both_courses(engine: str, course: str) -> None:
    """10 s^3 - 15 s^4 + 6 s^5, by its coefficients, and the integrator's error of a hundred steps of 1e-13."""
    second = {"amplitude_deg": 90.0, "start_s": 90.0, "duration_s": 60.0, "course": course}
    scene = arm(second, {"amplitude_deg": 40.0, "start_s": 20.0, "duration_s": 50.0, "course": "quintic"})
    seen = moved(scene, engine)
    bent = np.degrees(np.diff(seen.angle_rad, axis=1)[:, 0] - seen.angle_rad[0, 1] + seen.angle_rad[0, 0])
    s = np.clip((seen.t_s - 20.0) / 50.0, 0.0, 1.0)
    quintic = 40.0 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
    x = np.clip((seen.t_s - 90.0) / 60.0, 0.0, 1.0)
    share = 10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5
    if course == "paper":
        share = (np.cos(3.0 * np.pi * x) - 9.0 * np.cos(np.pi * x) + 8.0) / 16.0
    np.testing.assert_allclose(bent, quintic + 90.0 * share, atol=1e-8)
    laws = [law.law for law in scene.effects.prescribed_rotation]
    told = [sum(law(at)[0] for law in laws) for at in seen.t_s.tolist()]
    np.testing.assert_allclose(np.degrees(told), quintic + 90.0 * share, atol=1e-9)


@pytest.mark.parametrize("engine", WITH_NUMPY)
def test_joints_follow_the_quintic_splines_through_their_tables(engine: str) -> None:
    """SciPy's spline through the same points, and the integrator's error of some hundred steps of 1e-13."""
    rest = [(1, 0.0), (2, 0.0)]
    scene = load_scene("effects/joint_table")
    seen = moved(scene, engine)
    joints = np.degrees(np.diff(seen.angle_rad, axis=1))
    for joint, times, angles in (
        (0, [20.0, 60.0, 110.0, 150.0, 220.0], [0.0, 35.0, 80.0, 60.0, 0.0]),
        (1, [20.0, 80.0, 140.0, 220.0], [0.0, -50.0, 15.0, 0.0]),
    ):
        spline = make_interp_spline(times, angles, k=5, bc_type=(rest, rest))
        wanted = spline(np.clip(seen.t_s, times[0], times[-1]))
        np.testing.assert_allclose(joints[:, joint] - joints[0, joint], wanted, atol=1e-8)
        law = scene.effects.prescribed_rotation[joint].law
        np.testing.assert_allclose(np.degrees([law(at)[0] for at in seen.t_s.tolist()]), wanted, atol=1e-9)


# torques and springs


def free(**effects: Any) -> Scene:
    """Two equal bars at rest in free space, with these effects."""
    chain = {"mass_kg": 20.0, "length_m": 4.0, "angle_deg": [10.0, 30.0], "rate_factor": 0.0}
    changes = {"orbit": {"speed_factor": 0.0}, "chain": chain, "run": {"duration_s": 60.0, "samples": 61}}
    return change_scene(load_scene("basics/two_bars_free"), changes | {"effects": effects})


@pytest.mark.parametrize("engine", WITH_ABSOLUTE)
def test_scissors_open_with_the_work_of_the_motors_constant_torque(engine: str) -> None:
    """Equal bars about their joint: with half the opening a, (J + m h^2 cos^2 a) a'^2 = T (2 a - 2 a_0).

    The centre of mass stays half way between the bars' centres, h cos a off the joint; each bar's centre moves by
    h sin a across. Some hundred steps of 1e-13 each.
    """
    seen = moved(free(joint_torque=[{"joint": 1, "torque_N_m": 0.05}]), engine)
    angle, rate = seen.angle_rad, seen.rate_rad_s
    half, opening = 0.5 * (math.pi - np.diff(angle, axis=1)[:, 0]), np.diff(rate, axis=1)[:, 0]
    inertia = 20.0 * 4.0**2 / 12.0 + 20.0 * 2.0**2 * np.cos(half) ** 2
    work = 0.05 * (np.diff(angle, axis=1)[:, 0] - math.radians(20.0))
    np.testing.assert_allclose(inertia * (0.5 * opening) ** 2, work, atol=1e-10)
    np.testing.assert_allclose(rate.sum(axis=1), 0.0, atol=1e-13)  # no torque from outside


@pytest.mark.parametrize("engine", WITH_ABSOLUTE)
def test_a_moving_rest_angle_is_a_spring_and_a_damper_about_it(engine: str) -> None:
    """J/2 b'' = -k (b - s) - c (b' - s') for small angles b beside a straight chain, s a ramp: sums of exponentials.

    What is left out is of the order of the angles squared, 1e-6 of them.
    """
    point = {"joint": 1, "times_s": [10.0, 30.0], "angle_deg": [0.0, 0.05]}
    springs = {"stiffness_N_m_rad": 1.5, "damping_N_m_s_rad": 4.0, "rest_deg": 20.0, "set_point": [point]}
    scene = free(joint_spring_damper=springs)
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
    springs = dataclasses.replace(scene.effects.joint_spring_damper, stiffness_N_m_rad=(2.0, 2.0, 2.0))
    changed = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, joint_spring_damper=springs))
    changed.to_toml(tmp_path / "again.toml")
    assert load_scene(str(tmp_path / "again.toml")).effects == changed.effects


def test_a_torque_may_jump_between_two_equal_instants() -> None:
    times_s, torque_N_m = (0.0, 30.0, 30.0, 60.0), (1.0, 1.0, -1.0, -1.0)
    table = {"joint": 1, "times_s": list(times_s), "torque_N_m": list(torque_N_m)}
    (motor,) = free(joint_torque=[table]).effects.joint_torque
    assert motor == JointTorque(1, times_s, torque_N_m)
    assert (motor.size_N_m(30.0), motor.size_N_m(31.0)) == (1.0, -1.0)  # at the jump, just before it


@pytest.mark.parametrize("engine", FORMS)
def test_a_torque_in_a_joint_that_a_law_drives_changes_the_torque_of_the_law_alone(engine: str) -> None:
    """The law's motor gives what the angle needs and the other motor does not; some hundred steps of 1e-13 each."""
    alone = load_scene("effects/joint_slew")
    motor = JointTorque(1, (0.0, alone.run.duration_s), (0.1, 0.1))
    both = dataclasses.replace(alone, effects=dataclasses.replace(alone.effects, joint_torque=(motor,)))
    one, other = (moved(scene, engine) for scene in (alone, both))
    np.testing.assert_allclose(other.angle_rad, one.angle_rad, rtol=0.0, atol=1e-11)
    inside = slice(1, -1)  # the motor starts and ends with the run
    shift = (other.torque_N_m - one.torque_N_m)[inside]
    largest = np.abs(one.torque_N_m).max()
    np.testing.assert_allclose(shift, np.broadcast_to([-0.1, 0.0], shift.shape), rtol=0.0, atol=1e-9 * largest)
