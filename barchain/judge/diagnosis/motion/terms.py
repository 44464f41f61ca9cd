"""Terms of the equations of motion that an engine may have wrong, each alone: loads, their parts, bars and sides."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.balance import BARS, JOINTS, real
from barchain.judge.diagnosis.motion.candidate import Candidate, Candidates
from barchain.judge.diagnosis.motion.effect_terms import effect_terms
from barchain.judge.diagnosis.motion.kinetics import at_joint, kinetic_terms
from barchain.judge.diagnosis.motion.models import models
from barchain.judge.diagnosis.motion.numbers import body_words
from barchain.judge.diagnosis.motion.set_points import motor_words
from barchain.judge.diagnosis.motion.words import BODIES, GRAVITY, LOADS, NICE, named

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.balance import Balance
    from barchain.judge.equations import Load
    from reference_impl.model.arrays import ComplexArray

NAMES = {
    "quadrupole": "force of the central field on the bars' second moments",
    "slender": "gravity on slender bars beyond that on point masses",
}
"""Nouns of effects whose names are none"""
ENDS = ((1.0, "first"), (-1.0, "last"))
"""Bars from which reactions are summed"""
AXIS_SHARE = 1e-3
"""Share of a uniform field across an axis from which on its direction is told by components"""


def terms(b: Balance) -> list[Candidate]:
    """All terms of a balance."""
    found = Candidates(b)
    for label, section, load in pieces(b):
        if load.acts.any() or load.common.any():
            of_piece(found, label, section, load)
    uniform_field(found)
    if b.equations.model.gravity != "none":
        simplified_tide(found)
    if b.equations.model.gravity == "gradient":
        simplified_gradient(found)
    for body, who in zip(b.scene.effects.third_body, body_words(b.scene), strict=True):
        place = body.distance_m * np.exp(1j * (body.longitude_rad + body.rate_rad_s * b.equations.states.t_s))
        fall = b.equations.zero._replace(common=-body.mu_m3_s2 * place / abs(place) ** 3)
        words = f"the fall of the central body towards the {who}, relative to which the track is, is"
        found.times(f"third-body-{named(who)}-indirect", words, LOADS, fall)
    effect_terms(found)
    models(found)
    damping(found)
    on_bars(found)
    if b.scene.bars > 1:
        kinetic_terms(found)
        in_joints(found)
    return found.found


def pieces(b: Balance) -> Iterator[tuple[str, str, Load]]:
    """Each load of the right equations but those in the joints, with its name and section."""
    e = b.equations
    yield "the tidal force", GRAVITY, e.tide
    yield "the torque of the gravity gradient", GRAVITY, e.gradient
    bodies, several = iter(body_words(b.scene)), len(b.scene.effects.thrust) > 1
    motors = iter(motor_words(b.scene))
    thrusts: list[Load] = []
    pulls: list[Load] = []
    for effect, load in zip(e.model.effects, e.effects, strict=True):
        if effect.name == "thrust":
            thrusts.append(load)
            yield f"the thrust {len(thrusts)}" if several else "the thrust", LOADS, load
        elif effect.name == "joint_torque":
            yield f"the torque of the {next(motors)}", LOADS, load
        elif effect.name == "third_body":
            pulls.append(load)
            yield f"the attraction of the {next(bodies)}", LOADS, load
        elif effect.name != "joint_spring_damper":
            yield f"the {NAMES.get(effect.name, effect.name.replace('_', ' '))}", LOADS, load
    if several:
        yield "the sum of all thrusts", LOADS, sum_of(e.zero, thrusts)
    if len(pulls) > 1:
        yield "the attraction of all third bodies", LOADS, sum_of(e.zero, pulls)


def sum_of(zero: Load, loads: list[Load]) -> Load:
    """Sum of loads."""
    for load in loads:
        zero = zero.plus(load)
    return zero


def of_piece(found: Candidates, label: str, section: str, load: Load) -> None:
    """Wrong forms of one load."""
    b, e, name = found.balance, found.balance.equations, named(label)
    found.times(name, f"{label} is", section, load)
    has_force = bool(load.force.any())
    if has_force and load.torque.any():
        found.times(f"{name}-torque", f"the torque of {label} is", section, e.torque(load.torque))
        found.times(f"{name}-force", f"the force of {label} is", section, load._replace(torque=e.zero.torque))
    if has_force:
        unit = e.states.unit
        along = unit * (unit.conj() * load.force).real
        for way, force in (("along", along), ("across", load.force - along)):
            found.times(f"{name}-{way}-bars", f"the force of {label} {way} the bars is", section, e.force(force))
    if has_force and load.common.any():
        common = e.zero._replace(common=load.common)
        found.times(f"{name}-common", f"the part of {label} that all bars have in common is", section, common)
        words = f"{label} acts on all bars as at the chain's centre of mass"
        uniform = load._replace(common=e.zero.common).times(-1.0)
        found.fixed(f"{name}-at-centre", words, section, uniform)
        if load.torque.any():
            words = f"the force of {label} acts on all bars as at the chain's centre of mass"
            found.fixed(f"{name}-force-at-centre", words, section, uniform._replace(torque=e.zero.torque))
    acting = np.nonzero(load.acts)[0].tolist()
    for bar in acting if len(acting) > 1 else ():
        found.times(f"{name}-on-bar-{bar + 1}", f"{label} on bar {bar + 1} is", section, load.on(bar))
    if "thrust" not in label:
        if has_force:
            at_ends(found, name, label, section, load)
    elif b.scene.bars > 1:
        moved = load._replace(force=np.roll(load.force, 1, axis=1), torque=np.roll(load.torque, 1, axis=1))
        words = f"force and torque of {label} are added to the next bar"
        found.fixed(f"{name}-added-to-next-bar", f"the {words}", section, moved.plus(load.times(-1.0)))
    if label == "the tidal force":
        whole = load._replace(force=load.force + b.shape.mass * e.centre[:, None])
        at_ends(found, "gravity", "the gravity", section, whole)


def at_ends(found: Candidates, name: str, label: str, section: str, load: Load) -> None:
    """A load whose force acts at the bars' ends: the torque that it has there."""
    b, e = found.balance, found.balance.equations
    for arm, where in ((-b.shape.left, "left"), (b.shape.right, "right")):
        torque = arm * (e.states.unit.conj() * load.force).imag
        words = f"{label} acts at the bars' {where} ends, in the joints, instead of their centres"
        found.fixed(f"{name}-at-{where}-ends", words, section, e.torque(torque))


