"""One evaluation of the compiled reference, in the shape of the other's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.kernel import layout
from reference_impl.kernel.library import evaluate
from reference_impl.kernel.simulate import set_modes
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.effect import EffectState
from reference_impl.model.joints import NOT_POSITIVE_DEFINITE
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.state import Accelerations, State
from tests.support.joint_roundoff import sums

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel


def compiled_accelerations(model: ChainModel, t_s: float, state: State) -> Accelerations:
    """As :func:`reference_impl.model.relative.accelerations` of a joined state, by compiled code.

    What it has no need to make, the centres' accelerations from the chain's, is put together from its field and
    reactions.
    """
    n, chain = model.bars, layout.compiled_chain(model)
    scratch = layout.workspace_of(chain)
    at = EffectState(model, t_s, state, unit_along(state.angle_rad))
    set_modes(chain, tuple(effect.mode(at) for effect in model.effects))
    y = layout.pack(state.com_m, state.com_velocity_m_s, state.angle_rad, state.rate_rad_s)
    rates = np.zeros_like(y)
    if not evaluate(t_s, y, rates, chain, scratch):
        raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
    field = scratch.bars[[layout.GX, layout.GY]].T
    reaction = scratch.bars[[layout.RX, layout.RY], : n - 1].T.copy()
    tide = field - model.weight @ field
    return Accelerations(
        rates[2 * n + 2 : 2 * n + 4],
        rates[n + 2 : 2 * n + 2],
        tide + sums(reaction)[1] / model.mass_kg[:, None],
        reaction,
        scratch.torque_N_m.copy(),
    )


def with_angles(model: ChainModel, state: State, angle_rad: Array) -> State:
    """The chain of `state` at other angles, its joints closed."""
    return consistent_state(model, state.com_m, state.com_velocity_m_s, angle_rad, state.rate_rad_s)


def refined_reactions(model: ChainModel, state: State) -> Array:
    """Reactions (N-1, 2) by compiled code as they are looked at."""
    chain = layout.refined(layout.compiled_chain(model))
    scratch = layout.workspace_of(chain)
    y = layout.pack(state.com_m, state.com_velocity_m_s, state.angle_rad, state.rate_rad_s)
    if not evaluate(0.0, y, np.zeros_like(y), chain, scratch):
        raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
    found: Array = scratch.bars[[layout.RX, layout.RY], : model.bars - 1].T.copy()
    return found
