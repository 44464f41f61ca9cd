"""Every tolerance of the comparison, in one place, each with its derivation.

Two questions are asked of a difference from the truth, at every sample up to the horizon.

*Consistent?* It is explained by the two error estimates, round-off, and the declared model difference:
``explained = 2 (E_engine + E_truth) + floor + model``. The 2 is Richardson's: a method of order p >= 1 whose
finer setting halves the step is off by at most 1/(1 - 2^-p) <= 2 times its change.

*Good enough?* It is inside the band that the engine's method and setting promise on this scene, ``band``.

Both use the growth G(t) of a small perturbation, measured by the truth's twin: an error made at s is
G(t)/G(s) times as large at t.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from adapters.engine import Coordinates, Knob
from barchain.truth import PARTED_RAD

if TYPE_CHECKING:
    from adapters.engine import Array, Engine, Setting, Trajectory
    from barchain.truth import Truth
    from scenarios import Scene

RICHARDSON = 2.0  # see above
UNIT_ROUNDOFF = float(np.finfo(float).eps)
ROUNDINGS = 16.0  # rounding errors that enter a state in one step: a handful of operations, one for each stage
NORM_SLACK = 10.0  # largest component against norm, constants of the method other than the textbook's, stage effects
MODES_PER_BAR = 2.1  # fastest oscillation of a chain of N bars, over N times its rate (radial chain: 2.1 N n)

SECOND_ORDER = 2
SECOND_ORDER_CONSTANT = 1.0 / 8.0
"""Largest here: trapezoidal rule 1/12, generalized-alpha with rho = 0.9 about 1/10, half a step aside 1/8."""
HIGHER_ORDER_CONSTANT = 1.0 / 5040.0
"""A sixth-order explicit method: of the order of the first neglected Taylor term, h^6 x^(7)/7!."""


@dataclass(frozen=True)
class Derivation:
    """One tolerance, for the report."""

    quantity: str
    what: str
    value: str
    derivation: str


def rate_scale(scene: Scene, truth: Trajectory) -> float:
    """Fastest rate in the scene, rad/s: the chain's stiffest oscillation in its field or under its own spin."""
    spin = float(np.abs(truth.rate_rad_s).max()) if truth.rate_rad_s is not None else 0.0
    return MODES_PER_BAR * scene.bars * max(spin, scene.mean_motion_rad_s)


def step_s(scene: Scene, setting: Setting) -> float:
    """Step of a fixed-step engine, s."""
    return scene.period_s / setting.value


def steps_taken(scene: Scene, setting: Setting, seen: Trajectory) -> Array:
    """Steps taken up to each sample, (n,): counted by the engine, or from its setting."""
    share = seen.t_s / scene.run.duration_s
    if setting.knob is Knob.STEPS_PER_ORBIT:
        return 1.0 + share * scene.run.duration_s / step_s(scene, setting)
    return 1.0 + share * float(seen.info.get("steps", scene.run.samples))


def kepler_growth(scene: Scene, t_s: Array) -> Array:
    """How a small error of the centre of mass grows, (n,): 1 + 3 n t, a period's error run along the track."""
    return 1.0 + 3.0 * scene.orbital_rate_rad_s * t_s


def roundoff_unit(engine: type[Engine], scene: Scene) -> float:
    """Angle that one rounding of a position is worth, rad: u for lengths of a bar, u r/l for distances."""
    if engine.coordinates is Coordinates.ABSOLUTE:
        return UNIT_ROUNDOFF * scene.radius0_m / min(scene.chain.length_m)
    return UNIT_ROUNDOFF * scene.size_m / min(scene.chain.length_m)


def floors(engine: type[Engine], scene: Scene, setting: Setting, seen: Trajectory, truth: Truth) -> dict[str, Array]:
    """What round-off alone may contribute to each quantity, (n,): a random walk of the steps' roundings, amplified.

    On top comes what the engine declares of itself (`Engine.noise`): the tolerance of its iterations, and
    the noise of multipliers that are differences over a step.
    """
    n = common_samples(seen, truth)
    walk = ROUNDINGS * np.sqrt(steps_taken(scene, setting, seen)[:n])
    noise = engine.noise(scene, setting, truth.trajectory.t_s[:n])
    angle = (roundoff_unit(engine, scene) * walk + noise.get("attitude", 0.0)) * truth.growth[:n]
    angle = np.minimum(angle, RICHARDSON * PARTED_RAD)  # up to the horizon no attitude is off by more
    found = {
        name: angle * truth.response[name][:n] + rounded(truth.trajectory, name)[:n] + noise.get(name, 0.0)
        for name in truth.response
    }
    distance = np.maximum.accumulate(np.linalg.norm(truth.trajectory.com_m[:n], axis=1))
    found["com"] += UNIT_ROUNDOFF * distance * walk * kepler_growth(scene, truth.trajectory.t_s[:n])
    return found