def uniform_field(found: Candidates) -> None:
    """The same acceleration everywhere: a library's own gravity."""
    e, k = found.balance.equations, len(found.balance.equations.states.t_s)

    def rows() -> Array:
        along = [found.balance.rows(e.zero._replace(common=np.full(k, way))) for way in (1.0 + 0.0j, 1j)]
        return np.stack(along, axis=-1)

    found.found.append(Candidate("uniform-gravity", GRAVITY, rows, uniform_words, nice=is_own_gravity))


def uniform_words(amount: Array) -> str:
    """Words for a uniform field (2,) m/s²."""
    size, parts = float(np.hypot(*amount)), [(v, f"z{k + 1}") for k, v in enumerate(amount.tolist())]
    along = [f"{'+' if v > 0.0 else '-'}{axis}" for v, axis in parts if abs(v) > AXIS_SHARE * size]
    way = f"along {along[0]}" if len(along) == 1 else f"({parts[0][0]:.4g}, {parts[1][0]:.4g}) m/s^2"
    own = ": the engine's own gravity is left on" if is_own_gravity(amount) else ""
    return f"the motion has a uniform gravity of {size:.5g} m/s^2 {way}{own}"


def is_own_gravity(amount: Array) -> bool:
    """Whether a uniform field is that of the Earth's surface, with which libraries begin."""
    return any(abs(float(np.hypot(*amount)) / g - 1.0) < NICE for g in (9.81, 9.80665, 9.8, 10.0))


