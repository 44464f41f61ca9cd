"""Other models of loads than the right ones, as engines have them: a name, words, and the load in its place."""

from __future__ import annotations

import dataclasses
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.balance import BARS, JOINTS, Balance, real
from barchain.judge.diagnosis.motion.numbers import body_words
from barchain.judge.diagnosis.motion.rotations import of_motors
from barchain.judge.diagnosis.motion.words import GRAVITY, LOADS
from barchain.judge.equations import ENDS, Load, StateRows
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.model.complex_vectors import squared_norm
from reference_impl.model.gravity import complex_field_differences, gradient_angular_accelerations
from scenarios import Axes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.candidate import Candidates
    from barchain.judge.equations import Equations
    from reference_impl.model.arrays import ComplexArray

    Rows = Iterator[tuple[str, str, Load]]
    Places = Callable[[Equations], ComplexArray]
    """Places from the centre of mass (k, N), or of one point (k, 1)"""
    Clearance = Callable[[ComplexArray], Array]
    """Distance from the shadow, negative inside, of such places in axes towards the Sun"""

SEEN = 1e-5
"""Distance, in radii, over which a field's gradient is a difference: its square is the error"""


def models(found: Candidates) -> None:
    """All other models of a balance's loads."""
    e, scene = found.balance.equations, found.balance.scene
    if e.model.gravity != "none":
        replace(found, GRAVITY, e.tide.plus(e.gradient), of_gravity(e))
    bodies, parts = iter(body_words(scene)), dict[str, Load]()
    for effect, load in zip(e.model.effects, e.effects, strict=True):
        if isinstance(effect, DragEffect):
            replace(found, LOADS, load, of_drag(e, effect, load))
            words = "the part of the drag's torque by the square of the turning, of l^5/80, is"
            found.times("drag-fourth-moment", words, LOADS, fourth_moment(e, effect))
        elif isinstance(effect, SolarPressureEffect):
            replace(found, LOADS, load, of_light(e, effect, load))
            if effect.shadow_radius_m:
                of_shadow(found, effect)
        elif isinstance(effect, OblatenessEffect):
            replace(found, LOADS, load, of_oblateness(e, effect, load))
        elif isinstance(effect, ThirdBodyEffect):
            replace(found, LOADS, load, of_third_body(e, effect, load, next(bodies)))
        elif isinstance(effect, QuadrupoleEffect):
            replace(found, GRAVITY, load, of_second_moments(e, load))
        if isinstance(effect, OblatenessEffect | ThirdBodyEffect) and effect.second_moment:
            part = load.plus(e.of_effect(dataclasses.replace(effect, second_moment=False)).times(-1.0))
            who = "oblateness" if isinstance(effect, OblatenessEffect) else "third bodies"
            parts[who] = parts.get(who, e.zero).plus(part)
    for who, part in parts.items():
        words = f"the force of the {who} on the bars' second moments is"
        found.times(f"{who.replace(' ', '-')}-second-moments", words, LOADS, part)
    of_motors(found)
    if scene.bars > 1 and scene.effects.impulse:
        words = "the impulses act on bars that are free of their neighbours"
        found.fixed("impulses-on-free-bars", words, LOADS, partial(on_free_bars, found.balance))


def replace(found: Candidates, section: str, right: Load, rows: Rows) -> None:
    """Add rows of loads that stand in place of a right one."""
    for name, words, load in rows:
        found.fixed(name, f"the {words}", section, load.plus(right.times(-1.0)))


def joints(e: Equations) -> Iterator[tuple[str, ComplexArray, ComplexArray]]:
    """Sides of the bars, with the place and the velocity of the joint there from the bar's centre."""
    u, w = e.states.unit, e.states.rate
    for side, arm in (("left", -e.shape.left), ("right", e.shape.right)):
        yield side, arm * u, arm * 1j * w * u


def at_place(e: Equations, place: ComplexArray | float, velocity: ComplexArray | float = 0.0) -> StateRows:
    """States in which effects see the bars at a distance from their centres."""
    seen = StateRows(e)
    seen.position = seen.position + place
    seen.velocity = seen.velocity + velocity
    return seen


