"""Wrong angles of effects: in the other unit, or left out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from barchain.judge.diagnosis.altered_scenes.loads import SECTION, each, single, times
from barchain.judge.diagnosis.mistake import SceneMistake

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.mistake import SceneChange

DEGREE = math.pi / 180.0
EFFECT_ANGLES: tuple[tuple[str, str, Callable[..., SceneChange], str, str], ...] = (
    ("springs-rest", "the rest angles of the joints' springs are", single, "joint_spring_damper", "rest_rad"),
    ("thrust-direction", "the thrust's direction is", each, "thrust", "direction_rad"),
    ("impulse-direction", "the impulse's direction is", each, "impulse", "direction_rad"),
    ("third-body-longitude", "the third body's longitude is", each, "third_body", "longitude_rad"),
    ("sun-longitude", "the Sun's longitude is", single, "solar_pressure", "sun_longitude_rad"),
    ("rotation-amplitude", "the prescribed rotation's angle is", each, "prescribed_rotation", "amplitude_rad"),
)
"""Angles of effects: name, subject and verb, kind of change, effect and field"""


FACTORS = (
    ("in-degrees", "in degrees where radians are meant", 1.0 / DEGREE),
    ("in-radians", "in radians where degrees are meant", DEGREE),
    ("zero", "zero", 0.0),
)
MISTAKES = tuple(
    SceneMistake(f"{name}-{which}", f"{subject} {words}", SECTION, times(change, effect, field, factor))
    for name, subject, change, effect, field in EFFECT_ANGLES
    for which, words, factor in FACTORS
)
