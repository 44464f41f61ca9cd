r"""Equations of motion of the chain as heyoka expressions, by recursion from its last bar to its first and back.

The reference solves for the reactions, from the joints' condition on accelerations. Here the only unknown of a bar is
its angular acceleration: a backward pass finds the force at each bar's left end, as in articulated-body algorithms.

*Backward pass, from the last bar to the first.* Let a be the acceleration of a bar's left end and w' its angular
acceleration. Its centre and its right end then accelerate by c = a + (l/2)(w' n - w² u) and
e = a + l (w' n - w² u). The chain beyond reacts to e with a force that is affine in e, F = A e + b (none
beyond the last bar), and its joint motor, if any, with a torque q, also affine. The force P at the bar's left end and
its rotation follow from

    P = m (c - t) + F                                  (Newton)
    J w' = K + tau - q - (l/2) n·(F + P)               (Euler, about its centre)

where t is the tide: its gravity less that at the chain's centre of mass, and other specific forces. A free
bar has tau = 0, and Euler's law gives w' as an affine function of a. The law of a prescribed bar gives w' as such a
function, and Euler's law gives tau. In both cases P is affine in a, and is the F of the previous bar. The matrix A
starts as a point mass's and stays symmetric positive definite without motors: it is the articulated inertia of the
chain at its left end.

With unequal levers a u and b u the centre is a u from the left end, and -n·(b F + a P) takes the place of the last
term. The end e stays l u from the left one.

*Forward pass, from the first bar to the last.* No force acts on the first left end: P = 0 gives its a, and the affine
functions then give w' and the next bar's a, one after the other. Reactions are Newton's law summed from the
far end, R_j = -sum_{k>j} m_k (c_k - t_k).

A motor in joint 1 that prescribes bar 1 acts on bar 2, which the backward pass reaches before bar 1. Its torque is
one more unknown of the affine functions, and is solved together with a of the first left end. The law of a joint's
angle gives w' as that of the bar before plus a number: until the pass reaches that bar, its w' is such an unknown too.

Accelerations are relative to a frame that falls with g(Z0), so that only tides enter. With y = |Z0|/|Z0 + d|
= 1/sqrt(1 + q), q = (2 Z0 + d)·d/|Z0|²,

    t = (mu/|Z0|³) (Z0 (1 - y³) - d y³),   1 - y³ = (1 - y)(1 + y + y²),   1 - y = q y²/(1 + y)

keeps all digits for any length of d, without logarithms (:mod:`adapters.heyoka.fields` has the other fields). The
longitude of a bar accelerates by (Z x (c - t))/r² - 2 (Z·Z')(Z x Z')/r⁴ where gravity is central. A noncentral
acceleration g adds Z x g over r². A law relative to the local horizontal adds this acceleration.

Impulses obey the same equations with impulses for forces, without rates and gravity
(:func:`adapters.heyoka.system.impulse`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenarios import Frame

if TYPE_CHECKING:
    from adapters.heyoka.bars import Pair, Symbol, SymbolicBar
    from adapters.heyoka.structure import Structure

A_X, A_Y, TURN, PREVIOUS, MOTOR, ONE = range(6)
"""Coefficients of affine functions: of a, w', w' of the bar before, the torque of joint 1's motor, 1"""


def affine(**parts: Symbol) -> Any:
    """Affine function as a row of six coefficients."""
    row = np.zeros(6, dtype=object)
    for name, value in parts.items():
        row[{"x": A_X, "y": A_Y, "turn": TURN, "previous": PREVIOUS, "motor": MOTOR, "one": ONE}[name]] = value
    return row


def acceleration(bar: SymbolicBar, place: Pair, times: float = 1.0) -> tuple[Any, Any]:
    """Acceleration of the point `times` the vector `place` from a bar's left end: affine functions of a and w'."""
    (px, py), square = place, bar.rate * bar.rate
    return (
        affine(x=1.0, turn=times * -py, one=-times * (square * px)),
        affine(y=1.0, turn=times * px, one=-times * (square * py)),
    )


def end_acceleration(bar: SymbolicBar) -> tuple[Any, Any]:
    """Acceleration of its right end, affine."""
    return acceleration(bar, bar.reach, 2.0)


def specific_force(bar: SymbolicBar) -> tuple[Any, Any]:
    """Force of a bar's joints on its centre over its mass, c - t, affine."""
    x, y = acceleration(bar, bar.left)
    return x - affine(one=bar.load.push[0]), y - affine(one=bar.load.push[1])


@dataclass(frozen=True)
class ArticulatedBar:
    """A bar and the chain beyond it, as seen from its left end: results of the backward pass."""

    turn: Any
    """w' as an affine function of a, the motor's torque and 1"""
    torque: Any
    """tau as an affine function; None for a free bar"""
    left_force: tuple[Any, Any]
    """P as an affine function"""
    torque_on_left: Any
    """q: torque of its joint motor; the opposite torque acts on the previous bar"""
    symmetric: bool
    """Whether the matrix A is symmetric and P depends on a and 1 only"""


