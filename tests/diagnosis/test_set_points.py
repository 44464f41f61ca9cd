"""Mistakes in the control of a joint towards a set point are named as such: its gains, its rate, its angle."""

from __future__ import annotations

import dataclasses
import itertools
from functools import partial

import numpy as np
import pytest

from barchain.judge.diagnosis.verdicts import diagnosis_of_verdict
from scenarios import JointTorque, Scene, change_scene, load_scene
from tests.diagnosis.planting import RTOL, diagnosis_of_scene, verdict_on
from tests.support.kernel import needs_kernel
from tests.support.slow import one_in, rows
from tests.support.solutions import run, solution_of

pytestmark = needs_kernel
SCENE = load_scene("conform/joint_set_point")
JOINT = 2
TIMES_S = (0.0, 120.0, 420.0, 600.0, 840.0, 1200.0)
SET_POINT_RAD = np.radians([-20.0, -20.0, 50.0, 50.0, 10.0, 10.0])
STIFFNESS, DAMPING = (1.5, 4.0, 1.0), (150.0, 400.0, 100.0)


def control(
    scene: Scene, springs: tuple[float, ...], dampers: tuple[float, ...], rate: float = 1.0, angle: float = 1.0
) -> Scene:
    """Scene with factors of the stiffness and the damping of each joint, and of the set point's rate and angle."""
    k, c = (
        tuple(a * b for a, b in zip(own, factors, strict=True))
        for own, factors in ((STIFFNESS, springs), (DAMPING, dampers))
    )
    at_first, times_s, torque = float(SET_POINT_RAD[0]), [], []
    for (t0, s0), (t1, s1) in itertools.pairwise(zip(TIMES_S, angle * SET_POINT_RAD, strict=True)):
        times_s += [t0, t1]
        torque += [k[1] * (s - at_first) + c[1] * rate * (s1 - s0) / (t1 - t0) for s in (s0, s1)]
    old = scene.effects.joint_spring_damper
    assert old is not None
    new = dataclasses.replace(old, stiffness_N_m_rad=k, damping_N_m_s_rad=c)
    motor = JointTorque(JOINT, tuple(times_s), tuple(map(float, torque)))
    effects = dataclasses.replace(
        scene.effects, joint_spring_damper=new, joint_torque=(motor, *scene.effects.joint_torque[1:])
    )
    return dataclasses.replace(scene, effects=effects)


RIGHT, NONE, AT_JOINT, TWICE = (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (1.0, 2.0, 1.0)


def test_the_control_of_this_test_is_that_of_the_scene() -> None:
    assert control(SCENE, RIGHT, RIGHT).digest == SCENE.digest


@pytest.mark.parametrize(
    ("mistake", "named"),
    one_in(4, rows([
        ({"dampers": AT_JOINT}, "dampers of joints with set points are missing"),
        ({"dampers": NONE}, "dampers of all joints, towards set points too, are missing"),
        ({"springs": AT_JOINT}, "springs of joints with set points are missing"),
        ({"springs": TWICE}, "spring towards the set point of joint 2 is twice the right value"),
        ({"springs": TWICE, "dampers": TWICE}, "gain of the control in joint 2, of spring and damper, is twice"),
        ({"springs": (2.0,) * 3, "dampers": (2.0,) * 3}, "gain of all joints, of spring and damper, is twice"),
        ({"rate": 0.0}, "rates of the set points are missing in the dampers"),
        ({"angle": -1.0}, "set point of joint 2, with its rate, is of the opposite sign"),
    ])),
)  # fmt: skip
def test_a_wrong_gain_rate_or_angle_of_a_control_is_named(mistake: dict[str, object], named: str) -> None:
    wrong = partial(control, **{"springs": RIGHT, "dampers": RIGHT, **mistake})  # type: ignore[arg-type]
    assert named in str(diagnosis_of_scene(SCENE, wrong))


def test_a_set_point_that_does_not_move_is_no_missing_motor() -> None:
    """The file has no motor, though the resolved scene has one that moves the rest angle."""

    def still(scene: Scene) -> Scene:
        return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, joint_torque=()))

    said = str(diagnosis_of_scene(SCENE, still))
    assert "moving set point is missing" in said
    assert "motor" not in said


OWN_MOTOR = change_scene(
    SCENE, {"effects": {"joint_torque": [{"joint": JOINT, "times_s": [200.0, 700.0], "torque_N_m": [2.0, -1.0]}]}}
)
"""The joint with the set point has a motor of the file, too"""


def test_a_motor_beside_a_set_point_in_one_joint_is_told_from_it() -> None:
    def without_motor(scene: Scene) -> Scene:
        kept = scene.effects.joint_torque[:1]
        return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, joint_torque=kept))

    said = str(diagnosis_of_scene(OWN_MOTOR, without_motor))
    assert "motor in joint 2 is missing" in said
    assert "set point" not in said
    without_rate = partial(control, springs=RIGHT, dampers=RIGHT, rate=0.0)
    assert "rates of the set points are missing" in str(diagnosis_of_scene(OWN_MOTOR, without_rate))


def test_a_file_whose_every_interval_is_beside_a_jump_is_judged_by_other_means() -> None:
    """No interval has a balance of momenta then."""
    table = {"joint": JOINT, "times_s": [20.0, 60.0, 120.0, 180.0], "torque_N_m": [1.0, 2.0, 0.5, 1.0]}
    changes = {"joint_torque": [table], "joint_spring_damper": {"set_point": None}}
    few = change_scene(SCENE, {"effects": changes, "run": {"duration_s": 240.0, "samples": 13}})
    springs = few.effects.joint_spring_damper
    assert springs is not None
    twice = dataclasses.replace(springs, damping_N_m_s_rad=tuple(2.0 * c for c in springs.damping_N_m_s_rad))
    wrong = dataclasses.replace(few, effects=dataclasses.replace(few.effects, joint_spring_damper=twice))
    main, solved = run(wrong, RTOL), solution_of(few)
    verdict = verdict_on(main, run(wrong, 0.1 * RTOL), solved)
    assert "damping of all joints is twice the right value" in str(diagnosis_of_verdict(verdict, main, solved))
