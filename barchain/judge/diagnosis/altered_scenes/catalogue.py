"""All mistakes in the scene."""

from __future__ import annotations

from barchain.judge.diagnosis.altered_scenes import (
    bodies,
    defaults,
    effect_angles,
    equations,
    events,
    gravity,
    loads,
    simplified,
    start,
)

SCENES = (
    *bodies.MISTAKES,
    *start.MISTAKES,
    *gravity.MISTAKES,
    *loads.MISTAKES,
    *effect_angles.MISTAKES,
    *events.MISTAKES,
    *defaults.MISTAKES,
    *simplified.MISTAKES,
    *equations.MISTAKES,
)
