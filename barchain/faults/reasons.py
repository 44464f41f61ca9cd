"""Reasons why a fault changes nothing in a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenarios import Actuator, Gravity

if TYPE_CHECKING:
    from barchain.faults.fault import NotApplicable
    from barchain.solutions.reference import ReferenceSolution


def first_of(*reasons: NotApplicable) -> NotApplicable:
    """First reason that holds."""
    return lambda solution: next((said for reason in reasons if (said := reason(solution))), "")


def needs(effect: str, words: str) -> NotApplicable:
    """Scenes that call for an effect, by its name in `Effects`."""
    return lambda solution: "" if getattr(solution.scene.effects, effect) else f"no {words}"


def joints(solution: ReferenceSolution) -> str:
    """Scenes with joints."""
    return "" if solution.scene.bars > 1 else "a single bar has no joints"


def no_motor(solution: ReferenceSolution) -> str:
    """Scenes without motors in joints, which hold on to nothing where joints do not."""
    motors = any(p.actuator is Actuator.JOINT for p in solution.scene.effects.prescribed_rotation)
    return "a motor in a joint needs the joint: no torque holds its law" if motors else ""


def central_pull(solution: ReferenceSolution) -> str:
    """Scenes in which some bar's centre does not fall straight to the body's."""
    return "" if solution.scene.bars > 1 else "a single bar falls straight to the body: beta·Y0'' is zero"


def several_joints(solution: ReferenceSolution) -> str:
    """Scenes with joints to be mixed up."""
    return "" if solution.scene.bars > 2 else "fewer than two joints: no order"


def gravity(solution: ReferenceSolution) -> str:
    """Scenes with gravity."""
    return "no gravity" if solution.scene.effects.gravity is Gravity.NONE else ""


def turning(solution: ReferenceSolution) -> str:
    """Scenes whose gravity turns bars."""
    return "" if solution.scene.effects.gravity.turns else "gravity does not turn the bars"


def inertia(solution: ReferenceSolution) -> str:
    """Scenes whose motion depends on inertia."""
    return "" if solution.scene.bars > 1 else "a single bar turns by K/J, in which J cancels, and has no joints"


def exact_bars(solution: ReferenceSolution) -> str:
    """Scenes with the force on bars besides a point mass's."""
    exact = solution.scene.effects.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER)
    return "" if exact else "bars are pulled as point masses"


def papers_own(solution: ReferenceSolution) -> str:
    """Scenes that the paper's equations cover."""
    called = solution.scene.effects
    if called.gravity is not Gravity.GRADIENT:
        return "the paper's form has gradient gravity alone"
    plain = called.names <= {"gravity.gradient", "impulse"} | {n for n in called.names if n.startswith("prescribed")}
    return "" if plain else "effects that the paper's form has not"


def unequal(solution: ReferenceSolution) -> str:
    """Scenes with bars of different length."""
    return "all bars are equally long" if len(set(solution.scene.chain.length_m)) == 1 else ""


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


def rest_angles(solution: ReferenceSolution) -> str:
    """Scenes with springs that rest bent."""
    springs = solution.scene.effects.joint_spring_damper
    return "" if springs and any(springs.rest_rad) else "no spring rests bent"


def flips(solution: ReferenceSolution) -> str:
    """Scenes with faces and shadows to be met."""
    called = solution.scene.effects
    return "" if called.drag or called.solar_pressure else "no faces or shadows to be met"


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


SLEW = needs("prescribed_rotation", "prescribed rotation")