def of_gravity(e: Equations) -> Rows:
    """Gravity at the joints, and on other masses."""
    s, m = e.states, e.model

    def tide(place: ComplexArray) -> ComplexArray:
        found: ComplexArray = m.mass_kg * complex_field_differences(m.mu_m3_s2, s.com[:, None], place)
        return found

    for side, arm, _ in joints(e):
        place = e.place + arm
        turning = gradient_angular_accelerations(m, s.com[:, None] + place, s.unit) * m.inertia_kg_m2
        words = f"gravity is that at the bars' {side} ends, in the joints, not at their centres"
        gradient = e.torque(turning) if m.gravity == "gradient" else e.zero
        yield f"gravity-of-{side}-joints", words, e.force(tide(place)).plus(gradient)
        if m.gravity == "gradient":
            words = f"force of gravity is that at the bars' {side} ends, in the joints, not at their centres"
            yield f"gravity-force-of-{side}-joints", words, e.force(tide(place)).plus(e.gradient)
    mean = e.shape.whole / s.bars
    words = "tidal force is that on the mean mass of the bars, the same for each"
    yield "tide-on-mean-mass", words, e.force(e.tide.force * mean / m.mass_kg).plus(e.gradient)


def of_second_moments(e: Equations, right: Load) -> Rows:
    """Forces on the second moments of slender bars."""
    slender = e.model.mass_kg * e.model.length_m**2 / 12.0
    words = "force of the central field on the bars' second moments is that on slender bars, of m l^2/12"
    yield "second-moment-of-slender-bars", words, right._replace(force=right.force * slender / e.model.inertia_kg_m2)


def of_drag(e: Equations, effect: DragEffect, right: Load) -> Rows:
    """Drag at other points, of other laws, with faces that do not turn."""
    s, length, rows = e.states, e.model.length_m, e.rows
    for side, arm, turning in joints(e):
        words = f"drag takes velocity and density at the bars' {side} ends, in the joints, not at their centres"
        seen = e.load_of(effect.accelerations(at_place(e, arm, turning), None))
        yield f"drag-of-{side}-joints", words, seen
    still = e.load_of(effect.accelerations(StateRows(e, s.rate + effect.rotation_rad_s), None))
    yield "drag-turning-without-air", "drag takes the bars' own turning, without the air's", still
    r = np.sqrt(squared_norm(rows.position_from_body))
    level = np.exp((r - abs(s.com)[:, None]) / effect.scale_height_m)
    words = "density of the air is that at the chain's centre of mass, for all bars"
    yield "drag-density-of-centre", words, right._replace(force=right.force * level, torque=right.torque * level)
    wind = effect.wind(rows)
    face = np.where(wind.across < 0.0, -1.0, 1.0)
    for name, words, kept in (
        ("drag-face-kept", "face towards the wind stays that of t = 0 in the drag", face[:1]),
        ("drag-face-left", "drag takes the left faces of the bars always, which never turn", 1.0),
    ):
        yield name, words, right._replace(force=right.force * kept * face, torque=right.torque * kept * face)
    speed = np.hypot(wind.along, wind.across)
    along = (wind.along + 1j * wind.across) * s.unit
    for name, coefficient in (("normal", effect.normal_coefficient), ("tangential", effect.tangential_coefficient)):
        thrown = -0.5 * effect.width_m * effect.density(rows, r) * length * coefficient * speed * along
        words = f"drag is isotropic, along the velocity with the {name} coefficient"
        yield f"drag-isotropic-{name}", f"{words}, and exerts no torque", e.force(thrown)
        yield f"drag-isotropic-{name}-in-force", f"{words}, in its force", right._replace(force=thrown)


def fourth_moment(e: Equations, effect: DragEffect) -> Load:
    """Torque of the drag by the density that falls along a turning bar."""
    wind, r = effect.wind(e.rows), np.sqrt(squared_norm(e.rows.position_from_body))
    fall = (e.states.unit.conj() * e.rows.position_from_body).real / (r * effect.scale_height_m)
    strength = 0.5 * effect.width_m * effect.density(e.rows, r) * np.sign(wind.across) * effect.normal_coefficient
    return e.torque(strength * fall * e.model.length_m**5 / 80.0 * wind.turning**2)


