"""A blow on a bar's end: velocities jump, joints hold, and prescribed bars keep the rates of their laws.

It is the joints' own system, eqs. (19) and (21), with impulses for forces and no bar turning.
"""

from __future__ import annotations

import cmath
import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.complex_vectors import along, as_vectors
from reference_impl.model.relative import Turning, balanced_torques

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel, Impulse
    from reference_impl.model.state import State


def struck(model: ChainModel, state: State, blows: list[Impulse]) -> tuple[State, Array]:
    """State just after some blows at one instant, and the impulsive reactions (N-1, 2) on bar j from bar j+1, N s.

    Parameters
    ----------
    model : ChainModel
    state : State
        Just before.
    blows : list of Impulse
    """
    unit = along(state.angle_rad)
    field, spin = np.zeros(model.bars, complex), np.zeros(model.bars)
    for blow in blows:
        k, u = blow.bar, unit[blow.bar]
        impulse = blow.impulse_N_s * cmath.rect(1.0, blow.direction_rad) * (1.0 if blow.inertial else u)
        field[k] += impulse / model.mass_kg[k]
        spin[k] += blow.side * model.lever[k] * (np.conj(u) * impulse).imag
    still = dataclasses.replace(state, rate_rad_s=np.zeros(model.bars))
    turning = Turning(model, still, unit, field, spin)
    torque = balanced_torques(model, state, turning, field, np.zeros(len(model.prescriptions)))
    reaction = turning.reaction(torque)
    drift = field @ model.weight
    return dataclasses.replace(
        state,
        com_velocity_m_s=state.com_velocity_m_s + np.array([drift.real, drift.imag]),
        rate_rad_s=state.rate_rad_s + turning.angular(reaction, torque),
        velocity_m_s=state.velocity_m_s + as_vectors(field - drift + turning.pull(reaction)),
    ), as_vectors(reaction)
