"""An independent judge of accelerations: inertial coordinates, a dense system, fifty decimal digits.

It shares no formula with the project: masses and constraints are written as a Lagrangian of the first
kind in absolute coordinates, longitudes by logarithms of complex numbers, laws differenced numerically,
everything in Python's own decimal arithmetic, in which nothing cancels.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal, getcontext
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import BarTurn, ChainModel, Prescription
    from reference_impl.model.state import State

DIGITS = 50
getcontext().prec = DIGITS
PI = Decimal("3.1415926535897932384626433832795028841971693993751")
Vector = tuple[Decimal, Decimal]


@dataclass(frozen=True)
class ArbiterVerdict:
    """What the accelerations are, rounded to double at the very end."""

    place_m_s2: Array
    """(N, 2) Z_j''"""
    angle_rad_s2: Array
    """(N,)"""
    reaction_N: Array
    """(N-1, 2)"""
    torque_N_m: Array
    """(P,)"""
    relative_m_s2: Array
    """(N, 2) Z_j'' less the mean, subtracted in decimals"""


def exact(value: float) -> Decimal:
    """A double as the decimal number that it is."""
    return Decimal(float(value))


def pairs(rows: Array) -> list[Vector]:
    return [(exact(x), exact(y)) for x, y in rows]


def sine_cosine(angle: Decimal) -> tuple[Decimal, Decimal]:
    """By Taylor's series, after taking off whole turns."""
    x = angle % (2 * PI)
    sine, cosine, term = Decimal(0), Decimal(0), Decimal(1)
    for k in range(120):  # 6.3^120/120! is below 1e-100
        if k % 2 == 0:
            cosine += term if k % 4 == 0 else -term
        else:
            sine += term if k % 4 == 1 else -term
        term = term * x / (k + 1)
    return sine, cosine


