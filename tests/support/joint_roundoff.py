"""Random chains, and how much round-off their accelerations may show.

Every tolerance is a bound on round-off, of the form C u S: u = 2^-53, S the sum of the magnitudes that
enter, C the number of roundings on the way. What is asked of a solution is a small *residual* wherever a
law is checked (no conditioning in it: a banded Cholesky is backward stable), and the residual taken through
the inverse of the joint system where two *answers* are compared (`forward`).

Roundings counted: a dot product of two 2-vectors 3, a unit vector 2, the tide 20 (q 6, log1p and expm1 2
each, the two products and the sum 6, the mean over bars with N more), one entry of the joint matrix 8.
Cholesky of a banded matrix of four and its two substitutions: |dA| <= 3 (4+1) u |L||L'| (Higham, Accuracy and
Stability, 10.4), with (|L||L'|)_ik <= sqrt(a_ii a_kk). Together below 32 for a residual.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.chain import ChainModel, Prescription
from reference_impl.model.kinematics import consistent_state, directions

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.state import Accelerations, State

MU, RADIUS = 3.986004418e14, 6378e3
U = 2.0**-53
C = 32  # roundings on the way to one residual, see above
LONGEST_M = 1e4


@dataclass(frozen=True)
class Case:
    """A chain and its state."""

    model: ChainModel
    state: State


def case(
    seed: int,
    bars: int,
    gravity: str,
    decades: float,
    laws: tuple[Prescription, ...] = (),
    *,
    turning: float = 3.0,
) -> Case:
    """Masses and lengths spread over `decades`, inertias around a slender bar's, any attitude, any orbit."""
    random = np.random.default_rng(seed)
    mass = 10.0 ** random.uniform(-decades / 2, decades / 2, bars) * 100.0
    length = LONGEST_M * 10.0 ** -random.uniform(0.0, decades, bars)
    inertia = mass * length**2 / 12.0 * random.uniform(0.5, 2.0, bars)
    model = ChainModel(MU, mass, length, inertia, gravity, RADIUS, laws)
    radius, longitude = RADIUS * random.uniform(1.1, 6.0), random.uniform(-np.pi, np.pi)
    radial = np.array([np.cos(longitude), np.sin(longitude)])
    speed = np.sqrt(MU / radius)
    velocity = speed * (
        random.uniform(0.5, 1.4) * np.array([-radial[1], radial[0]]) + random.uniform(-0.5, 0.5) * radial
    )
    angle, rate = (
        random.uniform(-np.pi, np.pi, bars),
        speed / radius * random.uniform(-turning, turning, bars),
    )
    return Case(model, consistent_state(model, radius * radial, velocity, angle, rate))


def sums(reaction: Array) -> tuple[Array, Array]:
    """Reactions on either end of every bar: R_j + R_{j-1} and R_j - R_{j-1}, each (N, 2)."""
    ends = np.zeros((len(reaction) + 2, 2))
    ends[1:-1] = reaction
    return ends[1:] + ends[:-1], ends[1:] - ends[:-1]


@dataclass(frozen=True)
class Magnitudes:
    """What enters one bar's equations, in absolute values."""

    tide: float
    """of the tidal acceleration of any bar, m/s²"""
    end: Array
    """(N,) of the ends' accelerations about the centre: spin, centrifugal and reactions' lever, m/s²"""
    pull: Array
    """(N,) of the reactions over the mass, m/s²"""
    angular: Array
    """(N,) rad/s²"""


def magnitudes(c: Case, a: Accelerations) -> Magnitudes:
    m, s = c.model, c.state
    n2 = MU / np.linalg.norm(s.com_m) ** 3 if m.gravity != "none" else 0.0
    ends = sums(np.abs(a.reaction_N))[0].sum(axis=1)
    spin = 3.0 * n2 * np.ones(m.bars) if m.gravity == "gradient" else np.zeros(m.bars)
    for p, value in zip(m.prescriptions, a.torque_N_m, strict=True):
        spin[p.bar] += abs(value) / m.inertia_kg_m2[p.bar]
        if p.reacts_on is not None:
            spin[p.reacts_on] += abs(value) / m.inertia_kg_m2[p.reacts_on]
    angular = spin + m.half_m / m.inertia_kg_m2 * ends
    # 6 n² d bounds (power of 1/r) of any bar; the mean is no larger
    return Magnitudes(
        6.0 * n2 * float(np.linalg.norm(s.position_m, axis=1).max()),
        m.half_m * (angular + s.rate_rad_s**2),
        ends / m.mass_kg,
        angular,
    )


def joint_bound(c: Case, a: Accelerations) -> Array:
    """Round-off allowed in a joint's relative acceleration, (N-1,), m/s²: see the module's docstring."""
    m, size = c.model, magnitudes(c, a)
    diagonal = m.inverse_mass[:-1] + m.inverse_mass[1:] + m.compliance[:-1] + m.compliance[1:]
    strength = np.linalg.norm(a.reaction_N, axis=1)
    root = np.sqrt(diagonal)
    reach = root * strength
    near = reach.copy()
    near[1:] += reach[:-1]
    near[:-1] += reach[1:]
    terms = size.end[:-1] + size.end[1:] + size.pull[:-1] + size.pull[1:] + 2.0 * size.tide
    return C * U * (2.0 * root * near + terms) + m.bars * U * size.tide


def joint_system(model: ChainModel, angle_rad: Array) -> Array:
    """The joints' matrix of eq. (23) in full, (2(N-1), 2(N-1)), 1/kg, written out block by block."""
    _, across = directions(angle_rad)
    blocks, joints = model.compliance[:, None, None] * across[:, :, None] * across[:, None, :], model.bars - 1
    full = np.zeros((2 * joints, 2 * joints))
    for j in range(joints):
        here, after = slice(2 * j, 2 * j + 2), slice(2 * j + 2, 2 * j + 4)
        full[here, here] = (model.inverse_mass[j] + model.inverse_mass[j + 1]) * np.eye(2)
        full[here, here] += blocks[j] + blocks[j + 1]
        if j + 1 < joints:
            full[here, after] = full[after, here] = blocks[j + 1] - model.inverse_mass[j + 1] * np.eye(2)
    return full


def forward(c: Case, opening: Array) -> Array:
    """Change (N-1,), N, of the reactions that changes b (N-1,) of the right sides can cause: |A^-1| b."""
    full = joint_system(c.model, c.state.angle_rad)
    scale = 1.0 / np.sqrt(np.diag(full))  # scaled, the inverse is computed well however unequal the bars are
    inverse = np.abs(np.linalg.inv(full * scale[:, None] * scale[None, :])) * scale[:, None] * scale[None, :]
    change: Array = (inverse @ np.repeat(opening, 2)).reshape(-1, 2).sum(axis=1)
    return change
