"""Impulse on a bar's end: velocities change at once, joints stay closed, prescribed bars keep the rates of their laws.

The impulsive reactions solve the joint system of eqs. (19) and (21), with impulses for impulses and zero bar rates.
"""

from __future__ import annotations

import cmath
import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.complex_vectors import as_vectors, unit_along
from reference_impl.model.relative import ReactionSolution, torques_for_accelerations

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import BarImpulse, ChainModel
    from reference_impl.model.state import State


def apply_impulses(model: ChainModel, state: State, impulses: list[BarImpulse]) -> tuple[State, Array]:
    """State just after impulses at one instant, and the impulsive reactions (N-1, 2) on bar j from bar j+1, N s.

    Parameters
    ----------
    model : ChainModel
    state : State
        State just before.
    impulses : list of BarImpulse
    """
    unit = unit_along(state.angle_rad)
    field, spin = np.zeros(model.bars, complex), np.zeros(model.bars)
    for given in impulses:
        k, u = given.bar, unit[given.bar]
        impulse = given.impulse_N_s * cmath.rect(1.0, given.direction_rad) * (1.0 if given.inertial else u)
        field[k] += impulse / model.mass_kg[k]
        spin[k] += given.side * model.lever[k] * (np.conj(u) * impulse).imag
    still = dataclasses.replace(state, rate_rad_s=np.zeros(model.bars))
    solution = ReactionSolution(model, still, unit, field, spin)
    torque = torques_for_accelerations(model, state, solution, field, np.zeros(len(model.prescriptions)))
    reaction = solution.reaction(torque)
    drift = field @ model.weight
    return dataclasses.replace(
        state,
        com_velocity_m_s=state.com_velocity_m_s + np.array([drift.real, drift.imag]),
        rate_rad_s=state.rate_rad_s + solution.angular_accelerations(reaction, torque),
        velocity_m_s=state.velocity_m_s + as_vectors(field - drift + solution.translation_from_reactions(reaction)),
    ), as_vectors(reaction)
