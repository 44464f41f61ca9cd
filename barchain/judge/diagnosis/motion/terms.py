"""Terms of the equations of motion that an engine may have wrong, each alone: loads, their parts, bars and sides."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.candidate import (
    BODIES,
    GRAVITY,
    LOADS,
    Candidate,
    Candidates,
    is_own_gravity,
    uniform_words,
)
from barchain.judge.diagnosis.motion.equations import Load
from barchain.judge.diagnosis.motion.stray import stray

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from barchain.judge.diagnosis.motion.balance import Balance

NAMES = {
    "quadrupole": "force of the central field on the bars' second moments",
    "slender": "gravity on slender bars beyond that on point masses",
}
"""Nouns of effects whose names are none"""
BODY_WORDS = {"moon": "Moon", "sun": "Sun"}


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
    if b.scene.effects.joint_spring_damper is not None:
        springs_and_dampers(found)
    velocity_terms(found)
    stray(found)
    return found.found


def pieces(b: Balance) -> Iterator[tuple[str, str, Load]]:
    """Each load of the right equations but those in the joints, with its name and section."""
    e = b.equations
    yield "the tidal force", GRAVITY, e.tide
    yield "the torque of the gravity gradient", GRAVITY, e.gradient
    thrusts, bodies = iter(range(len(b.scene.effects.thrust))), iter(b.scene.effects.third_body)
    pushes = []
    for effect, load in zip(e.model.effects, e.effects, strict=True):
        if effect.name == "thrust":
            pushes.append(load)
            number = next(thrusts) + 1
            yield f"the thrust {number}" if len(b.scene.effects.thrust) > 1 else "the thrust", LOADS, load
        elif effect.name == "third_body":
            body = next(bodies).name
            yield f"the attraction of the {BODY_WORDS.get(body, body)} as third body", LOADS, load
        elif effect.name != "joint_spring_damper":
            yield f"the {NAMES.get(effect.name, effect.name.replace('_', ' '))}", LOADS, load
    if len(pushes) > 1:
        yield "the sum of all thrusts", LOADS, summed(pushes)


def summed(loads: Sequence[Load]) -> Load:
    """Sum of loads."""
    found = loads[0]
    for load in loads[1:]:
        found = found.plus(load)
    return found


def named(label: str) -> str:
    """Name of a label: its words with hyphens."""
    return "-".join(label.removeprefix("the ").replace("'", "").lower().split())


def of_piece(found: Candidates, label: str, section: str, load: Load) -> None:
    """Wrong forms of one load."""
    b, e, name = found.balance, found.balance.equations, named(label)
    found.times(name, f"{label} is", section, load)
    has_force = bool(load.force.any())
    if has_force and load.torque.any():
        found.times(f"{name}-torque", f"the torque of {label} is", section, e.torque(load.torque))
        found.times(f"{name}-force", f"the force of {label} is", section, load._replace(torque=e.zero.torque))
    if has_force and load.common.any():
        common = e.zero._replace(common=load.common)
        found.times(f"{name}-common", f"the part of {label} that all bars have in common is", section, common)
        words = f"{label} acts on all bars as at the chain's centre of mass"
        found.fixed(f"{name}-at-centre", words, section, Load(e.zero.common, -load.force, -load.torque))
    acting = np.nonzero(load.acts)[0].tolist()
    for bar in acting if len(acting) > 1 else ():
        found.times(f"{name}-on-bar-{bar + 1}", f"{label} on bar {bar + 1} is", section, load.on(bar))
    if has_force and "thrust" not in label:
        at_ends(found, name, label, section, load)
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
    along = [found.balance.rows(e.zero._replace(common=np.full(k, way))) for way in (1.0 + 0.0j, 1j)]
    rows = np.stack(along, axis=-1)
    found.found.append(Candidate("uniform-gravity", GRAVITY, lambda: rows, uniform_words, nice=is_own_gravity))


def simplified_tide(found: Candidates) -> None:
    """Tides of first order."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    r, mu = abs(s.com)[:, None], e.model.mu_m3_s2
    up = s.com[:, None] / r
    shape = e.place - 3.0 * up * (up.conj() * e.place).real
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
        (
            "of-start",
            mu / start**3 * both,
            "has the mean motion of a circular orbit at the start, from mu over r0 cubed",
        ),
        ("of-mean-motion", b.scene.mean_motion_rad_s**2 * both, "has the mean motion of the orbit at the start"),
        ("of-orbital-rate", b.scene.orbital_rate_rad_s**2 * both, "has the orbital rate v0/r0 for the mean motion"),
        ("of-longitude", turning * both, "has the rate of the longitude for the mean motion"),
        ("of-slender-bars", n2 * slender * both, "is that of slender bars, without the given moments of inertia"),
        ("of-sine", n2 * seen.real, "has the sine of the angle without the cosine"),
        ("of-cosine", n2 * seen.imag, "has the cosine of the angle without the sine"),
        ("of-angle", n2 * np.arcsin(np.clip(seen.real, -1.0, 1.0)), "is linear in the angle"),
    ):
        change = e.torque(3.0 * product * b.shape.inertia - e.gradient.torque)
        found.fixed(f"gradient-{name}", f"the torque of the gravity gradient {words}", GRAVITY, change)


