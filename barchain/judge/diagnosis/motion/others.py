"""Scenes that an engine may have taken for the given one: other ends, axes, orders, models; no amount is fitted."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from adapters.common.initial_state import initial_state
from barchain.judge.diagnosis.motion.numbers import KNOWN, body_words
from barchain.judge.diagnosis.motion.words import BODIES, GRAVITY, LOADS
from scenarios import Actuator, Axes, End, Frame, Gravity
from scenarios.toml.checks import joint_of_motor
from scenarios.toml.effect_tables import DragTable, SolarPressureTable, slender_inertia

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenarios import Scene

    Made = Iterator[tuple[str, str, Scene]]
    Fields = Callable[[Any], dict[str, Any]]
    """New fields of a part of a scene"""

LEVEL_M = 1e15
"""Scale height of an atmosphere whose density is the same at all heights"""
JUMP_S = 1e-4
"""Duration of a jump in a table; its effect on the motion is of second order"""
FORCES = (("kilograms-force", 9.80665), ("pounds-force", 4.4482216152605), ("kilonewtons", 1e3))
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
        (LOADS, of_drag(scene)),
        (LOADS, of_light(scene)),
        (LOADS, of_joints(scene)),
        (LOADS, of_bodies(scene)),
        (LOADS, of_rotations(scene)),
    ):
        for name, words, new in made:
            if new != scene:
                yield Other(name, words, section, new)


def with_effects(scene: Scene, **values: Any) -> Scene:
    """Scene with other effects."""
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **values))


def with_fields(scene: Scene, effect: str, prefix: str, rows: tuple[tuple[str, str, dict[str, Any]], ...]) -> Made:
    """Scenes with other fields of a single effect: ending of the name, words after "the", and values."""
    given = getattr(scene.effects, effect)
    for name, words, values in rows:
        yield f"{prefix}-{name}", f"the {words}", with_effects(scene, **{effect: dataclasses.replace(given, **values)})


def other(choice: Any) -> Any:
    """The other of two choices."""
    return next(c for c in type(choice) if c is not choice)


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


class Some(NamedTuple):
    """Some of several thrusts, impulses or prescribed rotations of a scene."""

    scene: Scene
    kind: str
    places: tuple[int, ...]
    who: str
    name: str
    s: str
    """Ending of a verb"""

    @property
    def every(self) -> tuple[Any, ...]:
        """All of the kind."""
        found: tuple[Any, ...] = getattr(self.scene.effects, self.kind)
        return found

    def changed(self, change: Callable[[Any], tuple[Any, ...]]) -> Scene:
        """Scene with others in place of each of these, which come last."""
        kept = [p for k, p in enumerate(self.every) if k not in self.places]
        new = [p for k in self.places for p in change(self.every[k])]
        return with_effects(self.scene, **{self.kind: (*kept, *new)})

    def each(self, change: Fields) -> Scene:
        """Scene with fields of these changed."""
        new = (dataclasses.replace(p, **change(p)) if k in self.places else p for k, p in enumerate(self.every))
        return with_effects(self.scene, **{self.kind: tuple(new)})


def sets(scene: Scene, kind: str) -> Iterator[Some]:
    """All thrusts, impulses or prescribed rotations together, and each alone."""
    count, noun = len(getattr(scene.effects, kind)), kind.replace("_", " ")
    s = "s" if count > 1 else ""
    for places in [tuple(range(count)), *((k,) for k in range(count) if count > 1)] if count else ():
        alone = len(places) == 1
        who = f"{noun}{s}" if len(places) == count else f"{noun} {places[0] + 1}"
        yield Some(scene, kind, places, f"the {who}", who.replace(" ", "-"), "s" if alone else "")


def of_pushes(scene: Scene) -> Made:
    """Thrusts and impulses at another point, in other axes, on another bar, or missing."""
    angle = initial_state(scene).angle_rad
    yield from of_one_instant(scene, "thrust", lambda p: p.times_s[0])
    yield from of_one_instant(scene, "impulse", lambda p: p.at_s)
    loaded = ("thrust", "impulse", "prescribed_rotation")
    by_digit = {kind: tuple(dataclasses.replace(p, bar=int(str(p.bar)[0])) for p in getattr(scene.effects, kind))
                for kind in loaded}  # fmt: skip
    yield ("bars-by-first-digit", "the loads on bars from 10 on act on the bar of the number's first digit",
           with_effects(scene, **by_digit))  # fmt: skip
    for some in (*sets(scene, "thrust"), *sets(scene, "impulse")):
        name, who, s, first = some.name, some.who, some.s, some.every[some.places[0]]
        yield f"{name}-missing", f"{who} {'is' if s else 'are'} missing", some.changed(lambda _: ())
        yield f"{name}-at-other-end", f"{who} act{s} at the bar's other end", some.each(lambda p: {"end": other(p.end)})
        for end, where in ((End.LEFT, "left"), (End.RIGHT, "right")):
            if len({p.end for p in some.every}) > 1:
                yield f"{name}-at-{where}-ends", f"{who} act{s} at the {where} end always", some.each(at_end(end))
        axes = f"{other(first.axes)} axes"
        yield (f"{name}-in-{axes.replace(' ', '-')}", f"{who} count{s} the direction in {axes}, the other ones",
               some.each(lambda p: {"axes": other(p.axes)}))  # fmt: skip

        def frozen(p: Any) -> dict[str, Any]:
            turned = float(angle[p.bar - 1]) if p.axes is Axes.BODY else 0.0
            return {"axes": Axes.INERTIAL, "direction_rad": p.direction_rad + turned}

        yield (f"{name}-clockwise", f"{who} count{s} the direction clockwise",
               some.each(lambda p: {"direction_rad": -p.direction_rad}))  # fmt: skip
        yield (
            f"{name}-from-normal",
            f"{who} count{s} a direction in body axes from the bar's normal",
            some.each(lambda p: {"direction_rad": p.direction_rad + (0.5 * math.pi if p.axes is Axes.BODY else 0.0)}),
        )
        yield f"{name}-frozen", f"{who} keep{s} the direction of the bar at t = 0", some.each(frozen)
        for shift in range(1, scene.bars):
            there = some.each(on_next(shift, scene.bars))
            where = {1: "the next bar", scene.bars - 1: "the previous bar"}.get(shift, f"the bar {shift} places on")
            if s:
                where = f"bar {getattr(there.effects, some.kind)[some.places[0]].bar}"
            yield f"{name}-on-{where.removeprefix('the ').replace(' ', '-')}", f"{who} act{s} on {where}", there
        yield f"{name}-at-centre", f"{who} act{s} at the bar's centre", some.changed(halves)
        yield f"{name}-of-positive-size", f"{who} lose{s} the sign of a negative size", some.each(positive)
        if some.kind == "thrust":
            yield from of_tables(some)


def of_one_instant(scene: Scene, kind: str, at_s: Callable[[Any], float]) -> Made:
    """Thrusts or impulses of the first or of the last instant alone."""
    every = getattr(scene.effects, kind)
    instants = {at_s(push) for push in every}
    for which, rest, instant in (("first", "later", min), ("last", "earlier", max)) if len(instants) > 1 else ():
        kept = tuple(push for push in every if at_s(push) == instant(instants))
        words = f"the {kind}s of the {which} instant act, and the {rest} ones are missing"
        yield f"{kind}s-of-{which}-instant", words, with_effects(scene, **{kind: kept})


def halves(push: Any) -> tuple[Any, ...]:
    """Half a push at each end."""
    half = times(0.5)(push) if hasattr(push, "force_N") else {"impulse_N_s": 0.5 * push.impulse_N_s}
    return tuple(dataclasses.replace(push, end=end, **half) for end in End)


def at_end(end: End) -> Fields:
    """Push at an end, whichever the scene has."""
    return lambda _: {"end": end}


def on_next(shift: int, bars: int) -> Fields:
    """Bar that is some places on, round the chain."""
    return lambda push: {"bar": (push.bar - 1 + shift) % bars + 1}


def positive(push: Any) -> dict[str, Any]:
    """Push of a size without its sign."""
    if hasattr(push, "force_N"):
        return {"force_N": tuple(map(abs, push.force_N))}
    return {"impulse_N_s": abs(push.impulse_N_s)}


def times(factor: float) -> Fields:
    """Force of a thrust times a factor."""
    return lambda thrust: {"force_N": tuple(factor * f for f in thrust.force_N)}


def of_tables(some: Some) -> Made:
    """Thrusts with another course in time, or another unit."""
    name, who, s, end_s = some.name, some.who, some.s, some.scene.run.duration_s
    for unit, factor in FORCES:
        yield (f"{name}-in-{unit}", f"{who} take{s} newtons as {unit}",
               some.each(times(factor)))  # fmt: skip
    for which, words, before, after in (
        ("from-the-start", f"act{s} from the start of the run on", True, False),
        ("without-end", f"act{s} without end", False, True),
        ("all-along", f"act{s} from the start to the end of the run", True, True),
    ):

        def longer(p: Any, before: bool = before, after: bool = after) -> dict[str, Any]:
            early = before and p.times_s[0] > 0.0
            late = after and p.times_s[-1] < end_s
            return {
                "times_s": (*((0.0,) if early else ()), *p.times_s, *((end_s,) if late else ())),
                "force_N": (*(p.force_N[:1] if early else ()), *p.force_N, *(p.force_N[-1:] if late else ())),
            }

        yield f"{name}-{which}", f"{who} {words}", some.each(longer)
    for which, words, size in (
        ("table-held", "size from one instant of the table to the next", held),
        ("table-ahead", "size of the next instant of the table, up to it", lambda p: held(p, 0.0)),
        ("table-of-means", "mean of two sizes between their instants in the table", lambda p: held(p, 0.5)),
        ("mean-size", "mean size of the table",
         lambda p: {"force_N": (sum(p.force_N) / len(p.force_N),) * len(p.force_N)}),
        ("first-size", "first size of the table", lambda p: {"force_N": p.force_N[:1] * len(p.force_N)}),
    ):  # fmt: skip
        yield f"{name}-{which}", f"{who} keep{s} the {words}", some.each(size)


def held(thrust: Any, share: float = 1.0) -> dict[str, Any]:
    """Table of a thrust whose size jumps at each instant: between two, a share of the first, the rest of the next."""
    if len(set(thrust.force_N)) == 1:
        return {}
    steps = [share * a + (1.0 - share) * b for a, b in itertools.pairwise(thrust.force_N)]
    times_s, sizes = [thrust.times_s[0]], [steps[0]]
    for at_s, before, after in zip(thrust.times_s[1:-1], steps, steps[1:], strict=False):
        times_s += [at_s - 0.5 * JUMP_S, at_s + 0.5 * JUMP_S]
        sizes += [before, after]
    return {"times_s": (*times_s, thrust.times_s[-1]), "force_N": (*sizes, steps[-1])}


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
    for some in sets(scene, "prescribed_rotation"):
        name, who, s, law = some.name, some.who, some.s, some.every[some.places[0]]
        frame = "the local horizontal" if law.frame is Frame.INERTIAL else "inertial axes"
        yield (f"{name}-from-{other(law.frame)}", f"{who} count{s} the angle from {frame}, the other direction",
               some.each(lambda p: {"frame": other(p.frame)}))  # fmt: skip
        yield f"{name}-from-the-start", f"{who} begin{s} at t = 0", some.each(lambda _: {"start_s": 0.0})
        made = some.each(lambda p: {"actuator": other(p.actuator)})
        laws = made.effects.prescribed_rotation if scene.bars > 1 else ()
        motors = [joint_of_motor(p.bar) for p in laws if p.actuator is Actuator.JOINT]
        if laws and len(set(motors)) == len(motors):
            actuator = "an external torque" if law.actuator is Actuator.JOINT else "a joint's actuator"
            words = f"{who} ha{s or 've'} {actuator}: the torque on the neighbour is wrong"
            yield f"{name}-by-{other(law.actuator)}-actuator", words, made
