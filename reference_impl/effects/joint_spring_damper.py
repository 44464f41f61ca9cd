"""Rotational spring and damper in every joint: torque k (bent - rest) + c bent' on the bar before the joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from reference_impl.model.effect import ChainEffect, EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import ChainProperties


def turned_by(torque: Array, at: EffectState) -> EffectAccelerations:
    """Accelerations by torques (N-1,) N m on the first bar of each joint, and the opposite ones on the second."""
    on_bars = np.zeros_like(at.zero_angular)
    on_bars[..., :-1] += torque
    on_bars[..., 1:] -= torque
    return EffectAccelerations(0j, at.zero_acceleration, on_bars / at.model.inertia_kg_m2)


@final
@dataclass(frozen=True)
class JointSpringDamperEffect(ChainEffect):
    """Rotational springs and dampers of all joints."""

    stiffness_N_m_rad: Array
    """(N-1,)"""
    damping_N_m_s_rad: Array
    """(N-1,)"""
    rest_rad: Array
    """(N-1,)"""

    name = "joint_spring_damper"
    central = True
    internal = True
    isotropic = True

    @property
    def potential(self) -> bool:  # type: ignore[override]
        """True without damping."""
        return not np.any(self.damping_N_m_s_rad)

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Equal and opposite torques on both bars of each joint."""
        del mode
        torque = self.torque(at.state.angle_rad, at.rate)
        return turned_by(torque, at)

    def torque(self, angle_rad: Array, rate_rad_s: Array) -> Array:
        """Torque (..., N-1) on the first bar of each joint, N m."""
        bent = np.diff(angle_rad, axis=-1) - self.rest_rad
        found: Array = self.stiffness_N_m_rad * bent + self.damping_N_m_s_rad * np.diff(rate_rad_s, axis=-1)
        return found

    def energy(self, model: ChainProperties, com_m: Array, angle_rad: Array) -> Array:
        """Energy of the springs, (n,) J."""
        del model, com_m
        bent = np.diff(angle_rad, axis=-1) - self.rest_rad
        total: Array = 0.5 * (bent * bent) @ self.stiffness_N_m_rad
        return total