def after(function: Any, point: tuple[Any, Any]) -> Any:
    """Affine function of the next bar's left end, in terms of this bar's: `point` is that end's acceleration."""
    rest = affine(turn=function[PREVIOUS], motor=function[MOTOR], one=function[ONE])
    return point[0] * function[A_X] + point[1] * function[A_Y] + rest


def substituted(function: Any, turn: Any) -> Any:
    """Affine function with w' replaced by its solution."""
    rest = function.copy()
    rest[TURN] = 0.0
    return rest + turn * function[TURN]


def backward_step(
    bar: SymbolicBar, beyond: ArticulatedBar | None, prescribed: Any, *, motor: bool, pushed: bool
) -> ArticulatedBar:
    """Force at a bar's left end and the bar's angular acceleration, as affine functions.

    Parameters
    ----------
    bar : SymbolicBar
    beyond : ArticulatedBar or None
        The next bar; None for the last.
    prescribed : array or None
        Angular acceleration of its law, affine in a; None for a free bar.
    motor : bool
        Whether a motor in the joint to the previous bar drives it.
    pushed : bool
        Whether the opposite of the torque of joint 1's motor acts on it.
    """
    end, (nx, ny) = end_acceleration(bar), (-bar.left[1], bar.left[0])
    force = tuple(after(f, end) for f in beyond.left_force) if beyond else (affine(), affine())
    pull = specific_force(bar)
    left_force = tuple(f + p * bar.mass for f, p in zip(force, pull, strict=True))
    lever = (force[0] + left_force[0]) * nx + (force[1] + left_force[1]) * ny
    if bar.excess:
        lever = lever + force[0] * bar.excess[0] + force[1] * bar.excess[1]
    others = lever - affine(one=bar.load.torque) + (affine(motor=1.0) if pushed else affine())
    if beyond is not None:
        others = others + after(beyond.torque_on_left, end)
    lacking = others + affine(turn=bar.inertia)  # J w' - K + q + lever: zero on a free bar, tau on a prescribed one
    if prescribed is None:
        turn = -others / (bar.inertia + others[TURN])
        turn[TURN] = 0.0
        torque = None
    else:
        turn, torque = prescribed, substituted(lacking, prescribed)
    return ArticulatedBar(
        turn,
        torque,
        (substituted(left_force[0], turn), substituted(left_force[1], turn)),
        torque if motor else affine(),
        symmetric=False,
    )


def backward_step_free(bar: SymbolicBar, beyond: ArticulatedBar | None) -> ArticulatedBar:
    """:func:`backward_step` of a free bar where A = S is symmetric, at half the operations.

    With n standing for (l/2) n, v = 2 S n + m n and D = J + m l²/4 + 4 n·S n, Euler's law reads D w' + v·a + e = 0. The
    same v multiplies w' in P = (S + m) a + v w' + c, and so A = S + m - v vᵀ/D. With unequal levers m a over l/2 takes
    the place of m before n, and m a² that of m l²/4.
    """
    (px, py), (nx, ny), (tx, ty), mass, lean = bar.reach, bar.across, bar.load.push, bar.mass, bar.lean
    (xx, xy, yy), (bx, by) = symmetric_part(beyond)
    sn = (2.0 * (xy * px - xx * py), 2.0 * (yy * px - xy * py))
    square = bar.rate * bar.rate
    cx, cy = square * bar.left[0], square * bar.left[1]
    far = (bx - square * (2.0 * (xx * px + xy * py)), by - square * (2.0 * (xy * px + yy * py)))
    v = (sn[0] + lean * nx, sn[1] + lean * ny)
    stiff = bar.end_inertia + 2.0 * (nx * sn[0] + ny * sn[1])
    g = (v[0] / stiff, v[1] / stiff)
    e = nx * (2.0 * far[0] - lean * tx) + ny * (2.0 * far[1] - lean * ty) - bar.load.torque
    c = (far[0] - mass * (cx + tx), far[1] - mass * (cy + ty))
    across = xy - v[0] * g[1]
    left_force = (
        affine(x=mass + xx - v[0] * g[0], y=across, one=c[0] - g[0] * e),
        affine(x=across, y=mass + yy - v[1] * g[1], one=c[1] - g[1] * e),
    )
    return ArticulatedBar(affine(x=-g[0], y=-g[1], one=-e / stiff), None, left_force, affine(), symmetric=True)


def symmetric_part(beyond: ArticulatedBar | None) -> tuple[tuple[Symbol, Symbol, Symbol], Pair]:
    """S (xx, xy, yy) and b of the chain beyond a bar; zero beyond the last."""
    if beyond is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0)
    x, y = beyond.left_force
    return (x[A_X], x[A_Y], y[A_Y]), (x[ONE], y[ONE])