def rounded(seen: Trajectory, quantity: str) -> Array:
    """Rounding of a value that is a sum over the bars, (n,): N terms of at most its own size."""
    values = {
        "attitude": seen.angle_rad,
        "rate": seen.rate_rad_s,
        "reaction": seen.reaction_N,
        "torque": seen.torque_N_m,
    }
    found = values.get(quantity)
    bars = 1 if seen.angle_rad is None else seen.angle_rad.shape[1]
    if found is None or not found.size:
        return np.zeros(len(seen.t_s))
    size = np.abs(found).reshape(len(seen.t_s), -1).max(axis=1)
    largest: Array = UNIT_ROUNDOFF * ROUNDINGS * bars * np.maximum.accumulate(size)
    return largest


def bands(engine: type[Engine], scene: Scene, setting: Setting, seen: Trajectory, truth: Truth) -> dict[str, Array]:
    """What the method promises at this setting, (n,) for each quantity, floors included.

    Errors of attitude made at s are carried to t by G(t)/G(s), and into the other quantities by the
    twin's measured response; the track of the centre of mass has its own local errors besides.
    """
    n = common_samples(seen, truth)
    t, growth = truth.trajectory.t_s[:n], truth.growth[:n]
    local = local_errors(engine, scene, setting, truth)
    # carried on: the error of the start (half a step aside), and all that are made on the way
    made = local.immediate["attitude"][0] + cumulative_trapezoid(local.attitude_rate[:n] / growth, t, initial=0)
    attitude = growth * made
    floor = floors(engine, scene, setting, seen, truth)
    parted = RICHARDSON * PARTED_RAD  # up to the horizon no attitude is off by more
    found = {}
    for name, response in truth.response.items():
        direct = np.maximum.accumulate(local.immediate[name][:n]) if name in local.immediate else 0.0
        carried = np.minimum(NORM_SLACK * attitude, parted)
        if name != "attitude":  # the twin parts in one direction; others may answer more strongly
            carried = NORM_SLACK * np.minimum(attitude, parted)
        found[name] = carried * response[:n] + NORM_SLACK * direct + floor[name]
    found["com"] += NORM_SLACK * cumulative_trapezoid(local.com_rate[:n], t, initial=0) * kepler_growth(scene, t)
    return found


def common_samples(seen: Trajectory, truth: Truth) -> int:
    """Number of samples that both have."""
    return min(len(seen.t_s), len(truth.growth))


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
    track = made * scene.radius0_m
    return LocalErrors(
        np.full(n, made * rate_scale(scene, truth.trajectory)),
        np.full(n, track * scene.orbital_rate_rad_s),
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
    track = power * scene.orbital_rate_rad_s**3 * scene.radius0_m
    turned = np.zeros(n)
    if engine.coordinates is Coordinates.ABSOLUTE:
        turned = track / scene.radius0_m * kepler_growth(scene, t)
    else:
        track *= (scene.size_m / scene.radius0_m) ** 2
    turn, jerk = end_derivatives(engine, seen)
    if engine.coordinates is Coordinates.JOINT:  # the centre of mass is not a coordinate: it shares the angles' errors
        track += power * float(jerk.max()) * scene.size_m
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
    return LocalErrors(power * jerk[:n] + turned, np.full(n, track), immediate)


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


def explained(own: dict[str, Array], setting: Setting, truth: Truth, floor: dict[str, Array]) -> dict[str, Array]:
    """What may stand between an engine and the truth if both are right, (n,) for each quantity.

    A method that chooses its steps halves nothing: between two of its runs a single sample's error falls
    only on the whole, so that one step's requested error is allowed besides.
    """
    n = min(map(len, own.values()))
    step = setting.value if setting.knob is Knob.RTOL else 0.0
    found = {}
    for name in own.keys() & truth.error.keys():
        both = np.maximum.accumulate(own[name][:n]) + truth.error[name][:n]
        found[name] = RICHARDSON * both + floor[name][:n] + step * truth.response[name][:n]
    if "com" in found:
        found["com"] += step * truth.scene.radius0_m
    return found
