"""Newton-Euler equations of a chain in redundant coordinates, with the joints as constraints: residual and Jacobian.

Each bar has the place of its centre in a freely falling frame and its angle, q = (x, y, theta). With u along a bar and
n normal to it, a and b the distances of its ends, and R_j the force on bar j from bar j+1:

    q_j' = v_j
    m_j v_j' = f_j + R_j - R_(j-1)
    J_j w_j' = k_j + n_j . (b_j R_j + a_j R_(j-1))
    g_j = (d_j + b_j u_j) - (d_(j+1) - a_(j+1) u_(j+1)) = 0

The right sides are G^T R, with G the derivative of g by q: the multipliers are the reactions. Index 3 has g = 0,
index 2 has g' = G v = 0, index 1 has g'' = G v' + s = 0, where s is made of squares of rates. The stabilised form of
index 2 (Gear, Gupta, Leimkuhler) has g = 0 and g' = 0, with q' = v + M^-1 G^T p; its second multipliers p vanish in the
exact motion.

All is in units of the longest bar, its mass, and the fastest rate, so that one tolerance suits all components, and the
matrix of a step of h holds 1 and powers of h alone.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.chain_loads import ChainLoads
from adapters.bar_loads.falling_frame import fall_rate
from adapters.bar_loads.forces import impulse_jumps
from adapters.bar_loads.gravity import MovingLoads
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.common.accuracy_scales import accuracy_scales
from adapters.common.landing import least_height_m

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene

COLOURS = 3  # the load of a bar depends on the bar and its neighbours: every third bar can move at once
DIFFERENCE = 1e-7  # of a unit, by which loads are differenced for the Jacobian
ROUNDED = 10.0
"""Tolerance of multipliers relative to the request, of Newton's method alone. Their corrections are rounded to u/h, and
IDA gives up where a correction is no smaller than the one before"""
PLACES, FORCES = 1e-3, 1e4
"""Tolerances at index 3 relative to the request, which is that of rates: each derivative of the places divides their
error by the step, and that of forces is Newton's alone"""
START, START_3 = 1.0 / 2.0, 1.0 / 3.0
"""Power of the smallest tolerance that is the first step in radians; a longer one at index 3, where the rounding of
multipliers is u/h²"""


class Form(Enum):
    """Constraints that hold the joints."""

    INDEX_1 = 1
    """Accelerations"""
    INDEX_2 = 2
    """Velocities"""
    INDEX_3 = 3
    """Positions"""
    STABILISED = 4
    """Velocities and positions"""


