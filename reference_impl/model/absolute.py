"""Absolute formulation: the same chain in inertial coordinates counted from the centre of the body.

Gravity's differences between bars and the joint gaps are differences of large numbers in these coordinates; the paper
advises against them. All other terms equal those of the relative formulation. A comparison of both formulations
therefore shows the effect of the coordinates alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.complex_vectors import as_complex, as_vectors, unit_along
from reference_impl.model.effect import EffectState, Modes, total_accelerations
from reference_impl.model.gravity import gradient_angular_accelerations, point_field
from reference_impl.model.relative import ReactionSolution, prescribed_torques
from reference_impl.model.state import Accelerations, State

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel


def accelerations(
    model: ChainModel,
    t_s: float,
    place_m: Array,
    velocity_m_s: Array,
    angle_rad: Array,
    rate_rad_s: Array,
    modes: Modes | None = None,
    *,
    refine: bool = True,
) -> Accelerations:
    """Accelerations, reactions and torques of a state in absolute coordinates, eqs. (8), (15), (19).

    Parameters
    ----------
    model : ChainModel
    t_s : float
        Time, for the prescribed laws.
    place_m, velocity_m_s : ndarray, shape (N, 2)
        Z_j and its rate.
    angle_rad, rate_rad_s : ndarray, shape (N,)
    modes : Modes, optional
        Modes of the model's effects; by default they follow from the state.
    refine : bool
        As in :func:`reference_impl.model.relative.accelerations`.

    Returns
    -------
    Accelerations
        `position_m_s2` is Z_j'', and `com_m_s2` their mass-weighted mean.
    """
    unit = unit_along(angle_rad)
    field, spin = np.zeros(model.bars, complex), np.zeros(model.bars)
    if model.gravity != "none":
        field = as_complex(point_field(model.mu_m3_s2, place_m))
    if model.gravity == "gradient":
        spin = gradient_angular_accelerations(model, as_complex(place_m), unit)
    origin = np.zeros(2)
    state = State(origin, origin, angle_rad, rate_rad_s, place_m, velocity_m_s)
    noncentral_acceleration = None
    if model.effects:
        at = EffectState(model, t_s, state, unit, absolute=True)
        added, noncentral_acceleration = total_accelerations(at, modes or (None,) * len(model.effects))
        field, spin = field + added.difference, spin + added.angular
    solution = ReactionSolution(model, state, unit, field, spin, refine=refine)
    torque = (
        prescribed_torques(model, t_s, state, solution, noncentral_acceleration) if model.prescriptions else np.empty(0)
    )
    reaction = solution.reaction(torque)
    place = as_vectors(field + solution.translation_from_reactions(reaction))
    angular = solution.angular_accelerations(reaction, torque)
    return Accelerations(model.weight @ place, angular, place, as_vectors(reaction), torque)