def simplified_tide(found: Candidates) -> None:
    """Tides of first order."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    r, mu = abs(s.com)[:, None], e.model.mu_m3_s2
    up = s.com[:, None] / r
    shape = e.place - 3.0 * up * (up.conj() * e.place).real
    along = up * (up.conj() * e.tide.force).real
    for name, part in (("along", along), ("across", e.tide.force - along)):
        found.times(f"tide-{name}", f"the part of the tidal force {name} the vertical is", GRAVITY, e.force(part))
    first = 2.0 * mu / r**3 * b.shape.mass * up * (up.conj() * e.place).real
    words = "the part along the vertical of the tidal force, expanded to the first order, is"
    found.times("tide-first-order-along", words, GRAVITY, e.force(first))
    seen = s.com[:, None] + e.place
    closer = np.log1p(((2.0 * s.com[:, None] + e.place).conj() * e.place).real / r**2)  # log of |R + d|²/R²
    for name, power, far, what in (
        ("power-of-one", 1.0, seen, "of Encke's form has the power 1 of the squared distance, not 3/2"),
        ("of-centre", 1.5, s.com[:, None], "of Encke's form multiplies the place of the centre, not the bar's"),
    ):
        form = e.force(-mu / r**3 * b.shape.mass * (e.place + np.expm1(-power * closer) * far))
        found.fixed(
            f"tide-encke-{name}", f"the factor in the tidal force {what}", GRAVITY, form.plus(e.tide.times(-1.0))
        )
    for name, n2, words in (
        ("first-order", mu / r**3, "is expanded to the first order only"),
        ("of-start", mu / abs(b.motion.states.com[0]) ** 3, "is of first order, with the mean motion at the start"),
    ):
        change = e.force(-n2 * b.shape.mass * shape).plus(e.tide.times(-1.0))
        found.fixed(f"tide-{name}", f"the tidal force {words}", GRAVITY, change)


def simplified_gradient(found: Candidates) -> None:
    """Torques of the gravity gradient with another rate, angle, place or moment of inertia."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    mu, place, r, start = e.model.mu_m3_s2, s.com[:, None] + e.place, abs(s.com)[:, None], abs(b.motion.states.com[0])
    seen, here = s.unit.conj() * place / abs(place), s.unit.conj() * s.com[:, None] / r
    n2, both = mu / abs(place) ** 3, seen.real * seen.imag
    slender = b.shape.mass * (b.shape.left + b.shape.right) ** 2 / 12.0 / b.shape.inertia
    turning = ((s.velocity * s.com.conj()).imag[:, None] / r**2) ** 2
    for name, product, words in (
        ("at-centre", mu / r**3 * here.real * here.imag, "is that at the chain's centre of mass"),
        ("of-centre-distance", mu * abs(place) ** 2 / r**5 * both,
         "has the distance of the chain's centre of mass, not the bar's"),
        ("of-start", mu / start**3 * both,
         "has the mean motion of a circular orbit at the start, from mu over r0 cubed"),
        ("of-mean-motion", b.scene.mean_motion_rad_s**2 * both, "has the mean motion of the orbit at the start"),
        ("of-orbital-rate", b.scene.orbital_rate_rad_s**2 * both, "has the orbital rate v0/r0 for the mean motion"),
        ("of-longitude", turning * both, "has the rate of the longitude for the mean motion"),
        ("of-slender-bars", n2 * slender * both, "is that of slender bars, without the given moments of inertia"),
        ("of-first-bar", n2 * b.shape.inertia[0] / b.shape.inertia * both,
         "has the first bar's moment of inertia on all bars"),
        ("of-next-bar", n2 * np.roll(b.shape.inertia, -1) / b.shape.inertia * both,
         "has the next bar's moment of inertia"),
        ("of-previous-bar", n2 * np.roll(b.shape.inertia, 1) / b.shape.inertia * both,
         "has the previous bar's moment of inertia"),
        ("of-sine", n2 * seen.real, "has the sine of the angle without the cosine"),
        ("of-cosine", n2 * seen.imag, "has the cosine of the angle without the sine"),
        ("of-angle", n2 * np.arcsin(np.clip(seen.real, -1.0, 1.0)), "is linear in the angle"),
    ):  # fmt: skip
        change = e.torque(3.0 * product * b.shape.inertia - e.gradient.torque)
        found.fixed(f"gradient-{name}", f"the torque of the gravity gradient {words}", GRAVITY, change)


