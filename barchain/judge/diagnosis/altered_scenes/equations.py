"""Wrong terms in the equations, which no scene describes; NumPy's reference simulates them."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from barchain.judge.diagnosis.altered_scenes.gravity import SECTION as GRAVITY
from barchain.judge.diagnosis.altered_scenes.gravity import AddedGradientTorque, with_effect
from barchain.judge.diagnosis.altered_scenes.loads import SECTION as LOADS
from barchain.judge.diagnosis.mistake import SceneMistake
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.model.effect import ChainEffect, EffectAccelerations
from scenarios.toml.effect_tables import slender_inertia

if TYPE_CHECKING:
    from barchain.judge.diagnosis.mistake import ModelChange
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import EffectState

TURN = 2.0 * math.pi


@final
@dataclass(frozen=True)
class SpringJumps(ChainEffect):
    """Torques that springs lose where the angle between two bars is wrapped to half a turn either way."""

    springs: JointSpringDamperEffect
    from_rest: bool
    """Whether the angle from the rest angle is wrapped, not the angle between the bars"""
    name = "wrapped springs"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Torques of the whole turns that are lost."""
        del mode
        between = np.diff(at.state.angle_rad) - (self.springs.rest_rad if self.from_rest else 0.0)
        torque = -self.springs.stiffness_N_m_rad * TURN * np.round(between / TURN)
        on_bars = np.zeros(at.model.bars)
        on_bars[:-1] += torque
        on_bars[1:] -= torque
        return EffectAccelerations(0j, at.zero_acceleration, on_bars / at.model.inertia_kg_m2)


@final
@dataclass(frozen=True)
class CancelledDragTorque(ChainEffect):
    """Cancels the torque of the drag."""

    drag: DragEffect
    name = "cancelled torque of drag"

    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Torque over moment of inertia with the opposite sign; no force."""
        del mode
        whole = self.drag.accelerations(at, None)
        return EffectAccelerations(0j, at.zero_acceleration, -whole.angular)


def beside(kind: type[ChainEffect], added: object) -> ModelChange:
    """Model with one more effect, made of its effect of a kind; a model without that effect stays as it is."""

    def change(model: ChainModel) -> ChainModel:
        found = next((effect for effect in model.effects if isinstance(effect, kind)), None)
        if found is None:
            return model
        return dataclasses.replace(model, effects=(*model.effects, added(found)))  # type: ignore[operator]

    return change


def slender_gradient(model: ChainModel) -> ChainModel:
    """Model whose gravity gradient turns slender bars of the same masses and lengths."""
    slender = np.array([slender_inertia(m, size) for m, size in zip(model.mass_kg, model.length_m, strict=True)])
    share = slender / model.inertia_kg_m2 - 1.0
    if not np.any(np.abs(share) > np.finfo(float).eps):
        return model
    return with_effect(AddedGradientTorque(share), gradient=True)(model)


MISTAKES = (
    *(
        SceneMistake(
            f"springs-wrapped{name}",
            f"the springs' angles {words}are wrapped to half a turn either way",
            LOADS,
            model=beside(JointSpringDamperEffect, lambda springs, rest=rest: SpringJumps(springs, rest)),
        )
        for name, words, rest in (("", "", False), ("-from-rest", "from their rest ", True))
    ),
    SceneMistake(
        "drag-without-torque", "the torque of the drag is missing", LOADS, model=beside(DragEffect, CancelledDragTorque)
    ),
    SceneMistake(
        "gradient-of-slender-bars",
        "the torque of the gravity gradient is that of slender bars, without the given moments of inertia",
        GRAVITY,
        model=slender_gradient,
    ),
)
