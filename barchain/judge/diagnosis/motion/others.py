"""Scenes that an engine may have taken for the given one: other ends, axes, orders, models; no amount is fitted."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from adapters.common.initial_state import initial_state
from barchain.judge.diagnosis.motion.changed_loads import choices, other, with_effects
from barchain.judge.diagnosis.motion.changed_pushes import of_motors, of_pushes
from barchain.judge.diagnosis.motion.numbers import KNOWN, body_words
from barchain.judge.diagnosis.motion.set_points import moved_joints
from barchain.judge.diagnosis.motion.words import BODIES, GRAVITY, LOADS
from scenarios import Actuator, Course, Frame, Gravity, SceneError, change_scene
from scenarios.scene import Run
from scenarios.toml.changing import clock_at_start
from scenarios.toml.checks import joint_of_motor
from scenarios.toml.effect_tables import DragTable, SolarPressureTable, slender_inertia

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.judge.diagnosis.motion.changed_loads import Made
    from scenarios import JointTorque, PrescribedRotation, Scene

LEVEL_M = 1e15
"""Scale height of an atmosphere whose density is the same at all heights"""
SPRINGS = (("stiffness_N_m_rad", "stiffness"), ("damping_N_m_s_rad", "damping"), ("rest_rad", "rest angle"))
MODELS = {
    Gravity.NONE: "the gravity is missing",
    Gravity.POINT: "the bars are point masses to gravity, the torque of the gravity gradient is missing",
    Gravity.GRADIENT: "the gravity is that of the paper, a point mass' force with the gradient's torque",
    Gravity.QUADRUPOLE: "the gravity is expanded to the bars' second moments",
    Gravity.SLENDER: "the gravity is that on slender bars",
}


class Other(NamedTuple):
    """Another scene."""

    name: str
    words: str
    """Sentence without a full stop; begins with `the`"""
    section: str
    scene: Scene


def others(scene: Scene) -> Iterator[Other]:
    """Other scenes than the given one."""
    for section, made in (
        (BODIES, of_chain(scene)),
        (GRAVITY, ((f"gravity-{g}", words, with_effects(scene, gravity=g)) for g, words in MODELS.items())),
        (LOADS, of_pushes(scene)),
        (LOADS, of_motors(scene)),
        (LOADS, of_drag(scene)),
        (LOADS, of_light(scene)),
        (LOADS, of_joints(scene)),
        (LOADS, of_set_points(scene)),
        (LOADS, of_clock(scene)),
        (LOADS, of_bodies(scene)),
        (LOADS, of_rotations(scene)),
    ):
        for name, words, new in made:
            if new != scene:
                yield Other(name, words, section, new)


def with_fields(scene: Scene, effect: str, prefix: str, rows: tuple[tuple[str, str, dict[str, Any]], ...]) -> Made:
    """Scenes with other fields of a single effect: ending of the name, words after "the", and values."""
    given = getattr(scene.effects, effect)
    for name, words, values in rows:
        yield f"{prefix}-{name}", f"the {words}", with_effects(scene, **{effect: dataclasses.replace(given, **values)})


def of_chain(scene: Scene) -> Made:
    """Orders of masses, lengths and moments of inertia, and moments of inertia by other formulas."""
    c, n = scene.chain, scene.bars
    mass, length, inertia = c.mass_kg, c.length_m, c.inertia_kg_m2
    slender = tuple(map(slender_inertia, mass, length))
    about_end = tuple(j + m * size**2 / 4.0 for m, size, j in zip(mass, length, inertia, strict=True))
    carried = tuple(j * new / old for j, new, old in zip(inertia, mass[::-1], mass, strict=True))
    for name, words, values in (
        ("masses-in-reversed-order", "masses are in reversed order", (mass[::-1], length, inertia)),
        ("lengths-in-reversed-order", "lengths are in reversed order", (mass, length[::-1], inertia)),
        ("inertias-in-reversed-order", "moments of inertia are in reversed order", (mass, length, inertia[::-1])),
        ("masses-and-inertias-in-reversed-order", "masses and moments of inertia are in reversed order",
         (mass[::-1], length, inertia[::-1])),
        ("masses-reversed-with-inertias", "masses are in reversed order, in the moments of inertia too",
         (mass[::-1], length, carried)),
        ("properties-in-reversed-order", "masses, lengths and moments of inertia are in reversed order",
         (mass[::-1], length[::-1], inertia[::-1])),
        ("mean-masses", "bars all have the mean mass", ((scene.mass_kg / n,) * n, length, inertia)),
        ("mean-lengths", "bars all have the mean length", (mass, (scene.size_m / n,) * n, inertia)),
        ("mean-inertias", "bars all have the mean moment of inertia", (mass, length, (sum(inertia) / n,) * n)),
        ("inertia-about-end", "moments of inertia are those about the bars' ends", (mass, length, about_end)),
        ("inertia-slender", "moments of inertia are those of slender bars, not the given ones",
         (mass, length, slender)),
        ("inertia-of-half-lengths", "moments of inertia are a quarter of the right values, as of half the lengths",
         (mass, length, tuple(0.25 * j for j in inertia))),
        ("inertia-of-twice-the-lengths", "moments of inertia are four times the right values, as of twice the lengths",
         (mass, length, tuple(4.0 * j for j in inertia))),
        ("inertia-slender-about-end", "moments of inertia are those of slender bars about their ends",
         (mass, length, tuple(4.0 * j for j in slender))),
        ("last-mass-for-all", "bars all have the last bar's mass", (mass[-1:] * n, length, inertia)),
        ("last-length-for-all", "bars all have the last bar's length", (mass, length[-1:] * n, inertia)),
        ("last-inertia-for-all", "bars all have the last bar's moment of inertia", (mass, length, inertia[-1:] * n)),
        ("first-mass-for-all", "bars all have the first bar's mass", (mass[:1] * n, length, inertia)),
        ("first-length-for-all", "bars all have the first bar's length", (mass, length[:1] * n, inertia)),
        ("first-inertia-for-all", "bars all have the first bar's moment of inertia", (mass, length, inertia[:1] * n)),
    ):  # fmt: skip
        chain = dataclasses.replace(c, mass_kg=values[0], length_m=values[1], inertia_kg_m2=values[2])
        yield name, f"the {words}", dataclasses.replace(scene, chain=chain)
    for name, words, share in (
        ("midway", "taken midway between the ends", ()),
        ("from-right", "counted from the right ends", tuple(1.0 - share for share in c.com_share)),
        ("reversed", "in reversed order", c.com_share[::-1]),
    ) if c.com_share else ():  # fmt: skip
        chain = dataclasses.replace(c, com_share=share)
        yield f"centres-{name}", f"the bars' centres of mass are {words}", dataclasses.replace(scene, chain=chain)


def of_drag(scene: Scene) -> Made:
    """Drag with other coefficients, densities and widths."""
    d = scene.effects.drag
    if d is None:
        return
    normal, tangential, height_m = d.normal_coefficient, d.tangential_coefficient, scene.orbit.altitude_m
    at_start = d.density_kg_m3 * math.exp((d.altitude_m - height_m) / d.scale_height_m)
    usual = {f: DragTable.model_fields[f].default for f in ("normal_coefficient", "tangential_coefficient")}
    yield "drag-missing", "the drag is missing", with_effects(scene, drag=None)
    yield from with_fields(scene, "drag", "drag", (
        ("coefficients-exchanged", "normal and tangential coefficients of the drag are exchanged",
         {"normal_coefficient": tangential, "tangential_coefficient": normal}),
        ("normal-for-both", "drag has the normal coefficient for both directions", {"tangential_coefficient": normal}),
        ("tangential-for-both", "drag has the tangential coefficient for both directions",
         {"normal_coefficient": tangential}),
        ("default-coefficients", "coefficients of the drag are the defaults", usual),
        *((f"default-{f}", f"{f.partition('_')[0]} coefficient of the drag is the default", {f: v})
          for f, v in usual.items()),
        ("rotation-of-earth", "atmosphere turns as the Earth's",
         {"rotation_rad_s": DragTable.model_fields["rotation_rad_s"].default}),
        ("level-density", "drag has the same density at all heights", {"scale_height_m": LEVEL_M}),
        ("density-of-start", "drag has always the density at the initial height",
         {"density_kg_m3": at_start, "scale_height_m": LEVEL_M}),
        ("density-that-grows", "density of the air grows with the height", {"scale_height_m": -d.scale_height_m}),
        ("tenfold-height", "drag takes the scale height as that of a tenfold density",
         {"scale_height_m": d.scale_height_m / math.log(10.0)}),
        ("first-width-for-all", "drag takes the first bar's width for all", {"width_m": d.width_m[:1] * scene.bars}),
        ("widths-reversed", "widths for the drag are in reversed order", {"width_m": d.width_m[::-1]}),
    ))  # fmt: skip


def of_light(scene: Scene) -> Made:
    """Sunlight with another shadow, reflection, width or pressure."""
    p = scene.effects.solar_pressure
    if p is None:
        return
    usual, own = SolarPressureTable.model_fields, scene.central_body
    oblate = scene.effects.oblateness
    radii = (*KNOWN["radius_m"], *((("the oblateness", oblate.radius_m),) if oblate else ()))
    for whose, radius_m in radii if p.shadow and not scene.effects.drag else ():  # whose heights count from it, too
        body = dataclasses.replace(own, radius_m=radius_m)
        yield (f"shadow-of-radius-{radius_m:g}", f"the radius of the shadow is that of {whose}",
               dataclasses.replace(scene, central_body=body))  # fmt: skip
    yield "sunlight-missing", "the solar pressure is missing", with_effects(scene, solar_pressure=None)
    yield from with_fields(scene, "solar_pressure", "sunlight", (
        ("without-shadow", "shadow is missing", {"shadow": False}),
        ("with-shadow", "sunlight has a shadow that the scene has not", {"shadow": True}),
        ("mirror", "reflectivity is 1", {"reflectivity": 1.0}),
        ("reflected-missing", "reflected sunlight is missing",
         {"reflectivity": 0.0, "pressure_Pa": (1.0 - p.reflectivity) * p.pressure_Pa}),
        ("absorbed-missing", "absorbed sunlight is missing",
         {"reflectivity": 1.0, "pressure_Pa": p.reflectivity * p.pressure_Pa}),
        ("along-the-sun-line", "reflected sunlight pushes along the Sun's line, not along the bar's normal",
         {"reflectivity": 0.0, "pressure_Pa": (1.0 + p.reflectivity) * p.pressure_Pa}),
        ("exchanged", "absorbed and the reflected sunlight are exchanged", {"reflectivity": 1.0 - p.reflectivity}),
        ("opposite", "sunlight comes from the opposite direction",
         {"sun_longitude_rad": p.sun_longitude_rad + math.pi}),
        ("first-width-for-all", "solar pressure takes the first bar's width for all",
         {"width_m": p.width_m[:1] * scene.bars}),
        ("widths-reversed", "widths for the solar pressure are in reversed order", {"width_m": p.width_m[::-1]}),
        ("default-pressure", "pressure of light is the default", {"pressure_Pa": usual["pressure_Pa"].default}),
        ("default-rate", "direction of the Sun turns at the default rate",
         {"sun_rate_rad_s": usual["sun_rate_rad_s"].default}),
    ))  # fmt: skip


def of_joints(scene: Scene) -> Made:
    """Springs and dampers of other joints, with other rest angles."""
    j = scene.effects.joint_spring_damper
    if j is None:
        return
    kind, bent = "joint_spring_damper", np.diff(initial_state(scene).angle_rad)
    order = {f: getattr(j, f)[::-1] for f, _ in SPRINGS}
    first = {f: getattr(j, f)[:1] * (scene.bars - 1) for f, _ in SPRINGS}
    yield "springs-missing", "the springs and dampers of the joints are missing", with_effects(scene, **{kind: None})
    yield from with_fields(scene, kind, "springs", (
        ("rest-at-start", "springs are at rest at t = 0", {"rest_rad": tuple(bent.tolist())}),
        ("rest-from-start", "rest angles count from the angles of the joints at t = 0",
         {"rest_rad": tuple((bent + np.array(j.rest_rad)).tolist())}),
        ("rest-in-degrees", "rest angles are taken in degrees where radians are meant",
         {"rest_rad": tuple(map(math.degrees, j.rest_rad))}),
        ("first-for-all", "joints all have the first joint's spring and damper", first),
        ("in-reversed-order", "springs and dampers are in reversed order", order),
        ("in-reversed-order-without-rest", "stiffness and damping of the joints are in reversed order",
         {f: order[f] for f, _ in SPRINGS[:2]}),
        *((f"{noun}-first-for-all".replace(" ", "-"), f"joints all have the first joint's {noun}", {f: first[f]})
          for f, noun in SPRINGS),
        *((f"{noun}-reversed".replace(" ", "-"), f"{noun} of the joints is in reversed order", {f: order[f]})
          for f, noun in SPRINGS),
    ))  # fmt: skip


def of_set_points(scene: Scene) -> Made:
    """Controls towards set points that lack their springs, their dampers, or the rate of the set point in these."""
    moved, springs = moved_joints(scene), scene.effects.joint_spring_damper
    if springs is None or not moved:
        return

    def motors(by_spring: float, by_damper: float) -> tuple[JointTorque, ...]:
        found = []
        for place, motor in enumerate(scene.effects.joint_torque):
            point = moved.get(motor.joint)
            if point is not None and point.motor == place:  # its torque is k (s - s0) + c s'
                s_rad = point.at(np.array(motor.times_s))
                k, rest = (getattr(springs, f)[motor.joint - 1] for f in ("stiffness_N_m_rad", "rest_rad"))
                of_spring = k * (s_rad - rest)
                torque = by_spring * of_spring + by_damper * (np.array(motor.torque_N_m) - of_spring)
                motor = dataclasses.replace(motor, torque_N_m=tuple(torque.tolist()))  # noqa: PLW2901
            found.append(motor)
        return tuple(found)

    for field, noun, torques in (
        ("stiffness_N_m_rad", "springs", motors(0.0, 1.0)), ("damping_N_m_s_rad", "dampers", motors(1.0, 0.0))
    ):  # fmt: skip
        for name, joints, where in (
            ("to-set-points", moved, "joints with set points"),
            ("everywhere", range(1, scene.bars), "all joints, towards set points too,"),
        ):
            each = tuple(0.0 if j in joints else v for j, v in enumerate(getattr(springs, field), start=1))
            changed = dataclasses.replace(springs, **{field: each})
            yield (f"{noun}-missing-{name}", f"the {noun} of {where} are missing",
                   with_effects(scene, joint_spring_damper=changed, joint_torque=torques))  # fmt: skip
    yield ("set-points-without-rates", "the rates of the set points are missing in the dampers",
           with_effects(scene, joint_torque=motors(1.0, 0.0)))  # fmt: skip


def of_clock(scene: Scene) -> Made:
    """Effects whose instants count from the start of a run, though their clock has begun before it."""
    if clock_at_start(scene):
        equal_samples = dataclasses.replace(scene, run=Run(scene.run.duration_s, scene.run.samples))
        with contextlib.suppress(SceneError):  # a law that the state would not meet
            from_start = change_scene(equal_samples, {"run": {"start_s": 0.0}})
            words = "the instants of effects count from the start of the run, not on the clock that has begun before it"
            yield "clock-from-the-start", words, with_effects(scene, **vars(from_start.effects))


def of_bodies(scene: Scene) -> Made:
    """Third bodies that are missing or elsewhere, and oblateness by another radius."""
    bodies, own, oblate = scene.effects.third_body, scene.central_body, scene.effects.oblateness
    if oblate is not None:
        words = "oblateness counts from the central body's radius"
        yield from with_fields(
            scene, "oblateness", "oblateness", (("radius-of-body", words, {"radius_m": own.radius_m}),)
        )
    if bodies:
        yield "third-bodies-missing", "the third bodies are missing", with_effects(scene, third_body=())
    for which, kept in (("first", bodies[:1]), ("last", bodies[-1:])) if len(bodies) > 2 else ():
        yield (f"third-bodies-but-{which}-missing", f"the third bodies but the {which} are missing",
               with_effects(scene, third_body=kept))  # fmt: skip
    for k, (body, said) in enumerate(zip(bodies, body_words(scene), strict=True)):
        for name, words, new in (
            ("missing", f"the {said} is missing", ()),
            ("from-surface", f"the distance of the {said} counts from the surface",
             (dataclasses.replace(body, distance_m=body.distance_m + own.radius_m),)),
            ("without-own-mass", f"the rate of the {said} lacks its own mass",
             (dataclasses.replace(body, rate_rad_s=math.sqrt(own.mu_m3_s2 / body.distance_m**3)),)),
        ):  # fmt: skip
            yield (f"third-body-{k + 1}-{name}", words,
                   with_effects(scene, third_body=(*bodies[:k], *new, *bodies[k + 1 :])))  # fmt: skip


def of_rotations(scene: Scene) -> Made:
    """Prescribed rotations in another frame, by another actuator, from another instant."""
    for some in choices(scene, "prescribed_rotation"):
        name, who, s, law = some.name, some.who, some.s, some.every[some.places[0]]
        frame = "the local horizontal" if law.frame is Frame.INERTIAL else "inertial axes"
        yield (f"{name}-from-{other(law.frame)}", f"{who} count{s} the angle from {frame}, the other direction",
               some.each(lambda p: {"frame": other(p.frame)}))  # fmt: skip
        yield f"{name}-from-the-start", f"{who} begin{s} at t = 0", some.each(from_the_start)
        yield f"{name}-of-first-turn", f"{who} make{s} the first turn alone", some.each(lambda _: {"further": ()})
        course = "the paper's law" if law.course is Course.QUINTIC else "the quintic"
        yield f"{name}-by-other-course", f"{who} follow{s} {course}, the other course", some.each(other_course)
        made = some.each(lambda p: {"actuator": other(p.actuator)})
        laws = made.effects.prescribed_rotation if scene.bars > 1 else ()
        motors = [joint_of_motor(p.bar) for p in laws if p.actuator is Actuator.JOINT]
        if laws and len(set(motors)) == len(motors):
            actuator = "an external torque" if law.actuator is Actuator.JOINT else "a joint's actuator"
            words = f"{who} ha{s or 've'} {actuator}: the torque on the neighbour is wrong"
            yield f"{name}-by-{other(law.actuator)}-actuator", words, made


def from_the_start(law: PrescribedRotation) -> dict[str, Any]:
    """Law whose first turn begins at t = 0, and the others earlier by as much."""
    return vars(law.with_turns(lambda turn: dataclasses.replace(turn, start_s=turn.start_s - law.start_s)))


def other_course(law: PrescribedRotation) -> dict[str, Any]:
    """Law with the other course in all turns."""
    return vars(law.with_turns(lambda turn: dataclasses.replace(turn, course=other(turn.course))))
