"""Terms of single effects that an engine may have wrong: springs, thrusts, drag, light, forces on second moments."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.kinetics import at_joint
from barchain.judge.diagnosis.motion.set_points import moved_joints
from barchain.judge.diagnosis.motion.words import GRAVITY, LOADS, named
from barchain.judge.equations import StateRows
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_torque import JointTorqueEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.model.complex_vectors import squared_norm
from scenarios import Axes

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.candidate import Candidates
    from barchain.judge.equations import Load

SIDES = (("before", 1.0, 0.0), ("after", 0.0, 1.0))
"""Bars beside a joint, and the shares of a joint's torque on both"""
CONTROL = {
    "spring": "the spring towards {} is",
    "damper": "the damper on the rate relative to {} is",
    "rate": "the rate of {}, in the damper, is",
    "angle": "{}, with its rate, is",
}
"""Terms of one control, each a sentence up to its factor"""
CONTROLS = {
    "spring": "the springs of all joints, towards set points too, are",
    "damper": "the dampers of all joints, on rates relative to set points too, are",
}
"""Terms of all joints together"""


def effect_terms(found: Candidates) -> None:
    """All terms of the effects of a scene."""
    e, scene = found.balance.equations, found.balance.scene
    thrusts = [load for effect, load in zip(e.model.effects, e.effects, strict=True) if effect.name == "thrust"]
    if scene.effects.joint_spring_damper is not None:
        springs_and_dampers(found, thrusts)
        set_point_terms(found)
    if scene.bars > 1:
        thrust_axes(found, thrusts)
    for effect, load in zip(e.model.effects, e.effects, strict=True):
        if isinstance(effect, DragEffect):
            drag_terms(found, effect, load)
        elif isinstance(effect, SolarPressureEffect):
            light_terms(found, effect)
        elif isinstance(effect, QuadrupoleEffect):
            second_moment_terms(found)


