"""Scenes that an engine may have taken for the given one: other ends, axes, orders, models; no amount is fitted."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from adapters.common.initial_state import initial_state
from barchain.judge.diagnosis.motion.candidate import BODIES, GRAVITY, LOADS
from barchain.judge.diagnosis.motion.numbers import BODY_WORDS
from scenarios import Actuator, Axes, End, Frame, Gravity
from scenarios.toml.checks import joint_of_motor
from scenarios.toml.effect_tables import DragTable, SolarPressureTable, slender_inertia

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from scenarios import Scene

    Made = Iterator[tuple[str, str, Scene]]

LEVEL_M = 1e15
"""Scale height of an atmosphere whose density is the same at all heights"""
JUMP_S = 1e-4
"""Duration of a jump in a table; its effect on the motion is of second order"""
FORCES = (("kilograms-force", 9.80665), ("pounds-force", 4.4482216152605), ("kilonewtons", 1e3))
SPRINGS = (("stiffness_N_m_rad", "stiffness"), ("damping_N_m_s_rad", "damping"), ("rest_rad", "rest angle"))


@dataclass(frozen=True)
class Alternative:
    """Another scene."""

    name: str
    words: str
    """Sentence without a full stop; begins with `the`"""
    section: str
    scene: Scene


def alternatives(scene: Scene) -> Iterator[Alternative]:
    """Other scenes than the given one."""
    for section, made in (
        (BODIES, of_chain(scene)),
        (GRAVITY, of_gravity(scene)),
        (LOADS, of_pushes(scene)),
        (LOADS, of_drag(scene)),
        (LOADS, of_light(scene)),
        (LOADS, of_joints(scene)),
        (LOADS, of_bodies(scene)),
        (LOADS, of_rotations(scene)),
    ):
        for name, words, other in made:
            if other != scene:
                yield Alternative(name, words, section, other)


def with_effects(scene: Scene, **values: Any) -> Scene:
    """Scene with other effects."""
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **values))


def with_effect(scene: Scene, effect: str, **values: Any) -> Scene:
    """Scene with another single effect."""
    return with_effects(scene, **{effect: dataclasses.replace(getattr(scene.effects, effect), **values)})


def of_chain(scene: Scene) -> Made:
    """Orders of masses, lengths and moments of inertia, and moments of inertia by other formulas."""
    c, n = scene.chain, scene.bars
    mass, length, inertia = c.mass_kg, c.length_m, c.inertia_kg_m2
    bars = list(zip(mass, length, inertia, strict=True))
    slender = tuple(slender_inertia(m, size) for m, size, _ in bars)
    about_end = tuple(j + m * size**2 / 4.0 for m, size, j in bars)
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
        ("inertia-about-end", "moments of inertia are those about the bars' ends", (mass, length, about_end)),
        ("inertia-slender", "moments of inertia are those of slender bars, not the given ones",
         (mass, length, slender)),
        ("inertia-slender-about-end", "moments of inertia are those of slender bars about their ends",
         (mass, length, tuple(4.0 * j for j in slender))),
        ("first-mass-for-all", "bars all have the first bar's mass", (mass[:1] * n, length, inertia)),
        ("first-length-for-all", "bars all have the first bar's length", (mass, length[:1] * n, inertia)),
        ("first-inertia-for-all", "bars all have the first bar's moment of inertia", (mass, length, inertia[:1] * n)),
    ):  # fmt: skip
        chain = dataclasses.replace(c, mass_kg=values[0], length_m=values[1], inertia_kg_m2=values[2])
        yield name, f"the {words}", dataclasses.replace(scene, chain=chain)


GRAVITY_WORDS = {
    Gravity.NONE: "the gravity is missing",
    Gravity.POINT: "the bars are point masses to gravity, the torque of the gravity gradient is missing",
    Gravity.GRADIENT: "the gravity is that of the paper, a point mass' force with the gradient's torque",
    Gravity.QUADRUPOLE: "the gravity is expanded to the bars' second moments",
    Gravity.SLENDER: "the gravity is that on slender bars",
}


def of_gravity(scene: Scene) -> Made:
    """Other models of gravity."""
    for gravity, words in GRAVITY_WORDS.items():
        yield f"gravity-{gravity}", words, with_effects(scene, gravity=gravity)


@dataclass(frozen=True)
class Some:
    """Some of several thrusts, impulses or prescribed rotations of a scene."""

    scene: Scene
    kind: str
    places: tuple[int, ...]
    who: str

    @property
    def name(self) -> str:
        """Beginning of names."""
        return self.who.removeprefix("the ").replace(" ", "-")

    @property
    def s(self) -> str:
        """Ending of a verb."""
        return "" if self.who.endswith("s") else "s"

    @property
    def every(self) -> tuple[Any, ...]:
        """All of the kind."""
        found: tuple[Any, ...] = getattr(self.scene.effects, self.kind)
        return found

    @property
    def first(self) -> Any:
        """The first of these."""
        return self.every[self.places[0]]

    def each(self, change: Callable[[Any], Any]) -> Scene:
        """Scene with these changed."""
        return self.put(tuple(change(p) if k in self.places else p for k, p in enumerate(self.every)))

    def field(self, **values: Callable[[Any], Any]) -> Scene:
        """Scene with fields of these changed."""
        return self.each(lambda p: dataclasses.replace(p, **{f: v(p) for f, v in values.items()}))

    def without(self, others: Sequence[Any] = ()) -> Scene:
        """Scene with others in place of these."""
        return self.put((*(p for k, p in enumerate(self.every) if k not in self.places), *others))

    def put(self, every: tuple[Any, ...]) -> Scene:
        """Scene with others in place of all."""
        return with_effects(self.scene, **{self.kind: every})


def sets(scene: Scene, kind: str, noun: str) -> list[Some]:
    """Each thrust, impulse or prescribed rotation alone, and all together."""
    count = len(getattr(scene.effects, kind))
    each = [Some(scene, kind, (k,), f"the {noun} {k + 1}") for k in range(count) if count > 1]
    every = Some(scene, kind, tuple(range(count)), f"the {noun}" + ("s" if count > 1 else ""))
    return [every, *each] if count else []


def of_pushes(scene: Scene) -> Made:
    """Thrusts and impulses at another point, in other axes, on another bar, or missing."""
    angle = initial_state(scene).angle_rad
    for some in (*sets(scene, "thrust", "thrust"), *sets(scene, "impulse", "impulse")):
        name, who, s = some.name, some.who, some.s
        yield f"{name}-missing", f"{who} {'is' if s else 'are'} missing", some.without()
        yield (f"{name}-at-other-end", f"{who} act{s} at the bar's other end",
               some.field(end=lambda p: End.LEFT if p.end is End.RIGHT else End.RIGHT))  # fmt: skip
        other = "inertial" if some.first.axes is Axes.BODY else "body"
        yield (f"{name}-in-other-axes", f"{who} count{s} the direction in {other} axes, the other ones",
               some.field(axes=lambda p: Axes.INERTIAL if p.axes is Axes.BODY else Axes.BODY))  # fmt: skip
        frozen = {"axes": lambda _: Axes.INERTIAL, "direction_rad": lambda p: p.direction_rad + start_rad(p, angle)}
        yield f"{name}-frozen", f"{who} keep{s} the direction of the bar at t = 0", some.field(**frozen)
        for shift in range(1, scene.bars):
            where = {1: "next", scene.bars - 1: "previous"}.get(shift, f"{shift}th next")
            yield (f"{name}-on-{where.replace(' ', '-')}-bar", f"{who} act{s} on the {where} bar",
                   some.field(bar=on_next(shift, scene.bars)))  # fmt: skip
        halves = [half(some.every[k], end) for k in some.places for end in End]
        yield f"{name}-at-centre", f"{who} act{s} at the bar's centre", some.without(halves)
        if some.kind == "thrust":
            yield from of_tables(some)


def on_next(shift: int, bars: int) -> Callable[[Any], int]:
    """Bar that is some places on, round the chain."""
    return lambda push: (push.bar - 1 + shift) % bars + 1


def times(factor: float) -> Callable[[Any], tuple[float, ...]]:
    """Force times a factor."""
    return lambda push: tuple(factor * f for f in push.force_N)


def start_rad(push: Any, angle: Any) -> float:
    """Angle at the start of the axes of a push."""
    return float(angle[push.bar - 1]) if push.axes is Axes.BODY else 0.0


def half(push: Any, end: End) -> Any:
    """Half a push at an end."""
    if hasattr(push, "force_N"):
        return dataclasses.replace(push, end=end, force_N=tuple(0.5 * f for f in push.force_N))
    return dataclasses.replace(push, end=end, impulse_N_s=0.5 * push.impulse_N_s)


def of_tables(some: Some) -> Made:
    """Thrusts with another course in time, or another unit."""
    name, who, s, end_s = some.name, some.who, some.s, some.scene.run.duration_s
    for unit, factor in FORCES:
        yield (f"{name}-in-{unit}", f"{who} take{s} newtons as {unit}",
               some.field(force_N=times(factor)))  # fmt: skip
    for which, words, before, after in (
        ("from-the-start", f"act{s} from the start of the run on", True, False),
        ("without-end", f"act{s} without end", False, True),
        ("all-along", f"act{s} from the start to the end of the run", True, True),
    ):
        longer_one = some.each(partial(longer, end_s=end_s, before=before, after=after))
        yield f"{name}-{which}", f"{who} {words}", longer_one
    yield f"{name}-table-held", f"{who} keep{s} the size from one instant of the table to the next", some.each(held)
    mean = some.field(force_N=lambda p: (sum(p.force_N) / len(p.force_N),) * len(p.force_N))
    first = some.field(force_N=lambda p: p.force_N[:1] * len(p.force_N))
    yield f"{name}-mean-size", f"{who} keep{s} the mean size of the table", mean
    yield f"{name}-first-size", f"{who} keep{s} the first size of the table", first


def longer(thrust: Any, end_s: float, before: bool, after: bool) -> Any:
    """A thrust that begins at the start, goes on to the end, or both."""
    times, sizes = list(thrust.times_s), list(thrust.force_N)
    if before and times[0] > 0.0:
        times, sizes = [0.0, *times], [sizes[0], *sizes]
    if after and times[-1] < end_s:
        times, sizes = [*times, end_s], [*sizes, sizes[-1]]
    return dataclasses.replace(thrust, times_s=tuple(times), force_N=tuple(sizes))


def held(thrust: Any) -> Any:
    """A thrust whose size jumps at each instant of its table."""
    if len(set(thrust.force_N)) == 1:
        return thrust
    times, sizes = [thrust.times_s[0]], [thrust.force_N[0]]
    for at_s, before, after in zip(thrust.times_s[1:-1], thrust.force_N, thrust.force_N[1:], strict=False):
        times += [at_s - 0.5 * JUMP_S, at_s + 0.5 * JUMP_S]
        sizes += [before, after]
    return dataclasses.replace(thrust, times_s=(*times, thrust.times_s[-1]), force_N=(*sizes, thrust.force_N[-2]))


def of_drag(scene: Scene) -> Made:
    """Drag with other coefficients, densities and widths."""
    d = scene.effects.drag
    if d is None:
        return
    normal, tangential, height_m = d.normal_coefficient, d.tangential_coefficient, scene.orbit.altitude_m
    at_start = d.density_kg_m3 * math.exp((d.altitude_m - height_m) / d.scale_height_m)
    usual = {f: DragTable.model_fields[f].default for f in ("normal_coefficient", "tangential_coefficient")}
    yield "drag-missing", "the drag is missing", with_effects(scene, drag=None)
    for name, words, values in (
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
        ("tenfold-height", "drag takes the scale height as that of a tenfold density",
         {"scale_height_m": d.scale_height_m / math.log(10.0)}),
        ("first-width-for-all", "drag takes the first bar's width for all", {"width_m": d.width_m[:1] * scene.bars}),
        ("widths-reversed", "widths for the drag are in reversed order", {"width_m": d.width_m[::-1]}),
    ):  # fmt: skip
        yield f"drag-{name}", f"the {words}", with_effect(scene, "drag", **values)


def of_light(scene: Scene) -> Made:
    """Sunlight with another shadow, reflection, width or pressure."""
    p = scene.effects.solar_pressure
    if p is None:
        return
    usual = SolarPressureTable.model_fields
    yield "sunlight-missing", "the solar pressure is missing", with_effects(scene, solar_pressure=None)
    for name, words, values in (
        ("without-shadow", "shadow is missing", {"shadow": False}),
        ("with-shadow", "sunlight has a shadow that the scene has not", {"shadow": True}),
        ("mirror", "reflectivity is 1", {"reflectivity": 1.0}),
        ("exchanged", "absorbed and the reflected sunlight are exchanged", {"reflectivity": 1.0 - p.reflectivity}),
        ("opposite", "sunlight comes from the opposite direction",
         {"sun_longitude_rad": p.sun_longitude_rad + math.pi}),
        ("first-width-for-all", "solar pressure takes the first bar's width for all",
         {"width_m": p.width_m[:1] * scene.bars}),
        ("widths-reversed", "widths for the solar pressure are in reversed order", {"width_m": p.width_m[::-1]}),
        ("default-pressure", "pressure of light is the default", {"pressure_Pa": usual["pressure_Pa"].default}),
        ("default-rate", "direction of the Sun turns at the default rate",
         {"sun_rate_rad_s": usual["sun_rate_rad_s"].default}),
    ):  # fmt: skip
        yield f"sunlight-{name}", f"the {words}", with_effect(scene, "solar_pressure", **values)


def of_joints(scene: Scene) -> Made:
    """Springs and dampers of other joints, with other rest angles."""
    j = scene.effects.joint_spring_damper
    if j is None:
        return
    kind, joints = "joint_spring_damper", scene.bars - 1
    angle = initial_state(scene).angle_rad
    rest = tuple((angle[1:] - angle[:-1]).tolist())
    fields = [field for field, _ in SPRINGS]
    order = {f: getattr(j, f)[::-1] for f in fields}
    first = {f: getattr(j, f)[:1] * joints for f in fields}
    yield "springs-missing", "the springs and dampers of the joints are missing", with_effects(scene, **{kind: None})
    for name, words, values in (
        ("rest-at-start", "springs are at rest at t = 0", {"rest_rad": rest}),
        ("rest-in-degrees", "rest angles are taken in degrees where radians are meant",
         {"rest_rad": tuple(map(math.degrees, j.rest_rad))}),
        ("first-for-all", "joints all have the first joint's spring and damper", first),
        ("in-reversed-order", "springs and dampers are in reversed order", order),
        ("in-reversed-order-without-rest", "stiffness and damping of the joints are in reversed order",
         {f: order[f] for f in fields[:2]}),
        *((f"{noun}-first-for-all".replace(" ", "-"), f"joints all have the first joint's {noun}", {f: first[f]})
          for f, noun in SPRINGS),
        *((f"{noun}-reversed".replace(" ", "-"), f"joints have the {noun}s in reversed order", {f: order[f]})
          for f, noun in SPRINGS),
    ):  # fmt: skip
        yield f"springs-{name}", f"the {words}", with_effect(scene, kind, **values)


def of_bodies(scene: Scene) -> Made:
    """Third bodies that are missing or elsewhere, and oblateness by another radius."""
    bodies, oblate = scene.effects.third_body, scene.effects.oblateness
    if oblate is not None:
        own = with_effect(scene, "oblateness", radius_m=scene.central_body.radius_m)
        yield "oblateness-radius-of-body", "the oblateness counts from the central body's radius", own
    if bodies:
        yield "third-bodies-missing", "the third bodies are missing", with_effects(scene, third_body=())
    for k, body in enumerate(bodies):
        said = BODY_WORDS.get(body.name, body.name)

        def other(k: int = k, body: Any = body, **values: float) -> Scene:
            return with_effects(scene, third_body=(*bodies[:k], dataclasses.replace(body, **values), *bodies[k + 1 :]))

        name, mu = f"third-body-{k + 1}", scene.central_body.mu_m3_s2
        gone = with_effects(scene, third_body=(*bodies[:k], *bodies[k + 1 :]))
        yield f"{name}-missing", f"the {said} is missing", gone
        yield (f"{name}-from-surface", f"the distance of the {said} counts from the surface",
               other(distance_m=body.distance_m + scene.central_body.radius_m))  # fmt: skip
        yield (f"{name}-without-own-mass", f"the rate of the {said} lacks its own mass",
               other(rate_rad_s=math.sqrt(mu / body.distance_m**3)))  # fmt: skip


def of_rotations(scene: Scene) -> Made:
    """Prescribed rotations in another frame, by another actuator, from another instant."""
    for some in sets(scene, "prescribed_rotation", "prescribed rotation"):
        name, who, s, law = some.name, some.who, some.s, some.first
        frame = "inertial axes" if law.frame is Frame.LOCAL_HORIZONTAL else "the local horizontal"
        yield (f"{name}-other-frame", f"{who} count{s} the angle from {frame}, the other direction",
               some.field(frame=lambda p: Frame.INERTIAL if p.frame is Frame.LOCAL_HORIZONTAL
                          else Frame.LOCAL_HORIZONTAL))  # fmt: skip
        yield f"{name}-from-the-start", f"{who} begin{s} at t = 0", some.field(start_s=lambda _: 0.0)
        if scene.bars > 1:
            made = some.field(actuator=lambda p: Actuator.EXTERNAL if p.actuator is Actuator.JOINT else Actuator.JOINT)
            laws = made.effects.prescribed_rotation
            motors = [joint_of_motor(p.bar) for p in laws if p.actuator is Actuator.JOINT]
            actuator = "an external torque" if law.actuator is Actuator.JOINT else "a joint's actuator"
            if len(set(motors)) == len(motors):
                words = f"{who} ha{s or 've'} {actuator}: the torque on the neighbour is wrong"
                yield f"{name}-other-actuator", words, made