def prescribed_acceleration(bar: SymbolicBar, law: Symbol, frame: str) -> Any:
    """Angular acceleration of a law, affine in a: `law` itself, or the sum with the longitude's or the bar before's."""
    if frame == Frame.PREVIOUS_BAR:
        return affine(previous=1.0, one=law)
    if frame == Frame.INERTIAL:
        return affine(one=law)
    (zx, zy), (vx, vy) = bar.position, bar.velocity
    r2 = zx * zx + zy * zy
    pull = specific_force(bar)
    swing = (pull[1] * zx - pull[0] * zy) / r2
    drift = 2.0 * (zx * vx + zy * vy) * (zx * vy - zy * vx) / (r2 * r2)
    given = swing + affine(one=law - drift)
    if bar.load.transverse_acceleration is not None:
        given = given + affine(one=bar.load.transverse_acceleration / r2)
    turn = given / (1.0 - given[TURN])  # the bar's own turning moves its centre about its left end
    turn[TURN] = 0.0
    return turn


def evaluated(function: Any, a: Pair, motor: Symbol, previous: Symbol = 0.0) -> Symbol:
    """Value of an affine function; `previous` is w' of the bar before."""
    given = function[A_X] * a[0] + function[A_Y] * a[1] + function[MOTOR] * motor + function[ONE]
    return given + function[PREVIOUS] * previous


def start(first: ArticulatedBar, *, motor: bool) -> tuple[Pair, Symbol]:
    """Acceleration of the first left end, and torque of joint 1's motor if the motor prescribes bar 1."""
    (a, b), one = first.left_force, ONE
    if not motor:
        det = a[A_X] * b[A_Y] - a[A_Y] * b[A_X]
        return ((a[A_Y] * b[one] - b[A_Y] * a[one]) / det, (b[A_X] * a[one] - a[A_X] * b[one]) / det), 0.0
    # the torque on bar 1 in Euler's law is the motor's own
    found = cramer([a, b, first.torque - affine(motor=1.0)])
    return (found[0], found[1]), found[2]


def cramer(rows: list[Any]) -> list[Symbol]:
    """Zero of three affine functions of a and the motor's torque, by Cramer's rule."""
    matrix = [[row[A_X], row[A_Y], row[MOTOR]] for row in rows]
    right = [-row[ONE] for row in rows]
    whole = determinant(matrix)
    return [
        determinant([[right[i] if k == j else matrix[i][k] for k in range(3)] for i in range(3)]) / whole
        for j in range(3)
    ]


def determinant(m: list[list[Symbol]]) -> Symbol:
    """Determinant of a 3 by 3 matrix, along its first row."""
    return (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    )


@dataclass(frozen=True)
class ChainMotion:
    """Accelerations and forces of a chain as expressions."""

    turn: list[Symbol]
    """(N,) angular accelerations"""
    reaction: list[Pair]
    """(N-1,) force on bar j from bar j+1"""
    torque: list[Symbol]
    """(P,) in the order of the laws"""


def chain_motion(bars: list[SymbolicBar], structure: Structure, laws: list[Symbol]) -> ChainMotion:
    """Equations of a chain; `laws` holds the second derivative of each prescribed law."""
    told = {law.bar: (law, second) for law, second in zip(structure.laws, laws, strict=True)}
    first_motor = 0 in told and told[0][0].joint
    articulated: list[ArticulatedBar] = []
    for j in reversed(range(len(bars))):
        beyond = articulated[0] if articulated else None
        law, second = told.get(j, (None, 0.0))
        pushed = first_motor and j == 1
        if law is None and not pushed and (beyond is None or beyond.symmetric):
            articulated.insert(0, backward_step_free(bars[j], beyond))
            continue
        prescribed = prescribed_acceleration(bars[j], second, law.frame) if law else None
        motor = law is not None and law.joint and j > 0
        articulated.insert(0, backward_step(bars[j], beyond, prescribed, motor=motor, pushed=pushed))
    return forward_pass(bars, structure, articulated, *start(articulated[0], motor=first_motor))


def forward_pass(
    bars: list[SymbolicBar],
    structure: Structure,
    articulated: list[ArticulatedBar],
    a: Pair,
    motor: Symbol,
) -> ChainMotion:
    """Accelerations, torques and reactions from the first bar to the last."""
    turns: list[Symbol] = []
    pulls: list[Pair] = []
    torques: dict[int, Symbol] = {}
    for j, (bar, seen) in enumerate(zip(bars, articulated, strict=True)):
        previous = turns[-1] if turns else 0.0
        turn = evaluated(seen.turn, a, motor, previous)
        turns.append(turn)
        if seen.torque is not None:
            torques[j] = evaluated(seen.torque, a, motor, previous)
        pull, end = specific_force(bar), end_acceleration(bar)
        pulls.append(tuple(bar.mass * (evaluated(p, a, 0.0) + p[TURN] * turn) for p in pull))
        a = (evaluated(end[0], a, 0.0) + end[0][TURN] * turn, evaluated(end[1], a, 0.0) + end[1][TURN] * turn)
    reaction: list[Pair] = []
    total: Pair = (0.0, 0.0)
    for x, y in reversed(pulls[1:]):
        total = (total[0] - x, total[1] - y)
        reaction.insert(0, total)
    return ChainMotion(turns, reaction, [torques[law.bar] for law in structure.laws])