def springs_and_dampers(found: Candidates, thrusts: list[Load]) -> None:
    """Springs and dampers of all joints and of one, their rest angles, their sides, and other laws."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    given = b.scene.effects.joint_spring_damper
    assert given is not None
    k, c, rest = (np.array(v) for v in (given.stiffness_N_m_rad, given.damping_N_m_s_rad, given.rest_rad))
    bent, turning = np.diff(s.angle, axis=1), np.diff(s.rate, axis=1)
    spring, damper = k * (bent - rest), c * turning
    for one, torque in (("spring", spring), ("damper", damper), ("rest angle", -k * rest + 0.0 * bent)):
        name = named(one)
        found.times(f"{name}s", f"the joints' {one}s are", LOADS, e.on_joints(torque))
        for where, *shares in SIDES:
            words = f"the torque of the {one}s on the bar {where} the joint is"
            found.times(f"{name}s-{where}", words, LOADS, e.on_joints(torque, *shares))
        for j in range(s.bars - 1) if s.bars > 2 else ():
            found.times(f"{name}-{j + 1}", f"the {one} of joint {j + 1} is", LOADS, e.on_joints(at_joint(torque, j)))
            for bar, (_, *shares) in zip((j, j + 1), SIDES, strict=True):
                words = f"the torque of the {one} of joint {j + 1} on bar {bar + 1} is"
                load = e.on_joints(at_joint(torque, j), *shares)
                found.times(f"{name}-{j + 1}-on-bar-{bar + 1}", words, LOADS, load)
    neighbours = (("after", s.rate[:, 1:]), ("before", -s.rate[:, :-1]))
    for (where, *shares), (other, alone) in zip(SIDES, neighbours, strict=True):
        words = f"the springs and dampers have no torque on the bar {where} the joint"
        found.fixed(f"springs-without-bar-{where}", words, LOADS, e.on_joints(-spring - damper, *shares))
        words = f"the dampers take the inertial rate of the bar {other} the joint alone, not the difference of both"
        found.fixed(f"dampers-of-bar-{other}", f"{words} rates", LOADS, e.on_joints(c * alone - damper))
    inertial = e.torque(-(np.pad(c, (0, 1)) + np.pad(c, (1, 0))) * s.rate).plus(e.on_joints(-damper))
    found.fixed("dampers-by-inertial-rates", "the dampers act on the bars' inertial rates, not on their differences",
                LOADS, inertial)  # fmt: skip
    pushed = np.any([np.zeros(len(s.t_s), bool), *(load.force.any(axis=1) for load in thrusts)], axis=0)
    found.fixed("springs-off-in-thrusts", "the springs and dampers are off while a thrust is on", LOADS,
                e.on_joints(-(spring + damper) * pushed[:, None]))  # fmt: skip
    for name, angle, words in (("", bent, ""), ("-from-rest", bent - rest, "from their rest ")):
        lost_turns = -k * 2.0 * math.pi * np.round(angle / (2.0 * math.pi))
        found.fixed(f"springs-wrapped{name}", f"the springs' angles {words}are wrapped to half a turn either way",
                    LOADS, e.on_joints(lost_turns))  # fmt: skip


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
    for name, words in CONTROL.items():
        for joint in moved:
            whose = words.format(f"the set point of joint {joint}")
            found.times(f"set-point-{joint}-{name}", whose, LOADS, e.on_joints(at_joint(torque[name], joint - 1)))
    for name, words in CONTROLS.items():
        found.times(f"joints-{name}", words, LOADS, e.on_joints(torque[name]))


def drag_terms(found: Candidates, effect: DragEffect, load: Load) -> None:
    """Parts of the drag by the bars' turning and by the fall of the density along them, and other velocities.

    Of the rate relative to the air, the torque by turning is odd, and the force by the fall of the density.
    """
    e = found.balance.equations
    mirrored = e.load_of(effect.accelerations(StateRows(e, 2.0 * effect.rotation_rad_s - e.states.rate), None))
    odd, even = load.plus(mirrored.times(-1.0)).times(0.5), load.plus(mirrored).times(0.5)
    words = "the torque of the drag by the bars' own turning is"
    found.times("drag-torque-by-turning", words, LOADS, e.torque(odd.torque))
    words = "the fall of the air's density along the bars, in the drag, is"
    found.times("drag-fall-along-bars", words, LOADS, odd._replace(torque=even.torque))
    still = StateRows(e)
    still.velocity = still.velocity - e.drift
    words = "the drag takes the velocity of the centre of mass for all bars"
    found.fixed("drag-of-centre", words, LOADS, e.load_of(effect.accelerations(still, None)).plus(load.times(-1.0)))
    wind, r = effect.wind(e.rows), np.sqrt(squared_norm(e.rows.position_from_body))
    face = np.sign(wind.across) * effect.normal_coefficient
    strength: Array = -0.5 * effect.width_m * effect.density(e.rows, r) * face
    more = strength * e.model.length_m * (np.abs(wind.across) * np.hypot(wind.along, wind.across) - wind.across**2)
    words = (
        "the normal force of the drag goes with the normal part of the velocity times the speed, not with its square"
    )
    found.fixed("drag-normal-of-speed", words, LOADS, e.force(more * 1j * e.states.unit))


def light_terms(found: Candidates, effect: SolarPressureEffect) -> None:
    """Reflected light that pushes one side whichever faces the Sun."""
    e = found.balance.equations
    mirror = dataclasses.replace(effect, reflectivity=1.0)
    reflected = e.of_effect(mirror).times(effect.reflectivity)
    away = np.where(effect.mode(e.rows)[..., 1:] < 0.0, -2.0, 0.0)
    words = "the reflected sunlight pushes the same way whichever side of the bar faces the Sun"
    found.fixed("sunlight-one-sided", words, LOADS, e.force(away * reflected.force))


def second_moment_terms(found: Candidates) -> None:
    """Terms of the force of the central field on the bars' second moments."""
    e, shape = found.balance.equations, found.balance.shape
    z, u = e.states.com[:, None] + e.place, e.states.unit
    r, up = abs(z), (u.conj() * z).real
    strength = 1.5 * e.model.mu_m3_s2 * shape.inertia / r**5
    for name, term, vector in (
        ("axis", "2 (u.Z) u", 2.0 * up * u),
        ("place", "Z", z),
        ("angle", "-5 (u.Z)^2 Z/r^2", -5.0 * (up / r) ** 2 * z),
    ):
        words = f"the term {term} of the force of the central field on the bars' second moments is"
        found.times(f"second-moment-{name}", words, GRAVITY, e.force(strength * vector))


def thrust_axes(found: Candidates, thrusts: list[Load]) -> None:
    """Thrusts in the axes of another bar."""
    b, e = found.balance, found.balance.equations
    unit, n = e.states.unit, e.states.bars
    for name, whose, other in (
        ("first", "the first bar", [0] * n),
        ("next", "the next bar", [(k + 1) % n for k in range(n)]),
        ("previous", "the bar before", [(k - 1) % n for k in range(n)]),
    ):
        change = e.zero
        for push, load in zip(b.scene.effects.thrust, thrusts, strict=True):
            bar = push.bar - 1
            if push.axes is not Axes.BODY:
                continue
            turned = (load.force * (unit[:, other[bar]] / unit[:, bar])[:, None] - load.force) + 0j
            arm = b.shape.right[bar] if push.end.sign > 0.0 else -b.shape.left[bar]
            change = change.plus(e.force(turned).plus(e.torque(arm * (unit.conj() * turned).imag)))
        words = f"the thrusts count their directions in the axes of {whose}"
        found.fixed(f"thrusts-in-axes-of-{name}-bar", words, LOADS, change)
