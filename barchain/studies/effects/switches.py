"""Effects of a scene that can be switched, each with the scene in which it is.

Natural effects that a scene does not have get default parameters, for the Earth.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from barchain.studies.effects.default_air import (
    HIGHEST_M,
    SOURCE,
    caveat,
    expected_heights,
    layer_at,
)
from reports.results.effects import EffectKind
from scenarios import Drag, Effects, Gravity, Oblateness, SolarPressure
from scenarios.toml.checks import SLENDER_SLACK
from scenarios.toml.effect_tables import EARTH_J2, SUNLIGHT_PA, DragTable, SolarPressureTable, ThirdBodyTable
from scenarios.toml.resolve import converted, resolve_third_body
from scenarios.toml.scene_tables import EARTH_MU_M3_S2, EARTH_RADIUS_M

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Literal

    from barchain.studies.effects.default_air import Heights
    from scenarios import Scene

DESIGN = ("joint_spring_damper", "joint_torque", "thrust", "impulse")
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
    "joint_torque": "Motors in joints",
    "thrust": "Thrust",
    "impulse": "Impulse",
}
IN_SCENE = "as the scene has it"
EARTH_SLACK = 0.01  # the Earth's radius is given to less than that, whichever of its radii is meant


@dataclass(frozen=True)
class Switch:
    """One effect, and the scene with it switched."""

    effect: str
    title: str
    kind: EffectKind
    on: bool
    """Whether the scene as it is has it"""
    said: str = ""
    """Assumption on the effect, in words"""
    scene: Scene | None = None
    """The scene with it switched on, or off; None if that can't be"""
    part: Effects | None = None
    """The effect by itself, under the scene's own gravity: what its push is told from; None if it pushes nothing"""
    reason: str = ""
    """Why it can't be switched"""
    caveat: str = ""
    """Limit of its default in this scene"""
    width_m: tuple[float, ...] = ()
    """Width of each bar where the effect depends on it"""


class NoDefaultError(ValueError):
    """An effect has no sensible default in this scene; the message gives the reason."""


Default = tuple[Any, dict[str, Any]]
"""An effect that a scene does not call for: its value in the scene's `Effects`, and what its switch says of it"""


def need_earth(scene: Scene, *, pull: bool = False) -> None:
    """Reject another central body for the Earth's air, flattening, Moon and Sun, and where asked one without a pull."""
    body = scene.central_body
    pairs = ((body.mu_m3_s2, EARTH_MU_M3_S2), (body.radius_m, EARTH_RADIUS_M))
    if any(abs(given / earth - 1.0) > EARTH_SLACK for given, earth in pairs):
        raise NoDefaultError("the defaults are the Earth's, and this scene has another body: name the effect in it")
    if pull and scene.effects.gravity is Gravity.NONE:
        raise NoDefaultError('the central body does not pull (gravity = "none")')


def widths_m(scene: Scene, width_m: float | None) -> tuple[float, ...]:
    """Width of each bar: the given one, or that of the scene's own drag or sunlight.

    Raises
    ------
    NoDefaultError
        Without either: drag and sunlight are proportional to the width, and a bar's length does not tell it. Both
        are those of bars whose centres of mass are midway, and no body's.
    """
    if scene.chain.bodies:
        raise NoDefaultError("drag and sunlight act along bars, and the chain has an end body")
    if scene.chain.com_share:
        raise NoDefaultError("drag and sunlight need bars whose centres of mass are midway between their ends")
    if width_m is not None:
        return (width_m,) * scene.bars
    known = scene.effects.on_faces
    if not known:
        raise NoDefaultError("no conclusion without a width of the bars; give it by --width")
    return known[0].width_m


def default_oblateness(scene: Scene) -> Default:
    """The Earth's J2."""
    need_earth(scene, pull=True)
    return Oblateness(EARTH_J2, scene.central_body.radius_m), {"said": f"J2 = {EARTH_J2:g}"}


def default_third_body(scene: Scene, body: Literal["moon", "sun"]) -> Default:
    """Moon or Sun at longitude 0."""
    need_earth(scene, pull=True)
    try:
        found = resolve_third_body(ThirdBodyTable(body=body), scene.central_body, scene.radius0_m)
    except ValueError as error:
        raise NoDefaultError(str(error)) from None
    return found, {"said": "at longitude 0"}


def default_drag(scene: Scene, heights: Heights, width_m: float | None = None) -> Default:
    """Standard air at the lowest altitude of the run, where drag is strongest by far."""
    need_earth(scene)
    lowest_km = heights.lowest_m / 1e3
    if heights.lowest_m > HIGHEST_M:
        raise NoDefaultError(
            f"{SOURCE}, has no air at the run's lowest height of {lowest_km:.0f} km (none is taken above "
            f"{HIGHEST_M / 1e3:.0f} km)"
        )
    width = widths_m(scene, width_m)
    layer = layer_at(heights.lowest_m)
    said = (
        f"{layer.density_kg_m3:g} kg/m³ at {layer.base_km:g} km, scale height {layer.scale_height_km:g} km ({SOURCE}, "
        f"the entry of the lowest height of the run without drag, {lowest_km:.1f} km); C_n = C_t = 2"
    )
    air = DragTable(
        density_kg_m3=layer.density_kg_m3, altitude_m=1e3 * layer.base_km, scale_height_m=1e3 * layer.scale_height_km,
        width_m=list(width),
    )  # fmt: skip
    return converted(Drag, air, scene.bars), {"said": said, "caveat": caveat(layer, heights), "width_m": width}