def damping(found: Candidates) -> None:
    """Damping of all velocities and rates, as engines for games add it."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    turning, drift = e.torque(-b.shape.inertia * s.rate), e.force(-b.shape.mass * e.drift)
    share = "damped by a share of {} in a second"
    for name, words, load in (
        ("angular-damping", f"the bars' rates are {share}", turning),
        ("linear-damping", f"the bars' velocities relative to the centre of mass are {share}", drift),
        ("body-damping", f"the bars' rates and velocities are {share}", turning.plus(drift)),
        ("track-damping", f"the velocity of the centre of mass is {share}", e.zero._replace(common=-s.velocity)),
    ):
        found.added(name, words, "", LOADS, load)
    words = "the bars' inertial rates have a damping of {} each"
    found.added("rate-damping", words, "N m s/rad", LOADS, e.torque(-s.rate))


def on_bars(found: Candidates) -> None:
    """Torques on single bars: damping against inertial axes, a constant, more inertia."""
    b, e, s, own = found.balance, found.balance.equations, found.balance.equations.states, found.balance.motion.states
    for bar in range(s.bars):
        one = 1.0 * (np.arange(s.bars) == bar)
        where = "root joint, of bar 1" if bar == 0 else f"bar {bar + 1}"
        found.added(f"damping-of-bar-{bar + 1}", f"the {where} against inertial axes, has a damping of {{}}",
                    "N m s/rad", LOADS, e.torque(-one * s.rate))  # fmt: skip
        found.added(f"torque-on-bar-{bar + 1}", f"the bar {bar + 1} has a constant torque of {{}}", "N m", LOADS,
                    e.torque(one + 0.0 * s.rate))  # fmt: skip
        if s.bars > 1:
            found.added(f"inertia-of-bar-{bar + 1}", f"the bar {bar + 1} has an additional moment of inertia of {{}}",
                        "kg m^2", BODIES, partial(b.block, BARS, -one * np.diff(own.rate, axis=0)))  # fmt: skip


def in_joints(found: Candidates) -> None:
    """Torques in all joints, or in one, that no scene has."""
    e, s = found.balance.equations, found.balance.equations.states
    bent, turning = np.diff(s.angle, axis=1), np.diff(s.rate, axis=1)
    more = "more" if found.balance.scene.effects.joint_spring_damper else "that the scene lacks"
    for name, what, unit, values in (
        ("friction", "a friction (damping)", "N m s/rad", turning),
        ("stiffness", "a stiffness", "N m/rad", bent),
        ("dry-friction", "a dry friction", "N m", np.sign(turning)),
        ("bias", "a constant torque", "N m", np.ones_like(turning)),
    ):
        said = f"have {what} of {{}} {more}"
        found.added(f"joint-{name}", f"the joints {said}", unit, LOADS, e.on_joints(values))
        for j in range(s.bars - 1) if s.bars > 2 else ():
            words = f"the joint {j + 1} has{said.removeprefix('have')}"
            found.added(f"joint-{j + 1}-{name}", words, unit, LOADS, e.on_joints(at_joint(values, j)))


def of_reactions(b: Balance) -> list[Candidate]:
    """Candidates that act in the reactions alone."""
    found = Candidates(b)
    for label, section, load in pieces(b):
        if load.acts.any():
            words = f"the reactions lack {label}: their equations are solved without this load"
            found.fixed(f"reactions-without-{named(label)}", words, section, partial(response, b, load))
        for side, end in ENDS if load.force.any() else ():
            words = f"the reactions, summed from the {end} bar, lack {label}"
            found.fixed(f"reactions-from-{end}-without-{named(label)}", words, section, partial(summed, b, load, side))
            words = f"the acceleration of the centre of mass by {label}, in the reactions from the {end} bar, is"
            found.times(f"reactions-from-{end}-moved-by-{named(label)}", words, section, partial(moved, b, load, side))
    mass, bars = np.array(b.scene.chain.mass_kg), b.scene.bars
    for name, words, other in (
        ("reversed", "in reversed order", mass[::-1]),
        ("mean", "all the mean mass", np.full(bars, b.scene.mass_kg / bars)),
        ("first", "all the first bar's", np.full(bars, mass[0])),
    ):
        for side, end in ENDS:
            found.fixed(f"reactions-with-masses-{name}-from-{end}", f"the masses are {words} in the reactions alone",
                        BODIES, partial(with_masses, b, other / mass, side))  # fmt: skip
    return found.found


def response(b: Balance, load: Load) -> Array:
    """Reactions to a load, integrated: of the accelerations that it gives, less the load itself."""
    s, shape = b.equations.states, b.shape
    matrix = shape.coupled(s) + np.diag(shape.inertia)
    turning = np.linalg.solve(matrix, shape.generalised(s, load)[..., None])[..., 0]
    moved: ComplexArray = shape.mass * shape.centres(1j * s.unit * turning)
    summed_up: ComplexArray = np.cumsum(moved - shape.apart(load.force), axis=1)[:, :-1]
    return b.block(JOINTS, real(b.rule.integral(summed_up)))


def summed(b: Balance, load: Load, side: float) -> Array:
    """Load summed over the bars before each joint (side 1) or after it (-1), integrated, with the opposite sign."""
    before: ComplexArray = np.cumsum(load.force, axis=1)
    found: ComplexArray = -before[:, :-1] if side > 0.0 else before[:, -1:] - before[:, :-1]
    return b.block(JOINTS, real(b.rule.integral(found)))


def moved(b: Balance, load: Load, side: float) -> Array:
    """Momentum of the bars before each joint (side 1) or after it (-1) that moves with the centre of mass by a load."""
    share = b.shape.mass / b.shape.whole * load.force.sum(axis=1)[:, None]
    return summed(b, load._replace(force=share), side)


def with_masses(b: Balance, ratio: Array, side: float) -> Array:
    """Momentum gained by joint forces before (side 1) or after (-1) each joint, less that with other masses."""
    s, shape = b.motion.states, b.shape
    gained = shape.mass * np.diff(shape.centres(1j * s.unit * s.rate), axis=0)
    each = (1.0 - ratio) * (gained - b.rule.integral(shape.apart(b.equations.total.force)))
    before = np.cumsum(each, axis=1)
    return b.block(JOINTS, real(before[:, :-1] if side > 0.0 else before[:, :-1] - before[:, -1:]))
