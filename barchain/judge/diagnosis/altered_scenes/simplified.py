"""Scenes that an engine simplifies: one value for all bars, one frame for all rotations, one density."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from adapters.common.initial_state import initial_state
from barchain.judge.diagnosis.altered_scenes.bodies import SECTION as BODIES
from barchain.judge.diagnosis.altered_scenes.changes import part
from barchain.judge.diagnosis.altered_scenes.loads import SECTION as LOADS
from barchain.judge.diagnosis.altered_scenes.loads import SPRINGS, each, single, with_effects
from barchain.judge.diagnosis.mistake import SceneMistake
from scenarios import Actuator, Axes, Frame

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.mistake import SceneChange
    from scenarios import Scene

LEVEL_M = 1e15
"""Scale height of an atmosphere whose density is the same at all heights"""


def first_for_all(field: str) -> Callable[[Any], tuple[float, ...]]:
    """The first of several values, for all."""
    return lambda part_: getattr(part_, field)[:1] * len(getattr(part_, field))


def all_as_first(field: str) -> SceneChange:
    """Bars that all have the first bar's value."""
    return part("chain", **{field: lambda scene: first_for_all(field)(scene.chain)})


def rest_at_start(scene: Scene) -> Scene:
    """Springs that are at rest at t = 0."""
    angle = initial_state(scene).angle_rad
    rest = tuple((angle[1:] - angle[:-1]).tolist())
    return single("joint_spring_damper", rest_rad=lambda _: rest)(scene)


def density_of_start(scene: Scene) -> Scene:
    """The density at the initial height, at all heights."""
    drag = scene.effects.drag
    if drag is None:
        return scene
    height_m = scene.radius0_m - scene.central_body.radius_m
    density = drag.density_kg_m3 * math.exp((drag.altitude_m - height_m) / drag.scale_height_m)
    return single("drag", density_kg_m3=lambda _: density, scale_height_m=lambda _: LEVEL_M)(scene)


def frozen(name: str) -> SceneChange:
    """Pushes in a bar's axes whose direction stays as at t = 0."""

    def change(scene: Scene) -> Scene:
        if not getattr(scene.effects, name):
            return scene
        angle = initial_state(scene).angle_rad
        pushes = tuple(
            dataclasses.replace(p, axes=Axes.INERTIAL, direction_rad=p.direction_rad + float(angle[p.bar - 1]))
            if p.axes is Axes.BODY
            else p
            for p in getattr(scene.effects, name)
        )
        return with_effects(scene, **{name: pushes})

    return change


def distance_from_surface(scene: Scene) -> Scene:
    """Third bodies whose distance counts from the surface of the central body."""
    return each("third_body", distance_m=lambda b: b.distance_m + scene.central_body.radius_m)(scene)


def rate_without_own_mass(scene: Scene) -> Scene:
    """Third bodies whose rate follows from the central body's gravity alone."""
    mu = scene.central_body.mu_m3_s2
    return each("third_body", rate_rad_s=lambda b: math.sqrt(mu / b.distance_m**3))(scene)


SIMPLIFIED: tuple[tuple[str, str, str, SceneChange], ...] = (
    *(
        (f"first-{word}-for-all", f"the bars all have the first bar's {word}", BODIES, all_as_first(field))
        for word, field in (("mass", "mass_kg"), ("length", "length_m"), ("moment-of-inertia", "inertia_kg_m2"))
    ),
    *(
        (f"{name}-first-width-for-all", f"the {words} takes the first bar's width for all", LOADS,
         single(effect, width_m=first_for_all("width_m")))
        for name, words, effect in (("drag", "drag", "drag"), ("sunlight", "solar pressure", "solar_pressure"))
    ),
    ("springs-first-for-all", "the joints all have the first joint's spring and damper", LOADS,
     single("joint_spring_damper", **{field: first_for_all(field) for field in SPRINGS})),
    ("springs-rest-at-start", "the springs are at rest at t = 0", LOADS, rest_at_start),
    ("springs-per-degree", "the springs' stiffness is taken per degree", LOADS,
     single("joint_spring_damper", stiffness_N_m_rad=lambda e: tuple(map(math.degrees, e.stiffness_N_m_rad)))),
    ("drag-level-density", "the density is the same at all heights", LOADS,
     single("drag", scale_height_m=lambda _: LEVEL_M)),
    ("drag-density-of-start", "the density is always that at the initial height", LOADS, density_of_start),
    ("drag-tenfold-height", "the scale height is taken as that of a tenfold density", LOADS,
     single("drag", scale_height_m=lambda e: e.scale_height_m / math.log(10.0))),
    ("third-body-distance-from-surface", "the third body's distance counts from the surface", LOADS,
     distance_from_surface),
    ("third-body-rate-without-own-mass", "the third body's rate lacks its own mass", LOADS, rate_without_own_mass),
    *(
        (f"{name}-frozen-axes", f"the {name}'s direction stays that of the bar at t = 0", LOADS, frozen(name))
        for name in ("thrust", "impulse")
    ),
    *(
        (f"rotation-all-{name}", f"the prescribed rotations all {words}", LOADS,
         each("prescribed_rotation", **{field: lambda _, value=value: value}))
        for name, words, field, value in (
            ("inertial", "count from inertial axes", "frame", Frame.INERTIAL),
            ("horizontal", "count from the local horizontal", "frame", Frame.LOCAL_HORIZONTAL),
            ("external", "have torques from outside", "actuator", Actuator.EXTERNAL),
        )
    ),
    ("rotation-from-the-start", "the prescribed rotation begins at t = 0", LOADS,
     each("prescribed_rotation", start_s=lambda _: 0.0)),
)  # fmt: skip
MISTAKES = tuple(SceneMistake(name, words, section, change) for name, words, section, change in SIMPLIFIED)