class RedundantChain:
    """The chain as a differential-algebraic system F(t, y, y') = 0, in its own units.

    The components of y are the frame's origin and velocity (4,), places x, y and angles of all bars (3 N,), their rates
    (3 N,), the reactions' components along both axes (2 (N - 1),), and in the stabilised form as many p.
    """

    def __init__(self, scene: Scene, form: Form) -> None:
        """Prepare masses, constraints, loads and units of `scene`."""
        self.form, self.bars, self.joints = form, scene.bars, scene.bars - 1
        self.properties, self.fall_rate = bars_of(scene.chain), fall_rate(scene)
        self.loads = ChainLoads(scene, MovingLoads(scene, surface=False), falling=True)
        self.radius_m, self.mu = scene.central_body.radius_m, scene.central_body.mu_m3_s2
        self.length_m, self.left_m = np.array(scene.chain.length_m), np.array(scene.chain.left_m)
        self.inside_s = 0.0  # an instant within the current segment between events

        scales = accuracy_scales(scene)
        unit_m, self.rate = scales.length_m, scales.rate_rad_s
        mass_kg = max(scene.chain.mass_kg)
        n, m = 3 * self.bars, 2 * self.joints
        self.q, self.v, self.reactions = slice(4, 4 + n), slice(4 + n, 4 + 2 * n), slice(4 + 2 * n, 4 + 2 * n + m)
        self.extra = slice(self.reactions.stop, self.reactions.stop + m * (form is Form.STABILISED))
        place = np.repeat([unit_m, unit_m, 1.0], self.bars)
        force = np.full(m, mass_kg * unit_m * self.rate**2)
        self.units = np.concatenate([
            scales.track, place, self.rate * place, force, np.ones(self.extra.stop - self.extra.start)
        ])  # fmt: skip
        self.load_units = self.rate**2 * place
        self.differential = np.ones(len(self.units))
        """1 for components that are differentiated and fit for an error test, else 0"""
        self.differential[self.reactions.start :] = 0.0
        self.shares, self.start_power = np.ones(len(self.units)), START
        """Tolerance of each component relative to the requested accuracy, and power of the first step"""
        self.shares[self.reactions.start :] = ROUNDED
        if form is Form.INDEX_3:  # whose rates follow from the constraints like multipliers
            self.differential[self.v] = 0.0
            self.shares[self.q], self.shares[self.reactions], self.start_power = PLACES, FORCES, START_3
        # springs, thrusts and motors make forces of another size
        self.shares[self.reactions] *= max(1.0, scene.fastest_rate_rad_s / self.rate) ** 2
        inertia = np.array(scene.chain.inertia_kg_m2) / (mass_kg * unit_m**2)
        self.inverse_mass = 1.0 / np.concatenate([np.tile(np.array(scene.chain.mass_kg) / mass_kg, 2), inertia])
        self.right, self.left = np.array(scene.chain.right_m)[:-1] / unit_m, self.left_m[1:] / unit_m
        joint, before, after = np.arange(self.joints), np.arange(self.joints), np.arange(1, self.bars)
        self.near = (joint, 2 * self.bars + before), (joint + self.joints, 2 * self.bars + before)
        self.far = (joint, 2 * self.bars + after), (joint + self.joints, 2 * self.bars + after)
        self.straight = np.zeros((m, n))
        for axis in (0, 1):
            self.straight[joint + axis * self.joints, axis * self.bars + before] = 1.0
            self.straight[joint + axis * self.joints, axis * self.bars + after] = -1.0

    def ends(self, q: Array) -> tuple[Array, Array, Array, Array]:
        """Vectors b u of right ends and a u of left ends at the joints, by components: four of (N-1,)."""
        angle = q[2 * self.bars :]
        c, s = np.cos(angle), np.sin(angle)
        return self.right * c[:-1], self.right * s[:-1], self.left * c[1:], self.left * s[1:]

    def turned(self, near: Sequence[Array], far: Sequence[Array]) -> Array:
        """Matrix (2 (N-1), 3 N) whose columns of angles have `near` of a joint's bar before it, `far` of that after."""
        found = self.straight.copy()
        for axis in (0, 1):
            found[self.near[axis]], found[self.far[axis]] = near[axis], far[axis]
        return found

    def constraint_matrix(self, q: Array) -> Array:
        """Derivative G of the gaps by the coordinates."""
        rx, ry, lx, ly = self.ends(q)
        return self.turned((-ry, rx), (-ly, lx))

    def gaps(self, q: Array) -> Array:
        """Gaps g of all joints, first their x, then their y (2 (N-1),)."""
        rx, ry, lx, ly = self.ends(q)
        between = self.straight[:, : 2 * self.bars] @ q[: 2 * self.bars]
        found: Array = between + np.concatenate([rx + lx, ry + ly])
        return found

    def squares(self, q: Array, v: Array) -> Array:
        """Part s of g'' that is made of squares of rates."""
        (rx, ry, lx, ly), w = self.ends(q), v[2 * self.bars :] ** 2
        return -np.concatenate([rx * w[:-1] + lx * w[1:], ry * w[:-1] + ly * w[1:]])

    def accelerations(self, t: float, y: Array) -> Array:
        """Accelerations of all bars by loads alone, (3 N,)."""
        return self.loads_at(t, y[:4], y[self.q], y[self.v])

    def loads_at(self, t: float, origin: Array, q: Array, v: Array) -> Array:
        """The same of an origin, coordinates and rates."""
        if not self.loads.act:
            return np.zeros(len(q))
        load = np.array(self.loads(*self.placed(t, origin, q, v)))
        found: Array = load.T.ravel() / self.load_units
        return found

    def placed(
        self, t: float, origin: Array, q: Array, v: Array
    ) -> tuple[FrameState, list[tuple[float, float, float]], list[tuple[float, float, float]]]:
        """Frame, places and rates of the bars as loads take them, in SI units."""
        x, y, vx, vy = (origin * self.units[:4]).tolist()
        frame = FrameState(x, y, vx, vy, t / self.rate, self.inside_s)
        places = (q * self.units[self.q]).reshape(3, -1).T.tolist()
        rates = (v * self.units[self.v]).reshape(3, -1).T.tolist() if self.loads.of_rates else []
        return frame, list(map(tuple, places)), list(map(tuple, rates))

    def origin_rate(self, t: float, origin: Array) -> Array:
        """Rate of the frame's origin."""
        slopes = self.fall_rate(t / self.rate, origin * self.units[:4])
        return np.array(slopes) / (self.rate * self.units[:4])

    def residual(self, t: float, y: Array, slopes: Array) -> Array:
        """Residual F (size,) at the time t in units of 1/w."""
        q, v, force, matrix = y[self.q], y[self.v], y[self.reactions], self.constraint_matrix(y[self.q])
        found = np.empty(len(y))
        found[:4] = slopes[:4] - self.origin_rate(t, y[:4])
        found[self.q] = slopes[self.q] - v
        found[self.v] = slopes[self.v] - self.accelerations(t, y) - self.inverse_mass * (force @ matrix)
        if self.form is Form.INDEX_3:
            found[self.reactions] = self.gaps(q)
        elif self.form is Form.INDEX_1:
            found[self.reactions] = matrix @ slopes[self.v] + self.squares(q, v)
        else:
            found[self.reactions] = matrix @ v
        if self.form is Form.STABILISED:
            found[self.q] -= self.inverse_mass * (y[self.extra] @ matrix)
            found[self.extra] = self.gaps(q)
        return found

    def jacobian(self, t: float, y: Array, slopes: Array, c: float) -> Array:
        """Matrix dF/dy + c dF/dy', (size, size); without the loads' dependence on the frame, and that of p."""
        q, v, force, matrix = y[self.q], y[self.v], y[self.reactions], self.constraint_matrix(y[self.q])
        found = np.zeros((len(y), len(y)))
        on, off = np.arange(4 + 6 * self.bars), np.arange(3 * self.bars)
        found[on, on] = c
        found[:4, :4] -= self.origin_gradient(y[:4])
        found[4 + off, 4 + 3 * self.bars + off] = -1.0
        by_q, by_v = self.load_gradients(t, y)
        rx, ry, lx, ly = self.ends(q)
        turning, fx, fy = np.arange(2 * self.bars, 3 * self.bars), force[: self.joints], force[self.joints :]
        pull = np.zeros(self.bars)  # derivative of n . (b R + a R) by the angle
        pull[:-1] -= rx * fx + ry * fy
        pull[1:] -= lx * fx + ly * fy
        by_q[turning, turning] += self.inverse_mass[turning] * pull
        found[self.v, self.q] = -by_q
        found[self.v, self.v] -= by_v
        found[self.v, self.reactions] = -self.inverse_mass[:, None] * matrix.T
        w, a = v[turning], slopes[self.v][turning]

        def second(before: Array, after: Array) -> Array:
            """Derivative by the angles of b x n for a factor x of each bar, less `straight`."""
            near, far = before[:-1], after[1:]
            return self.turned((-rx * near, -ry * near), (-lx * far, -ly * far)) - self.straight

        rows = self.reactions
        if self.form is Form.INDEX_3:
            found[rows, self.q] = matrix
        elif self.form is Form.INDEX_1:
            w2 = w**2
            normal = self.turned((ry * w2[:-1], -rx * w2[:-1]), (ly * w2[1:], -lx * w2[1:])) - self.straight
            found[rows, self.q] = second(a, a) + normal
            found[rows, self.v] = c * matrix + 2.0 * second(w, w)
        else:
            found[rows, self.q], found[rows, self.v] = second(w, w), matrix
        if self.form is Form.STABILISED:
            found[self.q, self.extra] = -self.inverse_mass[:, None] * matrix.T
            found[self.extra, self.q] = matrix
        return found

    def origin_gradient(self, origin: Array) -> Array:
        """Derivative of the origin's rate by its state, (4, 4): of the central body's field alone."""
        place, found = origin[:2] * self.units[:2], np.zeros((4, 4))
        r2 = float(place @ place)
        found[:2, 2:] = np.eye(2)
        found[2:, :2] = self.mu / (r2**1.5 * self.rate**2) * (3.0 * np.outer(place, place) / r2 - np.eye(2))
        return found

    def load_gradients(self, t: float, y: Array) -> tuple[Array, Array]:
        """Derivatives of the loads by coordinates and by rates, (3 N, 3 N) each, by differences."""
        size, bars = 3 * self.bars, np.arange(self.bars)
        found = np.zeros((2, size, size))
        if not self.loads.act:
            return found[0], found[1]
        state = np.stack([y[self.q], y[self.v]])
        at_rest = self.loads_at(t, y[:4], *state)
        for of in (0, 1) if self.loads.of_rates else (0,):
            for kind in range(3):
                for colour in range(min(COLOURS, self.bars)):
                    moved = state.copy()
                    moved[of, kind * self.bars + bars[colour::COLOURS]] += DIFFERENCE
                    change = (self.loads_at(t, y[:4], *moved) - at_rest).reshape(3, -1) / DIFFERENCE
                    # the one of a bar and its neighbours that moved
                    cause = bars + (colour - bars + 1) % COLOURS - 1
                    inside = (cause >= 0) & (cause < self.bars)
                    for row in range(3):
                        found[of, row * self.bars + bars[inside], kind * self.bars + cause[inside]] = change[
                            row, inside
                        ]
        return found[0], found[1]

    def consistent(self, t: float, y: Array) -> tuple[Array, Array]:
        """State with rates that close the joints and with reactions that keep them closed, and its slopes."""
        begun, slopes = y.copy(), np.zeros(len(y))
        matrix = self.constraint_matrix(y[self.q])
        weighted = self.inverse_mass[:, None] * matrix.T
        system = matrix @ weighted
        begun[self.v] -= weighted @ np.linalg.solve(system, matrix @ y[self.v])
        free = self.accelerations(t, begun)
        opening = matrix @ free + self.squares(begun[self.q], begun[self.v])
        begun[self.reactions] = -np.linalg.solve(system, opening)
        slopes[:4], slopes[self.q] = self.origin_rate(t, begun[:4]), begun[self.v]
        slopes[self.v] = free + weighted @ begun[self.reactions]
        return begun, slopes

    def start(self, state: InitialState) -> Array:
        """State in SI units, (size,), its reactions still zero."""
        found = np.zeros(len(self.units))
        found[:4] = *state.com_m, *state.com_velocity_m_s
        found[self.q] = np.concatenate([*state.position_m.T, state.angle_rad])
        found[self.v] = np.concatenate([*state.velocity_m_s.T, state.rate_rad_s])
        return found

    def apply_impulses(self, state: Array, impulses: Sequence[Impulse]) -> tuple[Array, Array]:
        """State after impulses, in SI units, and the impulsive reactions on each bar from the next, (N-1, 2), N s."""
        y = state / self.units
        angle = y[self.q][2 * self.bars :].tolist()
        given = np.array(impulse_jumps(self.properties, impulses, angle)).T.ravel() / self.units[self.v]
        matrix = self.constraint_matrix(y[self.q])
        weighted = self.inverse_mass[:, None] * matrix.T
        held = -np.linalg.solve(matrix @ weighted, matrix @ given)
        y[self.v] += given + weighted @ held
        return y * self.units, (held * self.units[self.reactions] / self.rate).reshape(2, -1).T

    def height(self, state: Array) -> float:
        """Least distance of any point of any bar from the surface, m, of a state in SI units."""
        x, y, angle = state[self.q].reshape(3, -1)
        place = state[:2] + np.stack([x, y], axis=-1)
        return least_height_m(self.radius_m, self.length_m, place, angle, self.left_m)
