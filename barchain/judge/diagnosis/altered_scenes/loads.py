"""Wrong effects: missing, with another sign, or at another point."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

from barchain.judge.diagnosis.mistake import SceneMistake
from scenarios import Actuator, Axes, End, Frame
from scenarios.toml.checks import joint_of_motor

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from scenarios import Scene

    SceneChange = Callable[[Scene], Scene]
    EntryChange = Callable[[Any], Any]

SECTION = "loads"
EFFECTS: dict[str, tuple[str, object]] = {
    "oblateness": ("the oblateness is", None),
    "drag": ("the drag is", None),
    "solar_pressure": ("the solar pressure is", None),
    "joint_spring_damper": ("the springs and dampers of the joints are", None),
    "third_body": ("the third body is", ()),
    "thrust": ("the thrust is", ()),
    "impulse": ("the impulse is", ()),
    "prescribed_rotation": ("the prescribed rotation is", ()),
}
"""Words for each effect, and the value of a scene without it"""


def single(name: str, **changes: EntryChange) -> SceneChange:
    """Change of fields of an effect; a scene without the effect stays as it is."""

    def change(scene: Scene) -> Scene:
        effect = getattr(scene.effects, name)
        if effect is None:
            return scene
        values = {field: value(effect) for field, value in changes.items()}
        return with_effects(scene, **{name: dataclasses.replace(effect, **values)})

    return change


def each(name: str, **changes: EntryChange) -> SceneChange:
    """Change of fields of all effects of a kind."""

    def change(scene: Scene) -> Scene:
        altered = tuple(
            dataclasses.replace(entry, **{field: value(entry) for field, value in changes.items()})
            for entry in getattr(scene.effects, name)
        )
        return with_effects(scene, **{name: altered})

    return change


def times(change: Callable[..., SceneChange], effect: str, field: str, factor: float) -> SceneChange:
    """Change, :func:`single` or :func:`each`, of a number of an effect, or of a tuple of numbers, by a factor."""

    def scaled(entry: Any) -> float | tuple[float, ...]:
        value = getattr(entry, field)
        return tuple(factor * v for v in value) if isinstance(value, tuple) else factor * value

    return change(effect, **{field: scaled})


def with_effects(scene: Scene, **changes: Any) -> Scene:
    """Scene with other effects."""
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **changes))


def missing(name: str, nothing: object) -> SceneChange:
    """Scene without an effect."""

    def change(scene: Scene) -> Scene:
        return with_effects(scene, **{name: nothing})

    return change


def at_both_ends(name: str, size: str, half: EntryChange) -> SceneChange:
    """Thrusts or impulses at the bars' centres: half of each at either end."""

    def change(scene: Scene) -> Scene:
        halves = tuple(
            dataclasses.replace(entry, **{"end": end, size: half(getattr(entry, size))})
            for entry in getattr(scene.effects, name)
            for end in End
        )
        return with_effects(scene, **{name: halves})

    return change


def other_end(entry: Any) -> End:
    """The other end of a bar."""
    return End.LEFT if entry.end is End.RIGHT else End.RIGHT


def other_axes(entry: Any) -> Axes:
    """The other axes of a direction."""
    return Axes.INERTIAL if entry.axes is Axes.BODY else Axes.BODY


def other_frame(entry: Any) -> Frame:
    """The other reference direction of a prescribed angle."""
    return Frame.INERTIAL if entry.frame is Frame.LOCAL_HORIZONTAL else Frame.LOCAL_HORIZONTAL


def other_actuator(entry: Any) -> Actuator:
    """The other source of a prescribed rotation's torque."""
    return Actuator.EXTERNAL if entry.actuator is Actuator.JOINT else Actuator.JOINT


def by_other_actuators(scene: Scene) -> Scene:
    """Scene with the other source of each prescribed rotation's torque, unless a joint would have two motors."""
    altered = each("prescribed_rotation", actuator=other_actuator)(scene)
    motors = [p.bar for p in altered.effects.prescribed_rotation if p.actuator is Actuator.JOINT]
    joints = {joint_of_motor(bar) for bar in motors}
    return altered if len(joints) == len(motors) and scene.bars > 1 else scene


def next_bar(shift: int) -> Callable[[str], SceneChange]:
    """Changes that put thrusts or impulses on another bar, `shift` places on, round the chain."""

    def of(name: str) -> SceneChange:
        def change(scene: Scene) -> Scene:
            altered = tuple(
                dataclasses.replace(entry, bar=(entry.bar - 1 + shift) % scene.bars + 1)
                for entry in getattr(scene.effects, name)
            )
            return with_effects(scene, **{name: altered})

        return change

    return of


def without_body(name: str) -> SceneChange:
    """Scene without one of its third bodies."""

    def change(scene: Scene) -> Scene:
        return with_effects(scene, third_body=tuple(b for b in scene.effects.third_body if b.name != name))

    return change


FORCES = (("kilograms-force", 9.80665), ("pounds-force", 4.4482216152605), ("kilonewtons", 1e3))
SPRINGS = ("stiffness_N_m_rad", "damping_N_m_s_rad", "rest_rad")


def reversed_springs(*fields: str) -> SceneChange:
    """Springs and dampers with values from the last joint to the first."""
    return single("joint_spring_damper", **{f: lambda e, f=f: tuple(reversed(getattr(e, f))) for f in fields})


