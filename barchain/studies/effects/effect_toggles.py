"""Effects of a scene that can be switched, each with the scene in which it is."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from barchain.studies.effects.altitude_range import expected
from barchain.studies.effects.defaults import (
    Default,
    NoDefaultError,
    default_drag,
    default_oblateness,
    default_solar_pressure,
    default_third_body,
)
from reports.tables.effects import EffectKind
from scenarios import Effects, Gravity
from scenarios.toml.checks import SLENDER_SLACK

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from barchain.studies.effects.altitude_range import Heights
    from scenarios import Scene

DESIGN = ("joint_spring_damper", "thrust", "impulse")
"""Effects without a default: they are the design's, not nature's. A prescribed rotation is none of them: it is the task
of the scene, and nobody can leave it out."""
TITLES = {
    "oblateness": "Oblateness (J2)",
    "third_body.moon": "Moon",
    "third_body.sun": "Sun",
    "drag": "Drag",
    "solar_pressure": "Solar pressure",
    "solar_pressure.shadow": "Shadow",
    "joint_spring_damper": "Joint springs and dampers",
    "thrust": "Thrust",
    "impulse": "Impulse",
}
IN_SCENE = "as the scene has it"


@dataclass(frozen=True)
class Switch:
    """One effect, and the scene with it switched."""

    effect: str
    title: str
    kind: EffectKind
    on: bool
    """Whether the scene as it is has it"""
    said: str
    """Assumption on the effect, in words"""
    scene: Scene | None
    """The scene with it switched on, or off; None if that can't be"""
    part: Effects | None = None
    """The effect by itself, under the scene's own gravity: what its push is told from; None if it pushes nothing"""
    reason: str = ""
    """Why it can't be switched"""
    caveat: str = ""
    """Limit of its default in this scene"""
    width_m: tuple[float, ...] = ()
    """Width of each bar where the effect depends on it"""


def switches(scene: Scene, heights: Heights | None = None, width_m: float | None = None) -> tuple[Switch, ...]:
    """All effects of a scene: other models of gravity, nature's on or off, the design's where they are on.

    Parameters
    ----------
    scene : Scene
    heights : Heights, optional
        Between which it runs; by default those of its first orbit as of two bodies.
    width_m : float, optional
        Of every bar, for drag and sunlight that the scene does not have, m.
    """
    return (*gravities(scene), *nature(scene, heights or expected(scene), width_m), *design(scene))


def switched(scene: Scene, **changes: Any) -> Scene:
    """Scene with other effects."""
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **changes))


def alone(scene: Scene, **called: Any) -> Effects:
    """Effects that are nothing but the scene's gravity and one more."""
    return Effects(scene.effects.gravity, **called)


def gravities(scene: Scene) -> Iterator[Switch]:
    """Other models of gravity; that without any for what is not bound."""
    own = scene.effects.gravity
    for model in Gravity:
        if model is own or (model is Gravity.NONE and scene.bound):
            continue
        reason = why_not_gravity(scene, model)
        yield Switch(
            f"gravity.{model}", f"Gravity {model}", EffectKind.GRAVITY, False, f"instead of {own}",
            None if reason else switched(scene, gravity=model), None if reason else Effects(model), reason,
        )  # fmt: skip


def why_not_gravity(scene: Scene, model: Gravity) -> str:
    """Why a scene can't have a model of gravity; empty if it can."""
    effects, chain = scene.effects, scene.chain
    if model is Gravity.NONE and (effects.oblateness or effects.third_body):
        return "the scene has fields besides the central body's, which need its pull"
    bars = zip(chain.mass_kg, chain.length_m, chain.inertia_kg_m2, strict=True)
    for j, (mass, length, inertia) in enumerate(bars, start=1):
        slender = mass * length * length / 12.0
        if model is Gravity.SLENDER and abs(inertia - slender) > SLENDER_SLACK * slender:
            return f"bar {j} is not uniform: its moment of inertia is {inertia:g} kg m², a slender bar's {slender:g}"
    return ""


