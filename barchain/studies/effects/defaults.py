"""Default parameters of natural effects that a scene does not have, for the Earth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from barchain.studies.effects.atmosphere import HIGHEST_M, SOURCE, caveat, layer_at, standard_drag
from scenarios import Gravity, Oblateness
from scenarios.toml.effect_tables import EARTH_J2, SUNLIGHT_PA, SolarPressureTable, ThirdBodyTable
from scenarios.toml.resolve import resolve_drag, resolve_solar_pressure, resolve_third_body
from scenarios.toml.scene_tables import EARTH_MU_M3_S2, EARTH_RADIUS_M

if TYPE_CHECKING:
    from typing import Literal

    from barchain.studies.effects.altitude_range import Heights
    from scenarios import Scene

EARTH_SLACK = 0.01  # the Earth's radius is given to less than that, whichever of its radii is meant


class NoDefaultError(ValueError):
    """An effect has no sensible default in this scene; the message gives the reason."""


@dataclass(frozen=True)
class Default:
    """An effect that a scene does not call for."""

    value: Any
    """Of the scene's `Effects`"""
    said: str
    """Assumption, in words"""
    caveat: str = ""
    """Limit of the assumption in this scene, in a sentence"""
    width_m: tuple[float, ...] = ()
    """Width of each bar that it was taken for; empty where the width has no influence"""


def need_earth(scene: Scene) -> None:
    """Reject another central body for the Earth's air, flattening, Moon and Sun."""
    body = scene.central_body
    pairs = ((body.mu_m3_s2, EARTH_MU_M3_S2), (body.radius_m, EARTH_RADIUS_M))
    if any(abs(given / earth - 1.0) > EARTH_SLACK for given, earth in pairs):
        raise NoDefaultError("the defaults are the Earth's, and this scene has another body: name the effect in it")


def need_pull(scene: Scene) -> None:
    """Reject third bodies and oblateness where there is no central body."""
    if scene.effects.gravity is Gravity.NONE:
        raise NoDefaultError('the central body does not pull (gravity = "none")')


def widths_m(scene: Scene, width_m: float | None) -> tuple[float, ...]:
    """Width of each bar: the given one, or that of the scene's own drag or sunlight.

    Raises
    ------
    NoDefaultError
        Without either: drag and sunlight are proportional to the width, and a bar's length does not tell it.
    """
    if width_m is not None:
        return (width_m,) * scene.bars
    known = scene.effects.drag or scene.effects.solar_pressure
    if known is None:
        raise NoDefaultError("no conclusion without a width of the bars; give it by --width")
    return known.width_m


def default_oblateness(scene: Scene) -> Default:
    """The Earth's J2."""
    need_earth(scene)
    need_pull(scene)
    return Default(Oblateness(EARTH_J2, scene.central_body.radius_m), f"J2 = {EARTH_J2:g}")


def default_third_body(scene: Scene, body: Literal["moon", "sun"]) -> Default:
    """Moon or Sun at longitude 0."""
    need_earth(scene)
    need_pull(scene)
    try:
        return Default(
            resolve_third_body(ThirdBodyTable(body=body), scene.central_body, scene.radius0_m), "at longitude 0"
        )
    except ValueError as error:
        raise NoDefaultError(str(error)) from None


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
    drag = resolve_drag(standard_drag(layer, list(width)), scene.bars)
    return Default(drag, said, caveat(layer, heights), width)


def default_solar_pressure(scene: Scene, width_m: float | None = None) -> Default:
    """Sunlight from longitude 0 on black bars, with the Earth's shadow."""
    need_earth(scene)
    width = widths_m(scene, width_m)
    table = SolarPressureTable(width_m=list(width))
    said = f"{SUNLIGHT_PA:g} Pa from longitude 0, black, with the shadow"
    return Default(resolve_solar_pressure(table, scene.bars), said, width_m=width)
