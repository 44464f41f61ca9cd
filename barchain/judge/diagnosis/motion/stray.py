"""Terms that no scene has: damping, friction, stiffness, constant torques, armature."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.candidate import BODIES, LOADS

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.balance import Balance
    from barchain.judge.diagnosis.motion.candidate import Candidates


def stray(found: Candidates) -> None:
    """Add all terms that no scene has."""
    damping(found)
    on_bars(found)
    if found.balance.scene.bars > 1:
        in_joints(found)
        armature(found)


def damping(found: Candidates) -> None:
    """Damping of all velocities and rates, as engines for games add it."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    turning, drift = e.torque(-b.shape.inertia * s.rate), e.force(-b.shape.mass * e.drift)
    share = "damped by a share of {} in a second"
    for name, words, load in (
        ("angular-damping", f"the bars' rates are {share}", turning),
        ("linear-damping", f"the bars' velocities relative to the centre of mass are {share}", drift),
        ("body-damping", f"the bars' rates and velocities are {share}", turning.plus(drift)),
        ("track-damping", f"the velocity of the centre of mass is {share}", e.zero._replace(common=-s.velocity)),
    ):
        found.added(name, words, "", LOADS, load)
    found.added(
        "rate-damping", "the bars' inertial rates have a damping of {} each", "N m s/rad", LOADS, e.torque(-s.rate)
    )


def on_bars(found: Candidates) -> None:
    """Torques on single bars: damping against inertial axes, a constant, more inertia."""
    b, e, s, own = found.balance, found.balance.equations, found.balance.equations.states, found.balance.motion.states
    for bar in range(s.bars):
        one = np.zeros(s.bars)
        one[bar] = 1.0
        where = "root joint, of bar 1" if bar == 0 else f"bar {bar + 1}"
        found.added(f"damping-of-bar-{bar + 1}", f"the {where} against inertial axes, has a damping of {{}}",
                    "N m s/rad", LOADS, e.torque(-one * s.rate))  # fmt: skip
        found.added(f"torque-on-bar-{bar + 1}", f"the bar {bar + 1} has a constant torque of {{}}", "N m", LOADS,
                    e.torque(one + 0.0 * s.rate))  # fmt: skip
        if s.bars > 1:
            found.added(f"inertia-of-bar-{bar + 1}", f"the bar {bar + 1} has an additional moment of inertia of {{}}",
                        "kg m^2", BODIES, partial(lost, b, one * own.rate))  # fmt: skip


def in_joints(found: Candidates) -> None:
    """Torques in all joints, or in one."""
    e, s = found.balance.equations, found.balance.equations.states
    bent, turning = np.diff(s.angle, axis=1), np.diff(s.rate, axis=1)
    more = "more" if found.balance.scene.effects.joint_spring_damper else "that the scene lacks"
    for name, what, unit, values in (
        ("friction", "a friction (damping)", "N m s/rad", turning),
        ("stiffness", "a stiffness", "N m/rad", bent),
        ("dry-friction", "a dry friction", "N m", np.sign(turning)),
        ("bias", "a constant torque", "N m", np.ones_like(turning)),
    ):
        each = [e.on_joint(j, values[:, j]) for j in range(s.bars - 1)]
        whole = each[0]
        for load in each[1:]:
            whole = whole.plus(load)
        found.added(f"joint-{name}", f"the joints have {what} of {{}} {more}", unit, LOADS, whole)
        for j, load in enumerate(each) if len(each) > 1 else ():
            found.added(f"joint-{j + 1}-{name}", f"the joint {j + 1} has {what} of {{}} {more}", unit, LOADS, load)


def armature(found: Candidates) -> None:
    """Moments of inertia that turn with the joints, and with the root."""
    b, own = found.balance, found.balance.motion.states
    each = [along_joint(own.rate, j) for j in range(own.bars - 1)]
    every: Array = np.sum(each, axis=0)
    root = np.zeros_like(own.rate)
    root[:, 0] = own.rate[:, 0]
    for name, words, momenta in (
        ("armature", "the joints have an armature of {} that no scene has", every),
        ("armature-with-root", "the joints and the root have an armature of {} that no scene has", every + root),
        *((f"armature-{j + 1}", f"the joint {j + 1} has an armature of {{}} that no scene has", one)
          for j, one in enumerate(each) if len(each) > 1),
    ):  # fmt: skip
        found.added(name, words, "kg m^2", BODIES, partial(lost, b, momenta))


def lost(b: Balance, momenta: Array) -> Array:
    """Rows of momenta (n, N) that the right equations lack."""
    return -b.gained(momenta)


def along_joint(rate: Array, joint: int) -> Array:
    """Momenta (n, N) of a unit of inertia that turns with a joint."""
    found = np.zeros_like(rate)
    between = rate[:, joint + 1] - rate[:, joint]
    found[:, joint], found[:, joint + 1] = -between, between
    return found