PUSHES = (("thrust", "force_N", lambda f: tuple(0.5 * v for v in f)), ("impulse", "impulse_N_s", lambda p: 0.5 * p))
CHANGES: tuple[tuple[str, str, SceneChange], ...] = (
    ("oblateness-opposite", "the oblateness has the opposite sign", times(single, "oblateness", "j2", -1.0)),
    ("oblateness-without-3-2", "the oblateness lacks its factor 3/2", times(single, "oblateness", "j2", 1.0 / 1.5)),
    ("oblateness-polar", "the oblateness is that above the pole", times(single, "oblateness", "j2", -2.0)),
    (
        "drag-coefficients-exchanged",
        "the drag's normal and tangential coefficients are exchanged",
        single(
            "drag",
            normal_coefficient=lambda e: e.tangential_coefficient,
            tangential_coefficient=lambda e: e.normal_coefficient,
        ),
    ),
    *(
        (f"third-body-{name}-missing", f"the {words} is missing", without_body(name))
        for name, words in (("moon", "Moon"), ("sun", "Sun"))
    ),
    *(
        (f"{name}-on-{where}-bar", f"the {name} acts on the {where} bar", next_bar(shift)(name))
        for name in ("thrust", "impulse")
        for shift, where in ((1, "next"), (-1, "previous"))
    ),
    (
        "dampers-opposite",
        "the joints' dampers have the opposite sign",
        times(single, "joint_spring_damper", "damping_N_m_s_rad", -1.0),
    ),
    (
        "springs-opposite",
        "the joints' springs have the opposite sign",
        times(single, "joint_spring_damper", "stiffness_N_m_rad", -1.0),
    ),
    ("springs-in-reversed-order", "the springs and dampers are in reversed order", reversed_springs(*SPRINGS)),
    (
        "springs-in-reversed-order-without-rest",
        "the stiffness and damping of the joints are in reversed order",
        reversed_springs(*SPRINGS[:2]),
    ),
    *(
        (f"thrust-in-{unit}", f"the thrust's newtons are taken as {unit}", times(each, "thrust", "force_N", factor))
        for unit, factor in FORCES
    ),
    (
        "sun-backwards",
        "the Sun's direction turns the other way",
        times(single, "solar_pressure", "sun_rate_rad_s", -1.0),
    ),
    (
        "third-body-backwards",
        "the third body moves the other way",
        times(each, "third_body", "rate_rad_s", -1.0),
    ),
    ("drag-atmosphere-at-rest", "the atmosphere is at rest", single("drag", rotation_rad_s=lambda _: 0.0)),
    (
        "drag-halved",
        "the drag has an additional factor 1/2",
        times(single, "drag", "density_kg_m3", 0.5),
    ),
    ("drag-doubled", "the drag lacks its factor 1/2", times(single, "drag", "density_kg_m3", 2.0)),
    (
        "sunlight-opposite",
        "the sunlight comes from the opposite direction",
        single("solar_pressure", sun_longitude_rad=lambda e: e.sun_longitude_rad + math.pi),
    ),
    ("sun-at-rest", "the Sun's direction is constant", single("solar_pressure", sun_rate_rad_s=lambda _: 0.0)),
    ("sunlight-without-shadow", "the shadow is missing", single("solar_pressure", shadow=lambda _: False)),
    ("sunlight-absorbed", "the reflected sunlight is missing", single("solar_pressure", reflectivity=lambda _: 0.0)),
    (
        "springs-missing",
        "the joints' springs are missing",
        times(single, "joint_spring_damper", "stiffness_N_m_rad", 0.0),
    ),
    (
        "dampers-missing",
        "the joints' dampers are missing",
        times(single, "joint_spring_damper", "damping_N_m_s_rad", 0.0),
    ),
    (
        "springs-rest-opposite",
        "the rest angles of the joints' springs have the opposite sign",
        times(single, "joint_spring_damper", "rest_rad", -1.0),
    ),
    (
        "third-body-opposite",
        "the third body is in the opposite direction",
        each("third_body", longitude_rad=lambda e: e.longitude_rad + math.pi),
    ),
    ("third-body-at-rest", "the third body is at rest", each("third_body", rate_rad_s=lambda _: 0.0)),
    ("thrust-at-other-end", "the thrust acts at the bar's other end", each("thrust", end=other_end)),
    ("thrust-in-other-axes", "the thrust's direction counts from the other axes", each("thrust", axes=other_axes)),
    (
        "thrust-opposite",
        "the thrust has the opposite direction",
        each("thrust", direction_rad=lambda e: e.direction_rad + math.pi),
    ),
    ("impulse-at-other-end", "the impulse acts at the bar's other end", each("impulse", end=other_end)),
    ("impulse-in-other-axes", "the impulse's direction counts from the other axes", each("impulse", axes=other_axes)),
    (
        "impulse-opposite",
        "the impulse has the opposite direction",
        each("impulse", direction_rad=lambda e: e.direction_rad + math.pi),
    ),
    *(
        (f"{name}-at-centre", f"the {name} acts at the bar's centre", at_both_ends(name, size, half))
        for name, size, half in PUSHES
    ),
    (
        "rotation-opposite",
        "the prescribed rotation has the opposite sign",
        times(each, "prescribed_rotation", "amplitude_rad", -1.0),
    ),
    (
        "rotation-in-other-frame",
        "the prescribed angle counts from the other direction",
        each("prescribed_rotation", frame=other_frame),
    ),
    (
        "rotation-by-other-actuator",
        "the prescribed rotation's torque has no reaction or a wrong one",
        by_other_actuators,
    ),
)
MISTAKES = (
    *(
        SceneMistake(f"{name.replace('_', '-')}-missing", f"{words} missing", SECTION, missing(name, nothing))
        for name, (words, nothing) in EFFECTS.items()
    ),
    *(SceneMistake(name, words, SECTION, change) for name, words, change in CHANGES),
)