def of_light(e: Equations, effect: SolarPressureEffect, right: Load) -> Rows:
    """Sunlight with faces that do not turn, on one face, without foreshortening."""
    s = e.states
    mode = effect.mode(e.rows)
    lit, face = mode[..., :1], mode[..., 1:]

    def with_face(other: Array) -> Load:
        return e.load_of(effect.accelerations(e.rows, np.concatenate([lit, other + 0.0 * face], axis=-1)))

    yield "sunlight-face-kept", "face to the Sun stays that of t = 0", with_face(face[:1])
    words = "sunlight takes the left faces of the bars always, which never turn"
    yield "sunlight-face-left", words, with_face(np.ones(1))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        words = f"sunlight acts on the {side} faces of the bars alone"
        yield f"sunlight-on-{side}-faces", words, right._replace(force=right.force * (face == sign))
    sun = effect.sun_direction(e.rows.t_s)
    cosine = face * (s.unit.conj() * sun).imag
    whole = -effect.pressure_Pa * effect.width_m * e.model.length_m * lit
    absorbed, mirror = (1.0 - effect.reflectivity) * sun, 2.0 * effect.reflectivity * face * 1j * s.unit
    for name, words, force in (
        ("area", "lit area of a bar is not foreshortened by its angle to the Sun", absorbed + cosine * mirror),
        ("all", "sunlight is not foreshortened: its force has no cosine of the angle to the Sun", absorbed + mirror),
        ("reflected", "reflected sunlight has one cosine of the angle to the Sun, not its square",
         cosine * (absorbed + mirror)),
    ):  # fmt: skip
        yield f"sunlight-cosine-{name}", words, e.force(whole * force)


SHADED: tuple[tuple[str, str, Places], ...] = (
    ("of-bars", "each bar's own centre", lambda e: e.place),
    ("of-first-bar", "the first bar's centre", lambda e: e.place[:, :1]),
    ("of-last-bar", "the last bar's centre", lambda e: e.place[:, -1:]),
    ("of-left-end", "the chain's left end", lambda e: (e.place - e.shape.left * e.states.unit)[:, :1]),
    ("of-right-end", "the chain's right end", lambda e: (e.place + e.shape.right * e.states.unit)[:, -1:]),
    ("of-mean-place", "the mean of the bars' centres, without their masses",
     lambda e: e.place.mean(axis=1, keepdims=True)),
)  # fmt: skip
"""Points at which an engine may take the shadow, which is that of the centre of mass: name, words, places"""


def of_shadow(found: Candidates, effect: SolarPressureEffect) -> None:
    """Shadows of another shape, and of other points than the chain's centre of mass."""
    radius = effect.shadow_radius_m

    def cylinder(seen: ComplexArray) -> Array:
        return np.where(seen.real < 0.0, abs(seen.imag), abs(seen)) - radius

    rows: list[tuple[str, str, Places, Clearance]] = [
        (name, f"taken at {where}", places, cylinder) for name, where, places in SHADED
    ]
    words = "the half-space behind the central body's centre"
    rows.append(("half-space", words, lambda e: e.place, lambda seen: seen.real))
    for name, words, places, clearance in rows:
        made = partial(shaded, found.balance, effect, places, clearance)
        found.fixed(f"shadow-{name}", f"the shadow is {words}", LOADS, made)


def shaded(b: Balance, effect: SolarPressureEffect, places: Places, clearance: Clearance) -> Array:
    """Rows (n - 1, c) of another shadow; NaN in the intervals in which its edge lies."""

    def lit(e: Equations) -> Array:
        seen = (e.states.com[:, None] + places(e)) * np.conj(effect.sun_direction(e.states.t_s[:, None]))  # type: ignore[arg-type]  # of each state
        found: Array = np.where(clearance(seen) >= 0.0, 1.0, 0.0)
        return found

    at_samples = lit(type(b.equations)(b.scene, b.motion.states))
    edges = np.nonzero((at_samples[1:] != at_samples[:-1]).any(axis=1))[0].tolist()
    other = Balance(b.motion, b.scene, sorted({*b.hidden, *edges}), ENDS, b)
    e = other.equations
    mode = effect.mode(e.rows)
    bright = e.load_of(effect.accelerations(e.rows, np.concatenate([np.ones_like(mode[..., :1]), mode[..., 1:]], -1)))
    found = other.rows(bright._replace(force=bright.force * (lit(e) - mode[..., :1])))
    found[~other.rule.known] = np.nan
    return found