def solve_dense(matrix: list[list[Decimal]], right: list[Decimal]) -> list[Decimal]:
    """Gaussian elimination with row pivoting."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, n):
            if rows[i][k]:
                factor = rows[i][k] / rows[k][k]
                rows[i] = [a - factor * b if b else a for a, b in zip(rows[i], rows[k], strict=True)]
    found = [Decimal(0)] * n
    for k in reversed(range(n)):
        known = sum((rows[k][i] * found[i] for i in range(k + 1, n)), Decimal(0))
        found[k] = (rows[k][n] - known) / rows[k][k]
    return found


def gravity(mu: Decimal, place: Vector) -> Vector:
    """-mu Z/|Z|³ in decimals."""
    r = (place[0] ** 2 + place[1] ** 2).sqrt()
    return -mu * place[0] / r**3, -mu * place[1] / r**3


def gravity_torque(mu: Decimal, inertia: Decimal, place: Vector, along: Vector) -> Decimal:
    """Torque of the field's gradient on an inertia: of two masses at equal arms that have it, arms to zero.

    A mass J/(2 a²) at each of +-a u is pulled with the field's derivative +-a (u·grad) g, so that the torque
    is J u x (u·grad) g = J u x (-mu u/r³ + 3 mu (u·Z) Z/r⁵) = 3 mu J (u·Z)(u x Z)/r⁵.
    """
    r = (place[0] ** 2 + place[1] ** 2).sqrt()
    dot = along[0] * place[0] + along[1] * place[1]
    return 3 * mu * inertia * dot * (along[0] * place[1] - along[1] * place[0]) / r**5


def law_acceleration(p: Prescription, t_s: float) -> Decimal:
    """Second derivative of a law, by a central difference with 50 digits; zero outside its turns."""
    return sum((turn_acceleration(turn, t_s) for turn in p.turns), Decimal(0))


def turn_acceleration(p: BarTurn, t_s: float) -> Decimal:
    """The same of one turn."""
    duration, amplitude = exact(p.duration_s), exact(p.amplitude_rad)
    x = (exact(t_s) - exact(p.start_s)) / duration
    if not 0 < x < 1:
        return Decimal(0)

    def angle(s: Decimal) -> Decimal:
        if p.quintic:
            return amplitude * s**3 * (10 - 15 * s + 6 * s**2)
        return amplitude / 16 * (sine_cosine(3 * PI * s)[1] - 9 * sine_cosine(PI * s)[1] + 8)

    h = Decimal("1e-12")
    return (angle(x + h) - 2 * angle(x) + angle(x - h)) / (h * duration) ** 2


def longitude_terms(place: Vector, motion: Vector) -> tuple[Vector, Decimal]:
    """a, b such that omega'' = a·Z'' + b, from omega = Im log z: omega'' = Im(z''/z - (z'/z)²)."""
    r2 = place[0] ** 2 + place[1] ** 2
    real = (motion[0] * place[0] + motion[1] * place[1]) / r2
    imaginary = (motion[1] * place[0] - motion[0] * place[1]) / r2
    return (-place[1] / r2, place[0] / r2), -2 * real * imaginary


def judge(model: ChainModel, t_s: float, state: State) -> ArbiterVerdict:
    """Accelerations of a state: M q'' = Q + C' (reactions) + D (torques), with joints and laws as rows."""
    n, laws = model.bars, model.prescriptions
    size, joints = 3 * n + 2 * (n - 1) + len(laws), 2 * (n - 1)
    half, mass, inertia = ([exact(v) for v in a] for a in (model.half_m, model.mass_kg, model.inertia_kg_m2))
    rate, mu = [exact(v) for v in state.rate_rad_s], exact(model.mu_m3_s2)
    trig = [sine_cosine(exact(a)) for a in state.angle_rad]
    place, motion = (
        absolute(state.com_m, state.position_m),
        absolute(state.com_velocity_m_s, state.velocity_m_s),
    )
    left, right = [[Decimal(0)] * size for _ in range(size)], [Decimal(0)] * size
    for j in range(n):
        sine, cosine = trig[j]
        force = gravity(mu, place[j]) if model.gravity != "none" else (Decimal(0), Decimal(0))
        for k, entry in enumerate((mass[j], mass[j], inertia[j])):
            left[3 * j + k][3 * j + k] = entry
        right[3 * j], right[3 * j + 1] = mass[j] * force[0], mass[j] * force[1]
        if model.gravity == "gradient":
            right[3 * j + 2] = gravity_torque(mu, inertia[j], place[j], (cosine, sine))
    for j in range(n - 1):
        for axis in range(2):
            row = 3 * n + 2 * j + axis
            for bar, sign in ((j, 1), (j + 1, -1)):
                sine, cosine = trig[bar]
                lever = half[bar] * (-sine if axis == 0 else cosine)
                reach = half[bar] * (cosine if axis == 0 else sine)
                left[row][3 * bar + axis], left[row][3 * bar + 2] = Decimal(sign), lever
                left[3 * bar + axis][row], left[3 * bar + 2][row] = Decimal(-sign), -lever
                right[row] += rate[bar] ** 2 * reach
    for i, p in enumerate(laws):
        row = 3 * n + joints + i
        left[row][3 * p.bar + 2], left[3 * p.bar + 2][row] = Decimal(1), Decimal(-1)
        if p.reacts_on is not None:
            left[3 * p.reacts_on + 2][row] = Decimal(1)
        right[row] = law_acceleration(p, t_s)
        if p.frame == "previous_bar":
            left[row][3 * p.bar - 1] = Decimal(-1)
        if p.frame == "local_horizontal":
            turn, rest = longitude_terms(place[p.bar], motion[p.bar])
            left[row][3 * p.bar], left[row][3 * p.bar + 1] = -turn[0], -turn[1]
            right[row] += rest
    found = solve_dense(left, right)
    places = [(found[3 * j], found[3 * j + 1]) for j in range(n)]
    return ArbiterVerdict(
        doubles(places),
        np.array([float(found[3 * j + 2]) for j in range(n)]),
        np.array([float(v) for v in found[3 * n : 3 * n + joints]]).reshape(-1, 2),
        np.array([float(v) for v in found[3 * n + joints :]]),
        doubles(from_mean(mass, places)),
    )


def absolute(centre: Array, relative: Array) -> list[Vector]:
    x, y = exact(centre[0]), exact(centre[1])
    return [(x + a, y + b) for a, b in pairs(relative)]


def from_mean(mass: Sequence[Decimal], rows: Sequence[Vector]) -> list[Vector]:
    total = sum(mass, Decimal(0))
    mean = [sum((m * v[k] for m, v in zip(mass, rows, strict=True)), Decimal(0)) / total for k in range(2)]
    return [(v[0] - mean[0], v[1] - mean[1]) for v in rows]


def doubles(rows: Sequence[Vector]) -> Array:
    return np.array([[float(x), float(y)] for x, y in rows])


def field(model: ChainModel, state: State) -> tuple[Array, Array]:
    """Mean gravity (2,), and each bar's less the mean (N, 2), m/s²."""
    mass = [exact(m) for m in model.mass_kg]
    zero = (Decimal(0), Decimal(0))
    pulled = [
        gravity(exact(model.mu_m3_s2), z) if model.gravity != "none" else zero
        for z in absolute(state.com_m, state.position_m)
    ]
    differences = from_mean(mass, pulled)
    mean = np.array([float(pulled[0][k] - differences[0][k]) for k in range(2)])
    return mean, doubles(differences)
