"""Terms of inertia that an engine may have wrong: velocities, the coupling of the bars, armature."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.balance import BARS
from barchain.judge.diagnosis.motion.words import BODIES
from barchain.judge.equations import Shape

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.balance import Balance
    from barchain.judge.diagnosis.motion.candidate import Candidates


def kinetic_terms(found: Candidates) -> None:
    """All terms of inertia of several bars."""
    velocity_terms(found)
    if not found.balance.torques_unknown:  # another mass matrix takes all torques
        couplings(found)
    armature(found)


def at_joint(values: Array, joint: int) -> Array:
    """Values (k, N - 1) of one joint alone, from 0."""
    one: Array = values * (np.arange(values.shape[1]) == joint)
    return one


def velocity_terms(found: Candidates) -> None:
    """Terms of the rates squared, which couple the bars."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    found.times("centrifugal", "the centrifugal torque of the bars' rates squared is", BODIES,
                lambda: b.block(BARS, b.rule.integral(b.shape.centrifugal(s))))  # fmt: skip
    found.times("kinetic-slope", "the slope of the kinetic energy with the angles is", BODIES,
                lambda: b.block(BARS, b.rule.integral(b.shape.kinetic_slope(s))))  # fmt: skip
    from_root = np.tril(np.tile(b.shape.left + b.shape.right, (s.bars, 1)), -1) + np.diag(b.shape.left)
    pull = b.shape.mass * ((s.unit * s.rate**2) @ from_root.T)
    relative = (("before", np.diff(s.rate, axis=1, prepend=0.0)), ("after", -np.diff(s.rate, axis=1, append=0.0)))
    for neighbour, rate in relative:
        change = b.shape.centrifugal(dataclasses.replace(s, rate=rate)) - b.shape.centrifugal(s)
        words = f"the centrifugal torque takes rates relative to the bar {neighbour}, not inertial ones"
        found.fixed(
            f"centrifugal-of-rates-to-{neighbour}", words, BODIES, partial(b.block, BARS, b.rule.integral(change))
        )
    far = np.abs(np.subtract.outer(range(s.bars), range(s.bars))) > 1
    lost = np.where(far, b.shape.turned(s), 0.0) @ (s.rate**2)[:, :, None]
    found.fixed("centrifugal-of-neighbours", "the centrifugal torques couple neighbouring bars alone", BODIES,
                partial(b.block, BARS, b.rule.integral(lost[:, :, 0])))  # fmt: skip
    words = "the velocity-dependent terms (centrifugal and Coriolis', of all bars from the first bar's end on) are"
    found.times("velocity-terms", words, BODIES, e.force(pull))


def couplings(found: Candidates) -> None:
    """Mass matrices with other angles, and places from another point than the centre of mass."""
    b = found.balance
    s, shape, loads = b.equations.states, b.shape, b.equations.total.plus(b.own_torques)
    given = shape.generalised(s, loads) + shape.centrifugal(s)
    whole, one = shape.coupled(s) + np.diag(shape.inertia), np.eye(s.bars)
    angle, other = s.angle[:, :, None], s.angle[:, None, :]
    for name, words, ratio in (
        ("of-sum", "has the cosine of the sum of two bars' angles, not of their difference", np.cos(angle + other)),
        ("of-sine", "has the sine of the difference of two bars' angles, not its cosine", np.sin(angle - other)),
        ("straight", "lacks the cosine of the difference of two bars' angles", np.ones_like(whole)),
        ("opposite", "has the opposite sign off its diagonal", -np.cos(angle - other)),
        ("diagonal", "has its diagonal alone", np.zeros_like(whole)),
        (
            "of-neighbours",
            "couples neighbouring bars alone",
            np.cos(angle - other) * (np.abs(np.subtract.outer(range(s.bars), range(s.bars))) < 2),
        ),
    ):
        matrix = np.where(one > 0.0, whole, shape.coupling * ratio)
        found.fixed(f"mass-matrix-{name}", f"the mass matrix {words}", BODIES, partial(turned, b, whole, matrix, given))
    length = shape.left + shape.right
    for name, words, weight in (
        ("lengths", "by their lengths, not their masses", length),
        ("nothing", "alike, not by their masses", np.ones_like(length)),
        ("reversed-masses", "by the masses in reversed order", shape.mass[::-1]),
        *(
            (f"masses-but-{k + 1}", f"without bar {k + 1}", shape.mass * (np.arange(s.bars) != k))
            for k in range(s.bars)
        ),
    ):
        wrong = Shape(shape.mass, shape.inertia, shape.left, shape.right, weight)
        matrix = wrong.coupled(s) + np.diag(shape.inertia)
        seen = wrong.generalised(s, loads) + wrong.centrifugal(s)
        found.fixed(f"centre-by-{name}", f"the centre of mass, from which the bars' places count, weighs them {words}",
                    BODIES, partial(turned, b, whole, matrix, seen, given))  # fmt: skip


def turned(b: Balance, whole: Array, matrix: Array, torque: Array, given: Array | None = None) -> Array:
    """Rows of bars that turn by another mass matrix and other torques than the right ones.

    Parameters
    ----------
    b : Balance
    whole, matrix : ndarray, shape (k, N, N)
        Right mass matrix, and the one in its place, kg m².
    torque, given : ndarray, shape (k, N)
        Torques with the other matrix, and the right ones, N m; the same by default.
    """
    rate_change = np.linalg.solve(matrix, torque[..., None])
    more: Array = (whole @ rate_change)[..., 0] - (torque if given is None else given)
    return b.block(BARS, b.rule.integral(more))


def armature(found: Candidates) -> None:
    """Moments of inertia that turn with the joints, and with the root."""
    b, own = found.balance, found.balance.motion.states
    gained = np.diff(own.rate, axis=0)
    turning, root = np.diff(gained, axis=1), gained * (np.arange(own.bars) == 0)

    def added(name: str, words: str, turning: Array, more: Array | float = 0.0) -> None:
        momenta = np.pad(turning, ((0, 0), (1, 0))) - np.pad(turning, ((0, 0), (0, 1))) + more
        said = f"the {words} an armature of {{}} that no scene has"
        found.added(name, said, "kg m^2", BODIES, partial(b.block, BARS, -momenta))

    added("armature", "joints have", turning)
    added("armature-with-root", "joints and the root have", turning, root)
    for j in range(own.bars - 1) if own.bars > 2 else ():
        added(f"armature-{j + 1}", f"joint {j + 1} has", at_joint(turning, j))
