"""Set points of joints: terms of the control towards a moving rest angle that an engine may have wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.changed_loads import moved_joints
from barchain.judge.diagnosis.motion.kinetics import at_joint
from barchain.judge.diagnosis.motion.words import LOADS
from reference_impl.effects.joint_torque import JointTorqueEffect

if TYPE_CHECKING:
    from barchain.judge.diagnosis.motion.candidate import Candidates

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
        target[:, j] = np.interp(s.t_s, point.times_s, point.angle_rad)
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
