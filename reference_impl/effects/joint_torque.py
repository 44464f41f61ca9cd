"""Torque of a motor in a joint, piecewise linear in time: on the joint's second bar, the opposite one on its first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from reference_impl.effects.timed import TimedEffect
from reference_impl.model.effect import EffectAccelerations, EffectState

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import ChainProperties


@final
@dataclass(frozen=True)
class JointTorqueEffect(TimedEffect):
    """Motor; its sizes are in N m."""

    joint: int
    """Counted from 0: between bars `joint` and `joint` + 1"""

    name = "joint_torque"
    central = True
    internal = True
    isotropic = True

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Equal and opposite torques on both bars of the joint."""
        size, inertia, spin = self.size(at, mode), at.model.inertia_kg_m2, at.zero_angular.copy()
        for bar, sign in ((self.joint, -1.0), (self.joint + 1, 1.0)):
            spin[..., bar : bar + 1] = sign * size / inertia[bar]
        return EffectAccelerations(0j, at.zero_acceleration, spin)

    def energy(self, model: ChainProperties, com_m: Array, angle_rad: Array) -> Array:
        """Zeros (n,) J: a motor works, and stores no energy."""
        del model, angle_rad
        return np.zeros(len(com_m))
