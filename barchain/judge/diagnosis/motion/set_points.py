"""Set points of joints: their angles, and which of a scene's motors move them, with words for these."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from scenarios.toml.changing import clock_at_start

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from scenarios import Scene

MOTOR, SET_POINT, BOTH = "motor", "moving set point", "motors and moving set points"
"""Nouns of what has a torque in a joint"""


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
