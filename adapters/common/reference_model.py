"""The reference's model of a scene: its bars, the central body's gravity, prescribed rotations, and on request effects.

The effects themselves are made in `reference_effects`, which is imported only for a scene that has any.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.chain import BarTurn, ChainModel, GravityModel, Prescription
from scenarios import Actuator, Course, Gravity, PrescribedRotation

if TYPE_CHECKING:
    from scenarios import Scene
    from scenarios.effect_types import Turn

POINT_PART: dict[Gravity, GravityModel] = {
    Gravity.NONE: "none",
    Gravity.POINT: "point",
    Gravity.GRADIENT: "gradient",
    Gravity.QUADRUPOLE: "gradient",
    Gravity.SLENDER: "point",
}
"""Model of the central body's gravity in the reference; the remainder of a model is an effect of its own"""


def chain_model(scene: Scene) -> ChainModel:
    """The reference's model of `scene`."""
    model = ChainModel(
        mu_m3_s2=scene.central_body.mu_m3_s2,
        mass_kg=np.array(scene.chain.mass_kg),
        length_m=np.array(scene.chain.length_m),
        inertia_kg_m2=np.array(scene.chain.inertia_kg_m2),
        gravity=POINT_PART[scene.effects.gravity],
        body_radius_m=scene.central_body.radius_m,
        prescriptions=tuple(prescription(p) for p in scene.effects.prescribed_rotation),
        com_share=np.array(scene.chain.com_share) if scene.chain.com_share else None,
    )
    if not scene.effects.beyond_basic:
        return model
    from adapters.common.reference_effects import effects_of, impulses_of

    return dataclasses.replace(
        model,
        effects=effects_of(scene),
        impulses=impulses_of(scene),
        spring_rate_rad_s=scene.spring_rate_rad_s,
    )


def bar_turn(turn: Turn) -> BarTurn:
    """The reference's model of a turn."""
    made = BarTurn(turn.amplitude_rad, turn.duration_s, turn.start_s)
    match turn.course:
        case Course.PAPER:
            return made
        case Course.QUINTIC:
            return dataclasses.replace(made, quintic=True)
        case Course.SPLINE:
            return dataclasses.replace(made, spline_rad=turn.coefficients_rad)


def prescription(p: PrescribedRotation) -> Prescription:
    """The reference's model of a prescribed rotation."""
    neighbour = p.bar - 2 if p.bar > 1 else 1  # counted from 0
    return Prescription(
        bar=p.bar - 1,
        turns=tuple(map(bar_turn, p.turns)),
        frame=p.frame.value,
        reacts_on=neighbour if p.actuator is Actuator.JOINT else None,
    )