def of_oblateness(e: Equations, effect: OblatenessEffect, right: Load) -> Rows:
    """J2 at the joints, on mean masses, with its axis in the plane."""
    s, m = e.states, e.model
    for side, arm, _ in joints(e):
        words = f"force of the oblateness is that at the bars' {side} ends, in the joints, not at their centres"
        seen = e.load_of(effect.accelerations(at_place(e, arm), None))
        yield f"oblateness-of-{side}-joints", words, seen._replace(torque=right.torque)

    def field(z: ComplexArray, pole: complex) -> ComplexArray:
        up = (np.conj(pole) * z).real / abs(z)
        way = z * (1.0 - 5.0 * up**2) + 2.0 * up * abs(z) * pole
        found: ComplexArray = -3.0 * effect.strength_m5_s2 / abs(z) ** 5 * way
        return found

    place = s.com[:, None] + e.place
    for axis, pole in (("z1", 1.0), ("z2", 1j)):
        forces = e.force(m.mass_kg * field(place, pole))
        step = SEEN * abs(place) * s.unit
        slope = (field(place + step, pole) - field(place - step, pole)) / (2.0 * abs(step))
        torque = m.inertia_kg_m2 * (s.unit.conj() * slope).imag
        words = f"oblateness has its axis in the plane, along {axis}, not across it"
        yield f"oblateness-axis-{axis}", words, forces._replace(torque=torque)
        yield f"oblateness-axis-{axis}-in-force", f"{words}, in its force", forces._replace(torque=right.torque)


def of_third_body(e: Equations, effect: ThirdBodyEffect, right: Load, who: str) -> Rows:
    """Torques of a third body's gradient in other axes."""
    s = e.states
    towards = s.com[:, None] + e.place - effect.body_position(s.t_s[:, None])  # type: ignore[arg-type]  # of each state
    strength = 3.0 * effect.mu_m3_s2 * e.model.inertia_kg_m2 / abs(towards) ** 3
    way, up = towards / abs(towards), (s.com[:, None] + e.place) / abs(s.com[:, None] + e.place)
    seen, radial = s.unit.conj() * way, s.unit.conj() * up
    name = f"third-body-{who.lower().replace(' ', '-')}-torque"
    for ending, words, product in (
        ("of-radius", "takes the direction of the central body, not that of its own", radial.real * radial.imag),
        ("of-inertial-axes", "takes inertial axes, not the bar's", way.real * way.imag),
        ("along-twice", "has the square of the part along the bar, not the product of both parts", seen.real**2),
        ("across-twice", "has the square of the part across the bar, not the product of both parts", seen.imag**2),
    ):
        torque = strength * product if effect.turns else e.zero.torque
        yield f"{name}-{ending}", f"torque of the {who} {words}", right._replace(torque=torque)


def on_free_bars(b: Balance) -> Array:
    """Rows (n - 1, c) of impulses that turn the struck bar alone, by its own moment of inertia, without reactions."""
    shape, n = b.shape, b.motion.states.bars
    found = np.zeros((len(b.motion.states.t_s) - 1, b.width))
    for k, push in b.impulses:
        given = np.zeros(b.width)
        b.subtract_impulse(given, push, k)  # less the momenta that a chain gets
        s, bar = dataclasses.replace(b.motion.states.at(np.array([k])), angle=b.angles[push.at_s][None]), push.bar - 1
        way = np.exp(1j * push.direction_rad) * (s.unit[0, bar] if push.axes is Axes.BODY else 1.0)
        arm = shape.right[bar] if push.end.sign > 0.0 else -shape.left[bar]
        torque = arm * push.impulse_N_s * (s.unit[0, bar].conj() * way).imag
        jump = (np.arange(n) == bar) * torque / shape.inertia[bar]
        matrix = shape.coupled(s)[0] + np.diag(shape.inertia)
        found[k, b.columns[BARS]] += matrix @ jump + given[b.columns[BARS]]
        if JOINTS in b.columns:
            moved = np.cumsum(shape.mass * shape.centres(1j * s.unit * jump), axis=1)[:, :-1]
            found[k, b.columns[JOINTS]] += real(moved)[0] + given[b.columns[JOINTS]]
    return b.without_motors(found)
