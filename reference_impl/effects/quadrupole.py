"""Gravity up to a bar's second moment: the force that belongs to the gravity-gradient torque of eq. (17).

The force is -grad of U = -(mu J/2r³)(3c² - 1), of the order (l/r)² of gravity. Adding it directly is safe: its rounding
error is negligible relative to that of the tide, which is of the order l/r of gravity. The model's gravity "gradient"
supplies the torque.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from reference_impl.effects import second_moment
from reference_impl.model.complex_vectors import as_complex, unit_along
from reference_impl.model.effect import ChainEffect, EffectAccelerations, EffectState
from reference_impl.model.kinematics import relative_positions

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.effect import ChainProperties


@final
@dataclass(frozen=True)
class QuadrupoleEffect(ChainEffect):
    """Force of the central field on the bars' second moments; the model's gravity is "gradient"."""

    name = "quadrupole"
    potential = True
    isotropic = True

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Force on second moments; the torque is part of gravity "gradient"."""
        del mode
        m = at.model
        pull = second_moment.accelerations(m.mu_m3_s2, at.position_from_body, at.unit, m.gyration2)
        return EffectAccelerations(0j, pull, at.zero_angular)

    def energy(self, model: ChainProperties, com_m: Array, angle_rad: Array) -> Array:
        """Potential energy of the second moments, (n,) J."""
        place = as_complex(com_m)[:, None] + bar_positions(model, angle_rad)
        total: Array = second_moment.potential_energies(
            model.mu_m3_s2, place, unit_along(angle_rad), model.inertia_kg_m2
        ).sum(axis=1)
        return total


def bar_positions(model: ChainProperties, angle_rad: Array) -> ComplexArray:
    """(n, N) positions of the bars relative to the centre of mass, over time."""
    return as_complex(relative_positions(model, angle_rad))
