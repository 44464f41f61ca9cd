"""Keys of a scene that an engine ignores: it takes their defaults, or the Earth's values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.judge.diagnosis.altered_scenes.loads import SECTION, each, single
from barchain.judge.diagnosis.mistake import SceneMistake
from scenarios.toml.effect_tables import EARTH_J2, THIRD_BODIES, DragTable, SolarPressureTable

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.mistake import SceneChange
    from scenarios import Scene


def default(table: type[Any], field: str) -> Callable[[Any], Any]:
    """Default of a key, whatever the effect is."""
    value = table.model_fields[field].default
    return lambda _: value


def usual(number: int) -> Callable[[Any], float]:
    """Gravitational parameter (0) or distance (1) of the Moon or the Sun; of another body its own."""
    own = ("mu_m3_s2", "distance_m")[number]
    return lambda body: THIRD_BODIES[body.name][number] if body.name in THIRD_BODIES else getattr(body, own)


def radius_of_body(scene: Scene) -> Scene:
    """Scene whose oblateness counts from the central body's radius."""
    return single("oblateness", radius_m=lambda _: scene.central_body.radius_m)(scene)


COEFFICIENTS = ("normal_coefficient", "tangential_coefficient")
IGNORED: tuple[tuple[str, str, SceneChange], ...] = (
    ("oblateness-of-earth", "the oblateness is the Earth's", single("oblateness", j2=lambda _: EARTH_J2)),
    ("oblateness-radius-of-body", "the oblateness counts from the central body's radius", radius_of_body),
    (
        "drag-default-coefficients",
        "the drag's coefficients are the defaults",
        single("drag", **{field: default(DragTable, field) for field in COEFFICIENTS}),
    ),
    *(
        (f"drag-default-{name}", f"the drag's {name} coefficient is the default",
         single("drag", **{f"{name}_coefficient": default(DragTable, f"{name}_coefficient")}))
        for name in ("normal", "tangential")
    ),
    (
        "drag-rotation-of-earth",
        "the atmosphere turns as the Earth's",
        single("drag", rotation_rad_s=default(DragTable, "rotation_rad_s")),
    ),
    (
        "sunlight-default-pressure",
        "the pressure of light is the default",
        single("solar_pressure", pressure_Pa=default(SolarPressureTable, "pressure_Pa")),
    ),
    (
        "sunlight-default-rate",
        "the Sun's direction turns at the default rate",
        single("solar_pressure", sun_rate_rad_s=default(SolarPressureTable, "sun_rate_rad_s")),
    ),
    ("third-body-default-mu", "the third body's gravitational parameter is the usual one",
     each("third_body", mu_m3_s2=usual(0))),
    ("third-body-default-distance", "the third body's distance is the usual one",
     each("third_body", distance_m=usual(1))),
)  # fmt: skip
MISTAKES = tuple(SceneMistake(name, words, SECTION, change) for name, words, change in IGNORED)
