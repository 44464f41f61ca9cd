"""Set points of joints: which motors move them, and terms of the control that an engine may have wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from barchain.judge.diagnosis.motion.kinetics import at_joint
from barchain.judge.diagnosis.motion.words import LOADS
from reference_impl.effects.joint_torque import JointTorqueEffect
from scenarios.toml.changing import clock_at_start

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.candidate import Candidates
    from scenarios import Scene

MOTOR, SET_POINT, BOTH = "motor", "moving set point", "motors and moving set points"
"""Nouns of what has a torque in a joint"""
TERMS = {
    "spring": "the spring towards {} is",
    "damper": "the damper on the rate relative to {} is",
    "rate": "the rate of {}, in the damper, is",
    "angle": "{}, with its rate, is",
}
"""Terms of one control, each a sentence up to its factor"""
OF_ALL = {
    "spring": "the springs of all joints, towards set points too, are",
    "damper": "the dampers of all joints, on rates relative to set points too, are",
}
"""Terms of all joints together"""


class SetPoint(NamedTuple):
    """Set point of a joint's spring and damper."""

    times_s: Array
    """Instants of the run, s"""
    angle_rad: Array
    motor: int | None
    """Place of the torque that moves the rest angle among the scene's motors; None where it does not move"""

    def at(self, t_s: Array) -> Array:
        """Angles at some instants, rad."""
        return np.interp(t_s, self.times_s, self.angle_rad)


def moved_joints(scene: Scene) -> dict[int, SetPoint]:
    """Set points in the scene's file by joint, from 1. Their motors come before those of the file."""
    given = (scene.given or {}).get("effects", {}).get("joint_spring_damper") or {}
    springs, points = scene.effects.joint_spring_damper, given.get("set_point", ())
    found, motors = dict[int, SetPoint](), 0
    if springs is None or not points:
        return found
    start_s, end_s = clock_at_start(scene), scene.run.duration_s
    for each in points:
        joint, times_s = each["joint"], np.array(each["times_s"], float) - start_s
        point = SetPoint(times_s, np.radians(each["angle_deg"]), motors)
        has_gain = springs.stiffness_N_m_rad[joint - 1] or springs.damping_N_m_s_rad[joint - 1]
        moves = bool(has_gain) and float(np.ptp(point.at(np.clip([0.0, *times_s, end_s], 0.0, end_s)))) > 0.0
        found[joint] = point if moves else point._replace(motor=None)
        motors += moves
    return found


def motor_nouns(scene: Scene) -> list[str]:
    """Noun of each of a scene's motors: some move set points."""
    moving = {point.motor for point in moved_joints(scene).values()}
    return [SET_POINT if k in moving else MOTOR for k in range(len(scene.effects.joint_torque))]


def motor_words(scene: Scene) -> list[str]:
    """Nouns of a scene's motors with their joints, which a file numbers."""
    pairs = zip(motor_nouns(scene), scene.effects.joint_torque, strict=True)
    return [f"{noun} in joint {motor.joint}" for noun, motor in pairs]


def motors_words(scene: Scene) -> str:
    """Noun for all motors of a scene."""
    nouns = {*motor_nouns(scene)}
    return BOTH if len(nouns) > 1 else f"{SET_POINT}s" if SET_POINT in nouns else "joints' motors"


def set_point_terms(found: Candidates) -> None:
    """Springs and dampers of each control, the rate in its damper, and its angles.

    The torque of a control is k (s - b) + c (s' - b'), with the joint's angle b and the set point s. The scene has it
    as a spring and damper about s at t = 0, s0, and a motor of k (s - s0) + c s'.
    """
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    moved, springs = moved_joints(b.scene), b.scene.effects.joint_spring_damper
    if springs is None or not moved:
        return
    k, c, rest = (np.array(v) for v in (springs.stiffness_N_m_rad, springs.damping_N_m_s_rad, springs.rest_rad))
    motors = [
        load.torque for effect, load in zip(e.model.effects, e.effects, strict=True)
        if isinstance(effect, JointTorqueEffect)
    ]  # fmt: skip
    bent, turning = np.diff(s.angle, axis=1), np.diff(s.rate, axis=1)
    target, by_rate = np.tile(rest, (len(bent), 1)), np.zeros_like(bent)
    for joint, point in moved.items():
        j = joint - 1
        target[:, j] = point.at(s.t_s)
        if point.motor is not None:
            by_rate[:, j] = motors[point.motor][:, joint] - k[j] * (target[:, j] - rest[j])
    spring, damper = k * (bent - target), c * turning - by_rate
    torque = {"spring": spring, "damper": damper, "rate": -by_rate, "angle": -k * target - by_rate}
    for name, words in TERMS.items():
        for joint in moved:
            whose = words.format(f"the set point of joint {joint}")
            found.times(f"set-point-{joint}-{name}", whose, LOADS, e.on_joints(at_joint(torque[name], joint - 1)))
    for name, words in OF_ALL.items():
        found.times(f"joints-{name}", words, LOADS, e.on_joints(torque[name]))
