"""Reasons why a fault changes nothing in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenarios import Actuator, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import NotApplicable
    from scenarios import Scene


def first_of(*reasons: NotApplicable) -> NotApplicable:
    """First reason that holds."""
    return lambda solution: next((said for reason in reasons if (said := reason(solution))), "")


def where(holds: Callable[[Scene], bool], otherwise: str) -> NotApplicable:
    """Scenes in which something holds; the reason of all others."""
    return lambda solution: "" if holds(solution.scene) else otherwise


def needs(effect: str, words: str) -> NotApplicable:
    """Scenes that call for an effect, by its name in `Effects`."""
    return where(lambda scene: bool(getattr(scene.effects, effect)), f"no {words}")


def papers_own(solution: ReferenceSolution) -> str:
    """Scenes that the paper's equations cover."""
    called = solution.scene.effects
    if called.gravity is not Gravity.GRADIENT:
        return "the paper's form has gradient gravity alone"
    if solution.scene.chain.com_share:
        return "the paper's bars have their centres of mass midway"
    plain = called.names <= {"gravity.gradient", "impulse"} | {n for n in called.names if n.startswith("prescribed")}
    return "" if plain else "effects that the paper's form has not"


def turned_around(solution: ReferenceSolution) -> str:
    """Scenes whose angles leave (-pi, pi]."""
    angle = solution.trajectory.angle_rad
    return "" if angle is not None and np.abs(angle).max() > np.pi else "no angle leaves (-180°, 180°]"


def lands(solution: ReferenceSolution) -> str:
    """Scenes whose chain reaches the surface."""
    return "" if solution.trajectory.ended else "no bar reaches the surface"


def impulses(solution: ReferenceSolution) -> str:
    """Scenes in which something strikes before the end."""
    struck = solution.trajectory.impulse_N_s
    return "" if struck is not None and np.any(struck) else "no impulse"


def shadow(solution: ReferenceSolution) -> str:
    """Scenes in which the chain is in the shadow at some sample."""
    light = solution.scene.effects.solar_pressure
    if light is None or not light.shadow:
        return "no shadow"
    seen = solution.trajectory
    sun = np.exp(-1j * (light.sun_longitude_rad + light.sun_rate_rad_s * seen.t_s))
    place = sun * (seen.com_m[:, 0] + 1j * seen.com_m[:, 1])
    dark = (place.real < 0.0) & (np.abs(place.imag) < solution.scene.central_body.radius_m)
    return "" if dark.any() else "the chain stays in the light"


EXACT = (Gravity.QUADRUPOLE, Gravity.SLENDER)
"""Models of gravity with a force on bars besides a point mass's"""
joints = where(lambda scene: scene.bars > 1, "a single bar has no joints")
no_motor = where(
    lambda scene: all(p.actuator is not Actuator.JOINT for p in scene.effects.prescribed_rotation),
    "a motor in a joint needs the joint: no torque holds its law",
)
central_pull = where(lambda scene: scene.bars > 1, "a single bar falls straight to the body: beta·Y0'' is zero")
several_joints = where(lambda scene: scene.bars > 2, "fewer than two joints: no order")
gravity = where(lambda scene: scene.effects.gravity is not Gravity.NONE, "no gravity")
turning = where(lambda scene: scene.effects.gravity.turns, "gravity does not turn the bars")
inertia = where(lambda scene: scene.bars > 1, "a single bar turns by K/J, in which J cancels, and has no joints")
exact_bars = where(lambda scene: scene.effects.gravity in EXACT, "bars are pulled as point masses")
unequal = where(lambda scene: len(set(scene.chain.length_m)) > 1, "all bars are equally long")
flips = where(lambda scene: bool(scene.effects.drag or scene.effects.solar_pressure), "no faces or shadows to be met")
SLEW = needs("prescribed_rotation", "prescribed rotation")