def springs_and_dampers(found: Candidates) -> None:
    """Springs and dampers of all joints and of one, their rest angles, their sides, and other laws."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    given = b.scene.effects.joint_spring_damper
    assert given is not None
    k, c, rest = (np.array(v) for v in (given.stiffness_N_m_rad, given.damping_N_m_s_rad, given.rest_rad))
    bent, turning, joints = np.diff(s.angle, axis=1), np.diff(s.rate, axis=1), range(s.bars - 1)
    torques = {"spring": k * (bent - rest), "damper": c * turning, "rest angle": -k * rest + 0.0 * bent}
    for one, torque in torques.items():
        each = [e.on_joint(j, torque[:, j]) for j in joints]
        name = named(one)
        found.times(f"{name}s", f"the joints' {one}s are", LOADS, summed(each))
        for side, where in ((0, "before"), (1, "after")):
            half = summed([load.on(j + side) for j, load in enumerate(each)])
            found.times(f"{name}s-{where}", f"the torque of the {one}s on the bar {where} the joint is", LOADS, half)
        for j in joints if len(each) > 1 else ():
            found.times(f"{name}-{j + 1}", f"the {one} of joint {j + 1} is", LOADS, each[j])
            for bar in (j, j + 1):
                words = f"the torque of the {one} of joint {j + 1} on bar {bar + 1} is"
                found.times(f"{name}-{j + 1}-on-bar-{bar + 1}", words, LOADS, each[j].on(bar))
    whole = [e.on_joint(j, (torques["spring"] + torques["damper"])[:, j]) for j in joints]
    own = summed([e.on_joint(j, torques["damper"][:, j]) for j in joints])
    for side, where, alone in ((0, "before", s.rate[:, 1:]), (1, "after", -s.rate[:, :-1])):
        lost = summed([load.on(j + side).times(-1.0) for j, load in enumerate(whole)])
        words = f"the springs and dampers have no torque on the bar {where} the joint"
        found.fixed(f"springs-without-bar-{where}", words, LOADS, lost)
        one_rate = summed([e.on_joint(j, (c * alone)[:, j]) for j in joints])
        other = "after" if side == 0 else "before"
        words = (
            f"the dampers take the inertial rate of the bar {other} the joint alone, not the difference of both rates"
        )
        found.fixed(f"dampers-of-bar-{other}", words, LOADS, one_rate.plus(own.times(-1.0)))
    inertial = e.torque(-(np.pad(c, (0, 1)) + np.pad(c, (1, 0))) * s.rate).plus(own.times(-1.0))
    found.fixed("dampers-by-inertial-rates", "the dampers act on the bars' inertial rates, not on their differences",
                LOADS, inertial)  # fmt: skip
    for name, angle, words in (("", bent, ""), ("-from-rest", bent - rest, "from their rest ")):
        lost_turns = -k * 2.0 * math.pi * np.round(angle / (2.0 * math.pi))
        jumps = summed([e.on_joint(j, lost_turns[:, j]) for j in joints])
        found.fixed(f"springs-wrapped{name}", f"the springs' angles {words}are wrapped to half a turn either way",
                    LOADS, jumps)  # fmt: skip


def velocity_terms(found: Candidates) -> None:
    """Terms of the rates squared, which couple the bars."""
    b, e, s = found.balance, found.balance.equations, found.balance.equations.states
    if s.bars == 1:
        return
    found.times("centrifugal", "the centrifugal torque of the bars' rates squared is", BODIES,
                lambda: b.bar_rows(b.shape.centrifugal(s)))  # fmt: skip
    found.times("kinetic-slope", "the slope of the kinetic energy with the angles is", BODIES,
                lambda: b.bar_rows(b.shape.kinetic_slope(s)))  # fmt: skip
    from_root = np.tril(np.tile(b.shape.left + b.shape.right, (s.bars, 1)), -1) + np.diag(b.shape.left)
    pull = b.shape.mass * ((s.unit * s.rate**2) @ from_root.T)
    words = "the velocity-dependent terms (centrifugal and Coriolis', of all bars from the first bar's end on) are"
    found.times("velocity-terms", words, BODIES, e.force(pull))
