"""Errors that a method makes in a step, before the motion carries them on: from its order, or what it is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters import steps
from adapters.engine import Coordinates, Knob

if TYPE_CHECKING:
    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.truth import Truth
    from scenarios import Scene

MODES_PER_BAR = 2.1  # fastest oscillation of a chain of N bars, over N times its rate (radial chain: 2.1 N n)
SECOND_ORDER = 2
SECOND_ORDER_CONSTANT = 1.0 / 8.0
"""Largest here: trapezoidal rule 1/12, generalized-alpha with rho = 0.9 about 1/10, half a step aside 1/8."""
HIGHER_ORDER_CONSTANT = 1.0 / 5040.0
"""A sixth-order explicit method: of the order of the first neglected Taylor term, h^6 x^(7)/7!."""


def orbit_scale(scene: Scene) -> float:
    """Rate of the orbit: its mean motion, or that of the circular orbit at r0 if faster."""
    return 2.0 * math.pi / scene.step_period_s


def rate_scale(scene: Scene, truth: Trajectory) -> float:
    """Fastest rate in the scene, rad/s: the chain's stiffest oscillation in its field or under its own spin."""
    spin = float(np.abs(truth.rate_rad_s).max()) if truth.rate_rad_s is not None else 0.0
    return MODES_PER_BAR * scene.bars * max(spin, scene.mean_motion_rad_s)


def step_s(scene: Scene, setting: Setting) -> float:
    """Step of a fixed-step engine, s."""
    return steps.step_s(scene, setting.value)


def kepler_growth(scene: Scene, t_s: Array) -> Array:
    """How a small error of the centre of mass grows, (n,): 1 + 3 n t, a period's error run along the track."""
    return 1.0 + 3.0 * orbit_scale(scene) * t_s


@dataclass(frozen=True)
class LocalErrors:
    """Errors that a method makes, before the motion carries them on; n samples."""

    attitude_rate: Array
    """(n,) rad a second"""
    com_rate: Array
    """(n,) m a second"""
    immediate: dict[str, Array]
    """(n,) errors of what is read off one step: reactions and torques that vary inside it"""


def local_errors(engine: type[Engine], scene: Scene, setting: Setting, truth: Truth) -> LocalErrors:
    """Local errors of a method: by its order and step, or by the accuracy it is asked for."""
    if setting.knob is Knob.RTOL:
        return requested_errors(scene, setting, truth)
    return truncation_errors(engine, scene, setting, truth)


def requested_errors(scene: Scene, setting: Setting, truth: Truth) -> LocalErrors:
    """A method that chooses its steps: the requested error in each, one step for each radian of the fastest rate.

    What it reads off the samples comes by dense output: its error is a step's once more.
    """
    n, made = len(truth.growth), setting.value
    reading = {name: made * response for name, response in truth.response.items()}
    if "rate" in reading:
        reading["rate"] = np.maximum(reading["rate"], made * orbit_scale(scene))
    track = made * scene.radius0_m
    return LocalErrors(
        np.full(n, made * rate_scale(scene, truth.trajectory)),
        np.full(n, track * orbit_scale(scene)),
        reading | {"com": np.full(n, track)},
    )


def truncation_errors(engine: type[Engine], scene: Scene, setting: Setting, truth: Truth) -> LocalErrors:
    """A fixed-step method of order p: C h^p times the derivative of order p+1, taken from the truth.

    Third derivatives come from the truth's samples, those above from the third by the fastest rate.
    In absolute coordinates the orbit's own error, run along the track, turns every local vertical. The
    track in a moving frame is the chain's departure from Kepler's, of order (L/r)² r.
    """
    seen, h, order = truth.trajectory, step_s(scene, setting), engine.order or 1.0
    n = len(truth.growth)
    t = seen.t_s[:n]
    constant = SECOND_ORDER_CONSTANT if order <= SECOND_ORDER else HIGHER_ORDER_CONSTANT
    power = constant * h**order * rate_scale(scene, seen) ** (order - SECOND_ORDER)
    track = power * second_derivative(t, seen.com_velocity_m_s[:n])
    turned = np.zeros(n)
    if engine.coordinates is Coordinates.ABSOLUTE:
        turned = track / scene.radius0_m * kepler_growth(scene, t)
    else:
        track = track * (scene.size_m / scene.radius0_m) ** 2
    turn, jerk = end_derivatives(engine, seen)
    if engine.coordinates is Coordinates.JOINT:  # the centre of mass is not a coordinate: it shares the angles' errors
        track = track + power * jerk[:n] * scene.size_m
    immediate = {"attitude": power * turn[:n]}
    for name, values in (
        ("rate", seen.rate_rad_s),
        ("reaction", seen.reaction_N),
        ("torque", seen.torque_N_m),
    ):
        if values is not None and values.size:
            immediate[name] = power * second_derivative(t, values[:n])
    if "rate" in immediate:
        immediate["rate"] = immediate["rate"] + power * jerk[:n]
    if "reaction" in immediate:  # forces that cancel in the exact motion do not in the discrete one
        force = max(scene.chain.mass_kg) * max(scene.chain.length_m) * turn[:n]
        immediate["reaction"] = immediate["reaction"] + power * force * turn[:n]
    return LocalErrors(power * jerk[:n] + turned, track, immediate)


def end_derivatives(engine: type[Engine], seen: Trajectory) -> tuple[Array, Array]:
    """Second and third time derivatives of a bar's end about its centre, over half its length, bounds, (n,) each.

    With w the rate: |w'| + w² and |w''| + 3 |w w'| + |w|³. In a frame that turns with the orbit, rates
    count from its own.
    """
    if seen.rate_rad_s is None:
        return np.zeros(len(seen.t_s)), np.zeros(len(seen.t_s))
    rate = seen.rate_rad_s
    if engine.coordinates is Coordinates.ROTATING_FRAME:
        rate = rate - orbit_rate(seen)[:, None]
    fastest = np.abs(rate).max(axis=1)
    turn = np.abs(np.gradient(rate, seen.t_s, axis=0)).max(axis=1)
    jerk = second_derivative(seen.t_s, rate)
    return turn + fastest**2, jerk + 3.0 * fastest * turn + fastest**3


def orbit_rate(seen: Trajectory) -> Array:
    """Rate of the longitude of the centre of mass, (n,), rad/s."""
    z, v = seen.com_m, seen.com_velocity_m_s
    rate: Array = (z[:, 0] * v[:, 1] - z[:, 1] * v[:, 0]) / np.sum(z * z, axis=1)
    return rate


def second_derivative(t_s: Array, values: Array) -> Array:
    """Largest second time derivative over all components, (n,), from samples."""
    if len(t_s) < 3:
        return np.zeros(len(t_s))
    twice = np.gradient(np.gradient(values, t_s, axis=0), t_s, axis=0)
    largest: Array = np.abs(twice).reshape(len(t_s), -1).max(axis=1)
    return largest


def kinks(engine: type[Engine], scene: Scene, setting: Setting, truth: Truth) -> dict[str, Array]:
    """What fixed steps may miss where a manoeuvre starts or ends inside one, (n,) for each quantity.

    The law's fourth derivative jumps there, so that what is missed depends on where in the step it falls and
    does not shrink from one setting to the next: one step's own error is allowed.
    """
    inside = [t for p in scene.effects.prescribed_rotation for t in p.breaks_s if 0.0 < t < scene.run.duration_s]
    if setting.knob is Knob.RTOL or not inside:
        return {}
    return {k: np.maximum.accumulate(e) for k, e in truncation_errors(engine, scene, setting, truth).immediate.items()}
