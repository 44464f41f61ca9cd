"""Enclosure of a scene's motion: from break to break of its effects, step by step, with balls at its samples."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING

from flint import arb, arb_mat, ctx

from barchain.solutions.enclosure.equations import Equations, State
from barchain.solutions.enclosure.forces import number
from barchain.solutions.enclosure.series import Balls
from barchain.solutions.enclosure.step import FaceTurnedError, Spread, Stepper, column
from scenarios.effect_types import LAW_FORMS, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from scenarios import Scene

LEAST_ORDER, ORDER_PER_BIT = 30, 0.35
"""Orders that cost least: measured"""

ENCLOSED = frozenset({
    *(f"gravity.{model}" for model in Gravity), *(f"prescribed_rotation.{form}" for form in LAW_FORMS), "thrust.body",
    "thrust.inertial", "impulse", "oblateness", "third_body", "drag", "solar_pressure", "joint_spring_damper",
    "joint_torque",
})  # fmt: skip
"""Effects of `Effects.names` that forces and equations have; edges of a shadow are events"""


class NotEnclosedError(ValueError):
    """A motion that this method does not enclose; the message gives the reason."""


@dataclass(frozen=True)
class Enclosed:
    """Balls of all unknowns and of what follows from them, at one instant; N bars, P prescribed rotations."""

    t_s: float
    state: list[arb]
    """(4 + 2 N,) centre of mass and its velocity, angles, rates"""
    reaction: list[arb]
    """(2 (N - 1),)"""
    torque: list[arb]
    """(P,)"""
    impulse: list[arb]
    """(2 (N - 1),) sums of the impulsive reactions so far"""


@dataclass
class Effort:
    """What an enclosure took."""

    bits: int
    order: int
    steps: int = 0


def why_not(scene: Scene) -> str:
    """Reason why a scene is not enclosed; empty if it may be."""
    others = sorted(scene.effects.names - ENCLOSED)
    return f"there are no enclosures of {', '.join(others)}" if others else ""


def order_for(bits: int) -> int:
    """Order of the series for a precision."""
    return max(LEAST_ORDER, round(ORDER_PER_BIT * bits))


def enclose(
    scene: Scene, times_s: Sequence[float], start: Sequence[arb], effort: Effort, *, start_s: float = 0.0,
    gradient_sign: int = 1, told: Callable[[float, arb], None] | None = None,
) -> Iterator[Enclosed]:  # fmt: skip
    """Balls that contain the exact motion from a start, at each of some instants.

    A sample at a break of the effects shows the motion before it.

    Parameters
    ----------
    scene : Scene
        Its numbers are taken as exact.
    times_s : sequence of float
        Increasing instants, from `start_s` on.
    start : sequence of arb
        (4 + 2 N,) state at `start_s`: centre of mass and velocity, angles, rates.
    effort : Effort
        Precision and order; its steps are counted.
    start_s : float
        Instant of the start, s.
    gradient_sign : int
        -1 for a wrong sign of gravity's torque, to be detected.
    told : callable
        Told the end of each step and the largest radius of an angle there.

    Raises
    ------
    NotEnclosedError
        If the scene, or its motion, is none that this method encloses.
    TooWideError
        If it takes more bits.
    """
    reason = why_not(scene)
    if reason:
        raise NotEnclosedError(f"{scene.name}: {reason}")
    ctx.prec = effort.bits
    marks = [start_s, *(t for t in scene.effects.breaks_s if start_s < t < times_s[-1]), float(times_s[-1])]
    state, joints = list(start), scene.bars - 1
    impulse = [arb(0)] * (2 * joints)
    left = [float(t) for t in times_s]
    while left and left[0] == start_s:  # no step's remainder is in it: of a chain at rest nothing is off
        equations = Equations(scene, 0.5 * (marks[0] + marks[1]), gradient_sign=gradient_sign)
        set_faces(scene, equations, start_s, state)
        yield seen(equations, left.pop(0), state, impulse)
    for begin, end in itertools.pairwise(marks):
        ctx.prec = effort.bits
        equations = Equations(scene, 0.5 * (begin + end), gradient_sign=gradient_sign)
        pushes = [push for push in scene.effects.impulse if push.at_s == begin]
        if pushes:
            jumps = equations.jump(Balls(), State.of(number(begin), state), pushes)
            moves = [0, 0, *jumps.fall, *([0] * scene.bars), *jumps.turn]
            state = [x + move for x, move in zip(state, moves, strict=True)]
            impulse = [a + b for a, b in zip(impulse, itertools.chain(*jumps.reaction), strict=True)]
        set_faces(scene, equations, begin, state)
        stepper = Stepper(equations, (scene.size_m, scene.fastest_rate_rad_s), effort.bits, effort.order)
        now, centre = begin, [x.mid() for x in state]
        box = arb_mat([[arb(int(i == j)) for j in range(len(state))] for i in range(len(state))])
        spread = Spread(box, column([x.rad() / w for x, w in zip(state, stepper.scale, strict=True)]))
        while now < end:
            try:
                path = stepper.step(now, end, centre, spread)
            except FaceTurnedError as error:
                raise NotEnclosedError(f"{scene.name}: {error}, near {now:.6g} s") from None
            while left and left[0] <= path.end_s:
                t_s = left.pop(0)
                yield seen(equations, t_s, path.at(t_s), impulse)
            now, state, (centre, spread) = path.end_s, path.at(path.end_s), path.end()
            effort.steps += 1
            if told is not None:
                told(now, max((x.rad() for x in state[4 : 4 + scene.bars]), key=float))


def seen(equations: Equations, t_s: float, state: list[arb], impulse: list[arb]) -> Enclosed:
    """A state with what follows from it."""
    motion = equations.motion(Balls(), State.of(number(t_s), state), reactions=True)
    return Enclosed(t_s, state, list(itertools.chain(*motion.reaction)), list(motion.torque), list(impulse))


def set_faces(scene: Scene, equations: Equations, begin_s: float, state: list[arb]) -> None:
    """Faces of the bars that meet the air or the Sun at the start of a piece.

    Raises
    ------
    NotEnclosedError
        If one is edge-on.
    """
    equations.motion(Balls(), State.of(number(begin_s), state))
    if any(x.contains(0) for x in equations.forces.watched):
        raise NotEnclosedError(f"{scene.name}: a bar is edge-on to the air or the Sun at {begin_s:.6g} s")
    equations.forces.faces = [1 if x > 0 else -1 for x in equations.forces.watched]