def default_solar_pressure(scene: Scene, width_m: float | None = None) -> Default:
    """Sunlight from longitude 0 on black bars, with the Earth's shadow."""
    need_earth(scene)
    width = widths_m(scene, width_m)
    light = converted(SolarPressure, SolarPressureTable(width_m=list(width)), scene.bars)
    return light, {"said": f"{SUNLIGHT_PA:g} Pa from longitude 0, black, with the shadow", "width_m": width}


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
    return (*gravities(scene), *nature(scene, heights or expected_heights(scene), width_m), *design(scene))


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
        other: dict[str, Any] = {} if reason else {"scene": switched(scene, gravity=model), "part": Effects(model)}
        kind, said = EffectKind.GRAVITY, f"instead of {own}"
        yield Switch(f"gravity.{model}", f"Gravity {model}", kind, on=False, said=said, reason=reason, **other)


def why_not_gravity(scene: Scene, model: Gravity) -> str:
    """Why a scene can't have a model of gravity; empty if it can."""
    effects, chain = scene.effects, scene.chain
    if model is Gravity.NONE and (effects.oblateness or effects.third_body):
        return "the scene has fields besides the central body's, which need its pull"
    bars = zip(chain.mass_kg, chain.length_m, chain.inertia_kg_m2, strict=True)
    if model is Gravity.SLENDER and chain.com_share:
        return "the bars are not uniform: their centres of mass are not midway between their ends"
    for j, (mass, length, inertia) in enumerate(bars, start=1):
        slender = mass * length * length / 12.0
        if model is Gravity.SLENDER and abs(inertia - slender) > SLENDER_SLACK * slender:
            return f"bar {j} is not uniform: its moment of inertia is {inertia:g} kg m², a slender bar's {slender:g}"
    return ""


def nature(scene: Scene, heights: Heights, width_m: float | None) -> Iterator[Switch]:
    """Nature's effects: off where they are on, by default where they are off; the shadow where there is sunlight."""
    yield one(scene, "oblateness", lambda: default_oblateness(scene))
    yield from third_bodies(scene)
    yield one(scene, "drag", lambda: default_drag(scene, heights, width_m))
    yield one(scene, "solar_pressure", lambda: default_solar_pressure(scene, width_m))
    light = scene.effects.solar_pressure
    if light:
        other = switched(scene, solar_pressure=dataclasses.replace(light, shadow=not light.shadow))
        said = "cylinder, edges found as events"
        yield natural("solar_pressure.shadow", on=light.shadow, said=said, scene=other, width_m=light.width_m)


def natural(effect: str, title: str = "", **of: Any) -> Switch:
    """Switch of one of nature's effects."""
    return Switch(effect, title or TITLES[effect], EffectKind.NATURE, **of)


def one(scene: Scene, effect: str, default: Callable[[], Default]) -> Switch:
    """Effect that a scene has once or not."""
    own = getattr(scene.effects, effect)
    if not own:
        return offered(scene, effect, default)
    without, part = switched(scene, **{effect: None}), alone(scene, **{effect: own})
    return natural(effect, on=True, said=IN_SCENE, scene=without, part=part, width_m=getattr(own, "width_m", ()))


def offered(scene: Scene, effect: str, default: Callable[[], Default]) -> Switch:
    """Effect that a scene does not have, with its default; or why it has none."""
    field = effect.partition(".")[0]
    try:
        value, said = default()
    except NoDefaultError as error:
        return natural(effect, on=False, reason=str(error))
    others = getattr(scene.effects, field)
    more, part = ((*others, value), (value,)) if isinstance(others, tuple) else (value, value)
    return natural(effect, on=False, scene=switched(scene, **{field: more}), part=alone(scene, **{field: part}), **said)


def third_bodies(scene: Scene) -> Iterator[Switch]:
    """Each body that is there, and Moon and Sun where they are not."""
    bodies = scene.effects.third_body
    for k, body in enumerate(bodies):
        same = [b for b in bodies[:k] if b.name == body.name]
        effect = f"third_body.{body.name}" + (f".{len(same) + 1}" if same else "")
        title = TITLES.get(effect, f"Third body ({effect.removeprefix('third_body.')})")
        without = switched(scene, third_body=bodies[:k] + bodies[k + 1 :])
        yield natural(effect, title, on=True, said=IN_SCENE, scene=without, part=alone(scene, third_body=(body,)))
    names: tuple[Literal["moon", "sun"], ...] = ("moon", "sun")
    for name in names:
        if name not in {b.name for b in bodies}:
            yield offered(scene, f"third_body.{name}", partial(default_third_body, scene, name))


def design(scene: Scene) -> Iterator[Switch]:
    """The design's effects that are on, all of a kind at once."""
    for effect in DESIGN:
        own = getattr(scene.effects, effect)
        if not own:
            continue
        off, pushes = (() if isinstance(own, tuple) else None), effect != "impulse"
        part = alone(scene, **{effect: own}) if pushes else None
        said = f"{len(own)} of them" if isinstance(own, tuple) and len(own) > 1 else IN_SCENE
        other = switched(scene, **{effect: off})
        yield Switch(effect, TITLES[effect], EffectKind.DESIGN, on=True, said=said, scene=other, part=part)
