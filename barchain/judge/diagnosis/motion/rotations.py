"""Other prescribed rotations than the right ones: motors of other neighbours, other horizontals, bars not held."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import make_interp_spline

from barchain.judge.diagnosis.motion.balance import BARS, JOINTS, LAWS, Balance, real
from barchain.judge.diagnosis.motion.words import LOADS
from scenarios import Actuator, Frame

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.candidate import Candidates


def of_motors(found: Candidates) -> None:
    """Motors that act on another neighbour; laws that count from another horizontal."""
    b, own = found.balance, found.balance.motion
    e, laws, n = b.equations, b.scene.effects.prescribed_rotation, b.scene.bars
    if own.torque is not None and n > 2:
        change = np.zeros_like(b.motors)
        for column, law in enumerate(laws):
            bar = law.bar - 1
            if law.actuator is Actuator.JOINT and 0 < bar < n - 1:
                change[bar - 1, column], change[bar + 1, column] = 1.0, -1.0
        if change.any() and own.torque.shape[1] == change.shape[1]:
            words = "the motors of the joints act on the next bar, not on the bar before"
            found.fixed("motors-on-next-bar", words, LOADS, e.torque(own.torque[b.rule.rows] @ change.T))
    if any(law.frame is Frame.LOCAL_HORIZONTAL for law in laws):
        words = "the local horizontal of the prescribed rotations is that of the chain's centre of mass"
        found.fixed("laws-of-centre", words, LOADS, partial(of_centre, b))
        for part, which in HORIZONTAL:
            words = f"the {which} of the local horizontal is missing in the prescribed rotations"
            found.fixed(f"laws-without-{part}", words, LOADS, partial(without_acceleration, b, part))
    if laws and b.scene.effects.impulse and all(law.frame.of_bar for law in laws):
        words = "the bars of the prescribed rotations are free in an impulse, in which their motors have to hold them"
        found.fixed("laws-free-in-impulses", words, LOADS, partial(of_unheld, b))


def of_centre(b: Balance) -> Array:
    """Rows (n - 1, c) of laws from the horizontal of the centre of mass; NaN in the first, where bars jump to it."""
    s, laws = b.motion.states, b.scene.effects.prescribed_rotation
    apart = np.unwrap(np.angle(s.com))[:, None] - np.unwrap(np.angle(s.com[:, None] + b.shape.centres(s.unit)), axis=0)
    rows = [np.diff(apart[:, law.bar - 1]) * (law.frame is Frame.LOCAL_HORIZONTAL) for law in laws]
    found = b.block(LAWS, np.stack(rows, axis=1))
    found[0] = np.nan
    return found


HORIZONTAL = (
    ("acceleration", "acceleration"),
    ("transverse", "part of the acceleration by the bar's transverse acceleration, Z x A/Z^2,"),
    ("own", "part of the acceleration by the bar's motion about the chain's centre of mass"),
    ("centre", "part of the acceleration by that of the chain's centre of mass"),
    ("radial", "part of the acceleration by the radial velocity, -2 (Z.V)(Z x V)/Z^4,"),
)
"""Angular acceleration of the horizontal at a place Z with the velocity V and the acceleration A, and its parts"""


def horizontal(b: Balance) -> dict[str, Array]:
    """Angular acceleration of each bar's horizontal at the samples and its parts, (n, N) rad/s²."""
    s, shape = b.motion.states, b.shape
    place = s.com[:, None] + shape.centres(s.unit)
    velocity = s.velocity[:, None] + shape.centres(1j * s.unit * s.rate)
    turning = (place.conj() * velocity).imag / abs(place) ** 2
    whole = slope(s.t_s, turning)
    fall = slope(s.t_s, s.velocity.real) + 1j * slope(s.t_s, s.velocity.imag)
    centre = (place.conj() * fall[:, None]).imag / abs(place) ** 2
    radial = -2.0 * (place.conj() * velocity).real / abs(place) ** 2 * turning
    transverse = whole - radial
    return {"acceleration": whole, "transverse": transverse, "own": transverse - centre, "centre": centre,
            "radial": radial}  # fmt: skip


def slope(t_s: Array, values: Array) -> Array:
    """Derivative of values at samples, (n, ...)."""
    found: Array = make_interp_spline(t_s, values, 5).derivative()(t_s)
    return found


def without_acceleration(b: Balance, part: str) -> Array:
    """Rows (n - 1, c) of bars on their laws, with torques that lack a part of the horizontal's acceleration."""
    s, shape = b.motion.states, b.shape
    held = [law.bar - 1 for law in b.scene.effects.prescribed_rotation if law.frame is Frame.LOCAL_HORIZONTAL]
    lacking = np.isin(np.arange(s.bars), held) * horizontal(b)[part]
    lacking, e = lacking[b.rule.rows], b.equations.states
    matrix = shape.coupled(e) + np.diag(shape.inertia)
    found = b.block(BARS, b.rule.integral((matrix @ lacking[..., None])[..., 0]))
    if JOINTS in b.columns:
        moved = np.cumsum(shape.mass * shape.centres(1j * e.unit * lacking), axis=1)[:, :-1]
        found += b.block(JOINTS, b.rule.integral(real(moved)))
    return found


def of_unheld(b: Balance) -> Array:
    """Rows (n - 1, c) of bars that follow their laws, beside others that an impulse moves as if no motor held these."""
    shape, n = b.shape, b.motion.states.bars
    found = np.zeros((len(b.motion.states.t_s) - 1, b.width))
    held = np.isin(np.arange(n), [law.bar - 1 for law in b.scene.effects.prescribed_rotation])
    for k, push in b.impulses:
        lacking = np.zeros(b.width)
        b.subtract_impulse(lacking, push, k)
        s = dataclasses.replace(b.motion.states.at(np.array([k])), angle=b.angles[push.at_s][None])
        matrix = shape.coupled(s)[0] + np.diag(shape.inertia)
        undone = held * np.linalg.solve(matrix, lacking[b.columns[BARS]])
        found[k, b.columns[BARS]] += matrix @ undone
        if JOINTS in b.columns:
            moved = np.cumsum(shape.mass * shape.centres(1j * s.unit * undone), axis=1)[:, :-1]
            found[k, b.columns[JOINTS]] += real(moved)[0]
    return b.without_motors(found)