def nature(scene: Scene, heights: Heights, width_m: float | None) -> Iterator[Switch]:
    """Nature's effects: off where they are on, by default where they are off."""
    yield one(scene, "oblateness", default_oblateness)
    yield from third_bodies(scene)
    yield one(scene, "drag", functools.partial(default_drag, heights=heights, width_m=width_m))
    yield one(scene, "solar_pressure", functools.partial(default_solar_pressure, width_m=width_m))
    if scene.effects.solar_pressure:
        yield shadow(scene)


def one(scene: Scene, effect: str, default: Callable[[Scene], Default]) -> Switch:
    """Effect that a scene has once or not."""
    title, own = TITLES[effect], getattr(scene.effects, effect)
    if own:
        part = alone(scene, **{effect: own})
        return Switch(
            effect, title, EffectKind.NATURE, True, IN_SCENE, switched(scene, **{effect: None}), part,
            width_m=getattr(own, "width_m", ()),
        )  # fmt: skip
    try:
        taken = default(scene)
    except NoDefaultError as error:
        return Switch(effect, title, EffectKind.NATURE, False, "", None, None, str(error))
    added = {effect: taken.value}
    return Switch(
        effect, title, EffectKind.NATURE, False, taken.said, switched(scene, **added), alone(scene, **added),
        caveat=taken.caveat, width_m=taken.width_m,
    )  # fmt: skip


def third_bodies(scene: Scene) -> Iterator[Switch]:
    """Each body that is there, and Moon and Sun where they are not."""
    bodies = scene.effects.third_body
    for k, body in enumerate(bodies):
        same = [b for b in bodies[:k] if b.name == body.name]
        effect = f"third_body.{body.name}" + (f".{len(same) + 1}" if same else "")
        rest = bodies[:k] + bodies[k + 1 :]
        title = TITLES.get(effect, f"Third body ({effect.removeprefix('third_body.')})")
        part = alone(scene, third_body=(body,))
        yield Switch(effect, title, EffectKind.NATURE, True, IN_SCENE, switched(scene, third_body=rest), part)
    yield from (missing_body(scene, name) for name in ("moon", "sun") if name not in {b.name for b in bodies})


def missing_body(scene: Scene, name: Any) -> Switch:
    """Moon or Sun that a scene does not have."""
    effect = f"third_body.{name}"
    try:
        taken = default_third_body(scene, name)
    except NoDefaultError as error:
        return Switch(effect, TITLES[effect], EffectKind.NATURE, False, "", None, None, str(error))
    more = switched(scene, third_body=(*scene.effects.third_body, taken.value))
    part = alone(scene, third_body=(taken.value,))
    return Switch(effect, TITLES[effect], EffectKind.NATURE, False, taken.said, more, part)


def shadow(scene: Scene) -> Switch:
    """The shadow in sunlight that is there."""
    light = scene.effects.solar_pressure
    assert light is not None
    other = dataclasses.replace(light, shadow=not light.shadow)
    effect = "solar_pressure.shadow"
    return Switch(
        effect, TITLES[effect], EffectKind.NATURE, light.shadow, "cylinder, edges found as events",
        switched(scene, solar_pressure=other), width_m=light.width_m,
    )  # fmt: skip


def design(scene: Scene) -> Iterator[Switch]:
    """The design's effects that are on, all of a kind at once."""
    for effect in DESIGN:
        own = getattr(scene.effects, effect)
        if not own:
            continue
        off, pushes = (() if isinstance(own, tuple) else None), effect in ("joint_spring_damper", "thrust")
        part = alone(scene, **{effect: own}) if pushes else None
        said = f"{len(own)} of them" if isinstance(own, tuple) and len(own) > 1 else IN_SCENE
        yield Switch(effect, TITLES[effect], EffectKind.DESIGN, True, said, switched(scene, **{effect: off}), part)
