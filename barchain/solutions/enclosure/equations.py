r"""Equations of a scene for balls and series: Lagrange's, in the bars' absolute angles.

*Places.* The centre of bar j is d_j = sum_k S_jk u_k from the chain's, u_k along bar k: from one centre to the next are
the right lever of the one bar and the left lever of the other. The mass-weighted mean is taken off: sum_j m_j S_jk = 0.

*Rotations.* The kinetic energy about the centre of mass is (1/2) sum A_ik cos(theta_i - theta_k) theta_i' theta_k' with
A_ik = sum_j m_j S_ji S_jk + J_i delta_ik, so that Lagrange's equations read

    sum_k A_ik (cos(theta_i - theta_k) theta_k'' + sin(theta_i - theta_k) theta_k'^2) = sum_j S_ji n_i·F_j + K_i

with the forces F_j at the bars' centres and the torques K_j. Joints do no work and do not appear. A prescribed rotation
adds its torque as an unknown, and the second derivative of its law as an equation. The centre of mass follows
M Z_0'' = sum F_j, and reactions follow from Newton's law of one bar after the other, R_j = R_(j-1) + m_j Z_j'' - F_j.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, assert_never

from flint import arb

from barchain.solutions.enclosure.forces import BarState, Forces, cross, dot, number
from barchain.solutions.enclosure.series import summed
from scenarios import Actuator, Course, Frame

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.solutions.enclosure.forces import Load, Pair
    from barchain.solutions.enclosure.series import Balls, Number, Tape
    from scenarios import Impulse, PrescribedRotation, Scene


@dataclass(frozen=True)
class State:
    """Unknowns of the motion, as balls or series: (2,), (2,), (N,), (N,), and (N - 1,) angles from that of bar 1.

    Wide balls lose the difference of angles that turn together: it is given besides.
    """

    t: Number
    place: list[Number]
    velocity: list[Number]
    angle: list[Number]
    rate: list[Number]
    bend: list[Number]

    @classmethod
    def of(cls, t: Number, values: Sequence[Number], bend: Sequence[Number] | None = None) -> State:
        """State from a row of all unknowns."""
        n = len(values) // 2 - 2
        place, velocity, angle, rate = (list(values[a:b]) for a, b in ((0, 2), (2, 4), (4, 4 + n), (4 + n, 4 + 2 * n)))
        return cls(t, place, velocity, angle, rate, [x - angle[0] for x in angle[1:]] if bend is None else list(bend))


@dataclass(frozen=True)
class Motion:
    """What the equations give at a state; jumps, at an impulse."""

    fall: list[Number]
    """(2,) acceleration of the centre of mass"""
    turn: list[Number]
    """(N,) angular accelerations"""
    torque: list[Number]
    """(P,) of the prescribed rotations"""
    reaction: list[Pair] = field(default_factory=list)
    """(N-1,) force on bar j from bar j+1; empty unless wanted"""


class Equations:
    """Equations of a scene between two breaks of its effects."""

    def __init__(self, scene: Scene, middle_s: float, *, gradient_sign: int = 1) -> None:
        """Take the numbers of a scene; arguments as those of :class:`Forces`."""
        chain, self.bars, self.middle_s = scene.chain, scene.bars, middle_s
        self.laws, self.forces = scene.effects.prescribed_rotation, Forces(scene, middle_s, gradient_sign=gradient_sign)
        self.mass = [number(m) for m in chain.mass_kg]
        self.inertia = [number(j) for j in chain.inertia_kg_m2]
        self.length = [number(x) for x in chain.length_m]
        shares = [number(share) for share in chain.com_share] or [arb(1) / 2] * self.bars
        self.left = [share * length for share, length in zip(shares, self.length, strict=True)]
        self.right = [length - left for length, left in zip(self.length, self.left, strict=True)]
        self.moving = bool(scene.effects.drag) or any(law.frame is Frame.LOCAL_HORIZONTAL for law in self.laws)
        """Whether velocities of the bars' centres are needed"""
        self.share = [m / sum(self.mass[1:], self.mass[0]) for m in self.mass]
        self.place = self.places()
        self.column = list(zip(*self.place, strict=True))
        self.energy = [[self.coupling(i, k) for k in range(self.bars)] for i in range(self.bars)]

    def places(self) -> list[list[arb]]:
        """Matrix S."""
        rows = [[arb(0)] * self.bars]
        for j in range(1, self.bars):
            row = list(rows[-1])
            row[j - 1], row[j] = row[j - 1] + self.right[j - 1], self.left[j]
            rows.append(row)
        mean = [summed(self.share, column) for column in zip(*rows, strict=True)]
        return [[x - m for x, m in zip(row, mean, strict=True)] for row in rows]

    def coupling(self, i: int, k: int) -> arb:
        """Coefficient A_ik of the kinetic energy."""
        found: arb = summed(self.mass, [row[i] * row[k] for row in self.place])
        return found + self.inertia[i] if i == k else found

    def geometry(self, ops: Balls | Tape, s: State) -> list[BarState]:
        """Places, directions and velocities of all bars."""
        waves = [ops.sin_cos(theta) for theta in s.angle]
        u = [(cosine, sine) for sine, cosine in waves]
        n = [(-sine, cosine) for sine, cosine in waves]
        numbers = zip(self.mass, self.inertia, self.length, self.left, self.right, strict=True)
        moving = [(a[0] * w, a[1] * w) for a, w in zip(n, s.rate, strict=True)] if self.moving else []
        (x, y), (vx, vy) = s.place, s.velocity
        found = []
        for j, (row, own) in enumerate(zip(self.place, numbers, strict=True)):
            dx, dy = (summed(row, [a[k] for a in u]) for k in (0, 1))
            wx, wy = (summed(row, [a[k] for a in moving]) if self.moving else 0 for k in (0, 1))
            places = ((x + dx, y + dy), (x, y), (dx, dy), (vx + wx, vy + wy))
            found.append(BarState(j, *places, u[j], n[j], s.angle[j], s.rate[j], *own))
        return found

    def motion(self, ops: Balls | Tape, s: State, *, reactions: bool = False) -> Motion:
        """Accelerations at a state, torques of the prescribed rotations, and on request reactions."""
        self.forces.watched.clear()
        bars = self.geometry(ops, s)
        loads = [self.forces.load(ops, s.t, bar) for bar in bars]
        torque = self.forces.joint_torques(s.t, s.angle, s.rate)
        loads = [(force, own + joint) for (force, own), joint in zip(loads, torque, strict=True)]
        seconds = [self.law(ops, law, s.t) for law in self.laws]
        common = self.forces.common(ops, (s.place[0], s.place[1]))
        waves = [ops.sin_cos(bend) for bend in s.bend]
        return self.solved(ops, bars, waves, loads, common, seconds, [w * w for w in s.rate], reactions=reactions)

    def jump(self, ops: Balls, s: State, impulses: Sequence[Impulse]) -> Motion:
        """Jumps of velocity and rates by impulses, and impulsive reactions: the equations' integral over an instant.

        Impulses take the place of forces; what stays finite drops out, and so do velocities.
        """
        zero = arb(0)
        bars = self.geometry(ops, State(s.t, s.place, [zero] * 2, s.angle, [zero] * self.bars, s.bend))
        loads: list[Load] = [((zero, zero), zero)] * self.bars
        for push in impulses:
            j = push.bar - 1
            (x, y), moment = self.forces.push(ops, push, number(push.impulse_N_s), bars[j])
            loads[j] = ((loads[j][0][0] + x, loads[j][0][1] + y), loads[j][1] + moment)
        waves = [ops.sin_cos(bend) for bend in s.bend]
        return self.solved(
            ops, bars, waves, loads, (zero, zero), [zero] * len(self.laws), [zero] * self.bars, reactions=True
        )

    def solved(
        self, ops: Balls | Tape, bars: list[BarState], waves: list[Pair], loads: list[Load], common: Pair,
        seconds: list[Number], square: list[Number], *, reactions: bool,
    ) -> Motion:  # fmt: skip
        """Lagrange's equations with loads, a common acceleration, second derivatives of laws and squares of rates.

        The common acceleration moves the centre of mass alone: sum_j m_j S_jk = 0. `waves` are sines and cosines of the
        angles from that of bar 1.
        """
        n = self.bars
        x, y = ([force[k] for force, _ in loads] for k in (0, 1))
        less = [sum(part, 0) * (self.share[0] / self.mass[0]) for part in (x, y)]
        fall = [common[0] + less[0], common[1] + less[1]]
        matrix: list[list[Number]] = [[self.energy[i][i] if i == k else 0 for k in range(n)] for i in range(n)]
        right: list[Number] = [
            dot(bar.n, (summed(column, x), summed(column, y))) + torque
            for bar, column, (_, torque) in zip(bars, self.column, loads, strict=True)
        ]
        for k, (sk, ck) in enumerate(waves, start=1):
            for i, (si, ci) in enumerate([(0, 1), *waves[: k - 1]]):
                cosine, sine = (ci * ck + si * sk, sk * ci - ck * si) if i else (ck, sk)
                matrix[i][k] = matrix[k][i] = cosine * self.energy[i][k]
                pull = sine * self.energy[i][k]  # of theta_k - theta_i
                right[i], right[k] = right[i] + pull * square[k], right[k] - pull * square[i]
        matrix = [row + [0] * len(self.laws) for row in matrix]
        for c, (law, second) in enumerate(zip(self.laws, seconds, strict=True), start=n):
            j = law.bar - 1
            matrix[j][c] = arb(-1)
            if law.actuator is Actuator.JOINT:
                matrix[j - 1 if j else 1][c] = arb(1)
            row, value = self.law_row(ops, law, bars, square, fall)
            matrix.append(row + [0] * len(self.laws))
            right.append(value + second)
        found = ops.solve(matrix, right)
        turn = found[:n]
        return Motion(fall, turn, found[n:], self.reactions(bars, loads, less, turn, square) if reactions else [])

    def law_row(
        self, ops: Balls | Tape, law: PrescribedRotation, bars: list[BarState], square: list[Number], fall: list[Number]
    ) -> tuple[list[Number], Number]:
        """Coefficients of the angular accelerations in a law's equation, and its right side without the law itself.

        Against the local horizontal its longitude turns by (Z x Z'')/r² - 2 (Z·Z')(Z x Z')/r⁴.
        """
        j = law.bar - 1
        row: list[Number] = [0] * self.bars
        if law.frame is not Frame.LOCAL_HORIZONTAL:
            row[j] = arb(1)
            if law.frame is Frame.PREVIOUS_BAR:
                row[j - 1] = arb(-1)
            return row, 0
        z, v, weights = bars[j].place, bars[j].velocity, self.place[j]
        over = ops.half_power(dot(z, z), -2)
        row = [cross(z, bar.n) * over * -weight for bar, weight in zip(bars, weights, strict=True)]
        row[j] = 1 + row[j]
        inwards = [summed(weights, [bar.u[k] * w for bar, w in zip(bars, square, strict=True)]) for k in (0, 1)]
        given = cross(z, (fall[0] - inwards[0], fall[1] - inwards[1])) * over
        return row, given - (dot(z, v) * over) * (cross(z, v) * over) * 2

    def law(self, ops: Balls | Tape, law: PrescribedRotation, t: Number) -> Number:
        """Second derivative of a prescribed angle."""
        for turn in law.turns:
            if not turn.start_s < self.middle_s < turn.end_s:
                continue
            length, amplitude = number(turn.duration_s), number(turn.amplitude_rad)
            s, scale = (t - number(turn.start_s)) * (1 / length), amplitude / (length * length)
            match turn.course:
                case Course.PAPER:
                    pi = arb.pi()
                    (_, once), (_, thrice) = ops.sin_cos(s * pi), ops.sin_cos(s * (3 * pi))
                    return (once - thrice) * (9 * pi * pi / 16 * scale)
                case Course.QUINTIC:
                    return s * (s * (s * 120 - 180) + 60) * scale
                case Course.SPLINE:
                    v0, v1 = (number(v) / length for v in turn.rates_rad_s)
                    a0, a1 = map(number, turn.accelerations_rad_s2)
                    linear = 60 * scale - 36 * v0 - 24 * v1 - 9 * a0 + 3 * a1
                    square = -180 * scale + 96 * v0 + 84 * v1 + 18 * a0 - 12 * a1
                    cube = 120 * scale - 60 * (v0 + v1) + 10 * (a1 - a0)
                    return s * (s * (s * cube + square) + linear) + a0
                case _:
                    assert_never(turn.course)
        return arb(0)

    def reactions(
        self, bars: list[BarState], loads: list[Load], less: list[Number], turn: list[Number], square: list[Number]
    ) -> list[Pair]:
        """Forces of the joints, by Newton's law of each bar from the first on, less the common acceleration."""
        moved = [
            tuple(bar.n[k] * a - bar.u[k] * w for k in (0, 1)) for bar, a, w in zip(bars, turn, square, strict=True)
        ]
        found: list[Pair] = []
        last: Pair = (arb(0), arb(0))
        for bar, row, (force, _) in list(zip(bars, self.place, loads, strict=True))[:-1]:
            x, y = (last[k] + (less[k] + summed(row, [m[k] for m in moved])) * bar.mass - force[k] for k in (0, 1))
            last = (x, y)
            found.append(last)
        return found
