"""Impulses against independent derivations: all equations at once, momentum, Gauss's least constraint."""

from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest

from reference_impl.effects.impulse import apply_impulses
from reference_impl.model.arrays import Array
from reference_impl.model.chain import BarImpulse, BarTurn, ChainModel, Prescription
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.kinematics import consistent_state, cross
from reference_impl.model.state import State
from tests.support.effect_cases import chain, motion
from tests.support.joint_roundoff import C, Case, U, forward

LAWS = {
    "free": (),
    "held in inertial axes": (Prescription(1, (BarTurn(0.4, 60.0, 0.0),), frame="inertial", reacts_on=None),),
    "held against the horizontal": (
        Prescription(1, (BarTurn(0.4, 60.0, 0.0),), frame="local_horizontal", reacts_on=None),
    ),
    "motors": (
        Prescription(2, (BarTurn(0.4, 60.0, 0.0),), frame="local_horizontal", reacts_on=1),
        Prescription(0, (BarTurn(0.4, 60.0, 0.0),), frame="inertial", reacts_on=None),
    ),
}
BLOWS = [BarImpulse(2, 1.0, False, 1.1, 5.0, 0.0), BarImpulse(0, -1.0, True, -2.0, 3.0, 0.0)]


def blow_by_blow(seed: int, laws: str) -> tuple[ChainModel, State]:
    random = np.random.default_rng(seed)
    model = replace(chain(random, 4, 10.0), prescriptions=LAWS[laws])
    return model, motion(random, model)


def dense(model: ChainModel, state: State) -> tuple[Array, Array, Array]:
    """Jumps of places' and angles' rates and the impulsive reactions, by all equations at once in fifty digits."""
    n, laws = model.bars, model.prescriptions
    size = 3 * n + 2 * (n - 1) + len(laws)
    with mp.workdps(50):
        unit = [mp.expj(mp.mpf(a)) for a in state.angle_rad]
        place = [mp.mpc(*map(float, state.com_m)) + mp.mpc(*map(float, d)) for d in state.position_m]
        left, right = mp.zeros(size, size), mp.zeros(size, 1)
        for j in range(n):
            for k, entry in enumerate((model.mass_kg[j], model.mass_kg[j], model.inertia_kg_m2[j])):
                left[3 * j + k, 3 * j + k] = mp.mpf(entry)
        for blow in BLOWS:
            turn = 1 if blow.inertial else unit[blow.bar]
            impulse = mp.mpf(blow.impulse_N_s) * mp.expj(mp.mpf(blow.direction_rad)) * turn
            arm = mp.mpf(blow.side) * mp.mpf(model.half_m[blow.bar]) * unit[blow.bar]
            for k, part in enumerate((impulse.real, impulse.imag, (mp.conj(arm) * impulse).imag)):
                right[3 * blow.bar + k] += part
        for j in range(n - 1):
            for axis in range(2):
                row = 3 * n + 2 * j + axis
                for bar, sign in ((j, 1), (j + 1, -1)):
                    across = mp.mpc(0, 1) * unit[bar] * mp.mpf(model.half_m[bar])
                    lever = across.real if axis == 0 else across.imag
                    left[row, 3 * bar + axis], left[row, 3 * bar + 2] = sign, lever
                    left[3 * bar + axis, row], left[3 * bar + 2, row] = -sign, -lever
        for i, p in enumerate(laws):
            row = 3 * n + 2 * (n - 1) + i
            left[row, 3 * p.bar + 2], left[3 * p.bar + 2, row] = 1, -1
            if p.reacts_on is not None:
                left[3 * p.reacts_on + 2, row] = 1
            if p.frame == "previous_bar":
                left[row, 3 * p.bar - 1] = -1
            if p.frame == "local_horizontal":
                z = place[p.bar]
                left[row, 3 * p.bar], left[row, 3 * p.bar + 1] = z.imag / abs(z) ** 2, -z.real / abs(z) ** 2
        found = np.array([float(x) for x in mp.lu_solve(left, right)])
    moved = found[: 3 * n].reshape(n, 3)
    return moved[:, :2], moved[:, 2], found[3 * n : 5 * n - 2].reshape(n - 1, 2)


@pytest.mark.parametrize("laws", LAWS)
@pytest.mark.parametrize("seed", range(2))
def test_a_blow_changes_velocities_as_all_equations_at_once_say(seed: int, laws: str) -> None:
    """Round-off of the joints' relative velocities, taken through the joints; the prescribed ones twice."""
    model, state = blow_by_blow(seed, laws)
    after, reaction = apply_impulses(model, state, BLOWS)
    jump, spin, right = dense(model, state)
    strength = sum(abs(b.impulse_N_s) for b in BLOWS) + np.abs(right).sum()
    ends = strength * float((model.inverse_mass + model.compliance).max())
    opening = np.full(model.bars - 1, (2.0 + len(model.prescriptions)) * C * U * ends)
    allowed = forward(Case(model, state), opening)
    assert np.all(np.linalg.norm(reaction - right, axis=1) <= allowed)
    loosened = 2.0 * allowed.max()
    velocity = after.com_velocity_m_s - state.com_velocity_m_s + after.velocity_m_s - state.velocity_m_s
    rounded = 4.0 * U * np.linalg.norm(state.com_velocity_m_s)  # of the sums and differences just taken
    assert np.abs(velocity - jump).max() <= (loosened + C * U * strength) * model.inverse_mass.max() + rounded
    turned = after.rate_rad_s - state.rate_rad_s
    assert np.abs(turned - spin).max() <= (loosened + C * U * strength) * 2.0 * model.lever.max()


@pytest.mark.parametrize("seed", range(2))
def test_a_blow_gives_its_momentum_and_its_moment_and_leaves_the_joints_closed(seed: int) -> None:
    model, state = blow_by_blow(seed, "free")
    after, _ = apply_impulses(model, state, BLOWS)
    unit = unit_along(state.angle_rad)
    given = {b: b.impulse_N_s * np.exp(1j * b.direction_rad) * (1.0 if b.inertial else unit[b.bar]) for b in BLOWS}
    total = sum(given.values())
    gained = (after.com_velocity_m_s - state.com_velocity_m_s) * model.mass_kg.sum()
    speed, mass = np.linalg.norm(state.com_velocity_m_s), model.mass_kg.sum()
    assert abs(complex(*gained) - total) <= C * U * (mass * speed + abs(total))
    place = state.position_m[:, 0] + 1j * state.position_m[:, 1]
    ends = {b: place[b.bar] + b.side * model.half_m[b.bar] * unit[b.bar] for b in BLOWS}
    moment = sum((np.conj(ends[b]) * given[b]).imag for b in BLOWS)
    slip = after.velocity_m_s - state.velocity_m_s
    turned = cross(state.position_m, slip) @ model.mass_kg
    turned += (after.rate_rad_s - state.rate_rad_s) @ model.inertia_kg_m2
    size = model.length_m.sum() * sum(map(abs, given.values()))
    assert abs(turned - moment) <= 8.0 * C * U * size
    closed = consistent_state(model, state.com_m, state.com_velocity_m_s, state.angle_rad, after.rate_rad_s)
    rates = np.abs(after.rate_rad_s).max() * model.length_m.sum()
    assert np.abs(closed.velocity_m_s - after.velocity_m_s).max() <= 8.0 * C * U * (rates + size / mass)
