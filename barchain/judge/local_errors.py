"""Errors of a method in a step, before the motion amplifies them: from its order, or from its requested accuracy."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import cumulative_trapezoid

from adapters.bar_loads.falling_frame import free_fall
from adapters.common.equal_steps import step_s
from adapters.common.initial_state import initial_state
from adapters.common.kepler import propagate
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Coordinates
from barchain.judge.scales import (
    MACHINE_EPSILON,
    ROUNDINGS,
    inertia_force_N,
    kepler_growth,
    orbit_rate_bound,
    orbit_scale,
)
from barchain.metrics.quantities import free_rate_scale, orbit_rate, own_rate, rate_scale
from barchain.solutions.reference import FINE_PER_RADIAN, RICHARDSON
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.kinematics import bar_centres
from scenarios import Gravity
from scenarios.effect_types import WITHOUT_FORCE

if TYPE_CHECKING:
    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

SECOND_ORDER = 2
SECOND_ORDER_CONSTANT = 1.0 / 8.0
"""Largest constant here: trapezoidal rule 1/12, generalized-alpha with rho = 0.9 about 1/10, half a step aside 1/8"""

MAX_STEP_CONSTANT = 10.0
"""Largest believed error of a step relative to its request: with more, the request means nothing"""
READING_REQUESTS = 10.0
"""Largest error of interpolation between a step's ends, relative to the step's request. An interpolant may be of one
order less than the step: the error of SciPy's RK45 was measured as four requests."""
DECAY_SAMPLES = 3
"""Samples at which the decay of joint motions is asked: stiff joints hardly move"""
MOST_DECAY_BARS = 50
"""Longest chain whose joint motions are asked for their decay: its eigenvalues take milliseconds"""
SAME_INSTANT = 1e-9
"""Largest relative difference of the instants of two samples that are meant to be the same"""


@dataclass(frozen=True)
class LocalErrors:
    """Errors that a method makes, before the motion amplifies them; n samples, m instants between them."""

    t_s: Array
    """(m,) s"""
    attitude_rate: Array
    """(m,) rad a second"""
    com_rate: Array
    """(m,) m a second"""
    immediate: dict[str, Array]
    """(n,) largest error so far of values read from one step: reactions and torques that vary inside it"""

    def attitude(self, t_s: Array, amplification: Array) -> Array:
        """Error of the attitude, (n,) rad: an error made at s has grown G(t)/G(s) times by t."""
        made = cumulative_trapezoid(self.attitude_rate / np.interp(self.t_s, t_s, amplification), self.t_s, initial=0)
        found: Array = amplification * np.interp(t_s, self.t_s, made)
        return found

    def track(self, scene: Scene, t_s: Array) -> Array:
        """Error of the centre of mass, (n,), m: an error made at s has grown 1 + 3 n (t - s) times by t.

        Their sum over s is the errors made plus 3 n times the integral of that.
        """
        made = cumulative_trapezoid(self.com_rate, self.t_s, initial=0)
        run_on = 3.0 * orbit_scale(scene) * cumulative_trapezoid(made, self.t_s, initial=0)
        found: Array = np.interp(t_s, self.t_s, made + run_on)
        return found


def requested_errors(engine: Declarations, setting: Setting, solution: ReferenceSolution, steps: float) -> LocalErrors:
    """Local errors of a method that chooses its steps: the request in each, one step for a radian of the fastest rate.

    Methods of low or of changing order take more `steps`, and their own count is then used; 0 without one. The track,
    whose request in radii is far above its error, counts radians of the orbit, unless it is requested as closely as the
    bars. Samples come by dense output: its error is a step's once more.

    Stiff joints that are damped forget: what is made in them, an error in each radian of their own fastest motion,
    lives for the time of :func:`elastic_decay_1_s`. The motion that is left counts its own radians. Short steps that
    stability asks for there leave far less than the request in it.
    """
    scene = solution.scene
    n, made = len(solution.amplification), setting.value * step_constant(engine)
    read = READING_REQUESTS * made
    reading = {name: read * response for name, response in solution.response.items()}
    if "rate" in reading:  # requested in units of the orbit's and the bars' own rates, and forces respond to it
        reading["rate"] = np.maximum(reading["rate"], read * own_rate(scene))
    if "reaction" in reading:
        reading["reaction"] = np.maximum(reading["reaction"], read * RICHARDSON * inertia_force_N(scene))
    track = made * track_unit(engine, scene, made)
    rate, chain_rate = orbit_rate_bound(scene, solution.trajectory), rate_scale(scene, solution.trajectory)
    counted = steps / scene.run.duration_s
    turned, alive = max(chain_rate, counted), 0.0
    slow, decay = free_rate_scale(scene, solution.trajectory), elastic_decay_1_s(solution)
    if decay > slow:
        alive = turned / decay
        turned = counted if counted > chain_rate else slow
    # of the angles that the track is computed from
    shared = made * scene.size_m if engine.coordinates.by_joints else 0.0
    return LocalErrors(
        solution.trajectory.t_s[:n],
        np.full(n, made * turned),
        np.full(n, track * max(chain_rate if engine.track_by_length else rate, counted) + shared * chain_rate),
        reading
        | {"attitude": reading["attitude"] + made * alive}
        | {"com": np.full(n, track + shared), "com_velocity": np.full(n, track * rate + shared * chain_rate)},
    )


def elastic_decay_1_s(solution: ReferenceSolution) -> float:
    """Slowest decay of small motions in the joints, 1/s: springs and dampers alone act; 0 where one does not decay.

    With the chain's inertia matrix M at some samples, M b'' + C b' + K b = 0 has a rotation of the whole, and 2 (N - 1)
    other modes: all have to decay. M is that of the bars' rotations, and of the velocities that a unit rate of each bar
    gives to all centres. Longer chains than :data:`MOST_DECAY_BARS` count as such that do not decay.
    """
    scene, seen = solution.scene, solution.trajectory
    springs, bars = scene.effects.joint_spring_damper, scene.bars
    if springs is None or seen.angle_rad is None or bars > MOST_DECAY_BARS or not all(springs.stiffness_N_m_rad):
        return 0.0  # without a spring a joint keeps the angle that it was brought to
    bent = np.diff(np.eye(bars), axis=0)
    stiffness, damping = (bent.T * each @ bent for each in (springs.stiffness_N_m_rad, springs.damping_N_m_s_rad))
    model = chain_model(scene)
    decay = math.inf
    for angle in seen.angle_rad[np.linspace(0, len(seen.t_s) - 1, DECAY_SAMPLES).astype(int)]:
        velocity = bar_centres(model, np.diag(1j * model.half_m * unit_along(angle)))
        inertia = np.diag(model.inertia_kg_m2) + (model.mass_kg * velocity.conj() @ velocity.T).real
        pull, drag = (np.linalg.solve(inertia, each) for each in (stiffness, damping))
        real = np.sort(np.linalg.eigvals(np.block([[np.zeros_like(pull), np.eye(bars)], [-pull, -drag]])).real)
        least = SAME_INSTANT * abs(real[0])
        decay = min(decay, float(-real[2 * bars - 3]) if -real[2 * bars - 3] > least else 0.0)
    return decay


def step_constant(engine: Declarations) -> float:
    """Error of a step relative to its request, as far as `adapters.engine.Engine.step_constant` is believed."""
    return min(max(1.0, engine.step_constant), MAX_STEP_CONSTANT)


def track_unit(engine: Declarations, scene: Scene, rtol: float) -> float:
    """Unit of the requested accuracy for the centre of mass, m; 0 for a straight track without forces.

    An accuracy below the roundings of a place can't be requested.
    """
    if scene.effects.gravity is Gravity.NONE and scene.effects.kinds <= {"gravity", *WITHOUT_FORCE}:
        return 0.0
    length = max(scene.chain.length_m) if engine.track_by_length else scene.radius0_m
    return max(length, ROUNDINGS * MACHINE_EPSILON * scene.radius0_m / rtol)


def error_constant(order: float) -> float:
    """Error constant of a method of order p: above the second, of the first neglected term, h^p x^(p+1)/(p+1)!."""
    return SECOND_ORDER_CONSTANT if order <= SECOND_ORDER else 1.0 / math.factorial(round(order) + 1)


def truncation_errors(engine: Declarations, setting: Setting, solution: ReferenceSolution) -> LocalErrors:
    """Local errors of a fixed-step method of order p: C h^p times derivative p+1 of the judging solution.

    Third derivatives come from its dense samples, higher ones from the third by the rate at which that varies then. In
    absolute coordinates, and where the steps integrate the centre of mass beside relative ones, the orbit's own error
    along the track turns every local vertical. The track in a moving frame is the chain's departure from Kepler's
    orbit, of order (L/r)² r, and the departure by other effects.
    """
    scene, seen, order = solution.scene, solution.fine, engine.order or 1.0
    t = seen.t_s
    constant = error_constant(order)
    power = np.full(len(t), constant * step_s(scene, setting.value) ** order)
    if order > SECOND_ORDER:
        spin = 0.0 if seen.rate_rad_s is None else float(np.abs(seen.rate_rad_s).max())
        resolved = len(t) > 1 and np.diff(t).max() <= resolving_s(engine, setting, scene, spin)
        power *= varying_rate(scene, seen, resolved=resolved) ** (order - SECOND_ORDER)
    track = power * second_derivative(t, seen.com_velocity_m_s)
    turned = np.zeros(len(t))
    if engine.coordinates.absolute or engine.coordinates is Coordinates.RELATIVE:
        turned = track / scene.radius0_m * kepler_growth(scene, t)
    else:
        departing = departure_velocity(engine, scene, seen)
        track = track * (scene.size_m / scene.radius0_m) ** 2 + power * second_derivative(t, departing)
    turn, jerk = end_derivatives(engine, scene, seen)
    if engine.coordinates.by_joints:  # the centre of mass is not a coordinate: it shares the angles' errors
        track = track + power * jerk * scene.size_m
    immediate = {name: power * values for name, values in reading_errors(scene, seen, turn, jerk).items()}
    immediate["com_velocity"] = track  # h² times the second derivative of a velocity: read half a step aside
    samples = solution.trajectory.t_s[: len(solution.amplification)]
    return LocalErrors(
        t,
        power * jerk + turned,
        track,
        {name: running_maximum(t, values, samples) for name, values in immediate.items()},
    )


def departure(engine: Declarations, scene: Scene, trajectory: Trajectory) -> tuple[Array, Array]:
    """Departure of the centre of mass from the orbit of an engine's frame, m, and its rate, m/s: each (n, 2).

    Rotating frames and those of joint coordinates follow Kepler's orbit. Other frames fall with all fields, so that
    only forces on the chain itself cause a departure. Zero without such effects.
    """
    if not scene.effects.beyond_basic:
        return np.zeros_like(trajectory.com_m), np.zeros_like(trajectory.com_m)
    start, t_s = initial_state(scene), trajectory.t_s
    from_start = t_s if t_s[0] == 0.0 else np.append(0.0, t_s)  # a frame starts at the scene's own start
    keplerian = engine.coordinates in (Coordinates.ROTATING_FRAME, Coordinates.JOINT)
    if keplerian and scene.effects.gravity is not Gravity.NONE:
        mu = scene.central_body.mu_m3_s2
        place, velocity = propagate(mu, start.com_m, start.com_velocity_m_s, from_start)
    else:
        place, velocity = free_fall(scene, start, from_start)
    return trajectory.com_m - place[-len(t_s) :], trajectory.com_velocity_m_s - velocity[-len(t_s) :]


def departure_velocity(engine: Declarations, scene: Scene, trajectory: Trajectory) -> Array:
    """Rate of the departure of :func:`departure` in the axes of an engine's frame, m/s, (n, 2).

    In axes that turn with the orbit even a constant thrust of fixed direction varies inside a step.
    """
    place, velocity = departure(engine, scene, trajectory)
    if engine.coordinates is not Coordinates.ROTATING_FRAME or scene.effects.gravity is Gravity.NONE:
        return velocity
    x, y = trajectory.com_m.T
    turned = velocity - orbit_rate(trajectory)[:, None] * np.stack([-place[:, 1], place[:, 0]], axis=1)
    along = np.stack([x, y], axis=1) / np.hypot(x, y)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return np.stack([np.sum(turned * along, axis=1), np.sum(turned * across, axis=1)], axis=1)


def reading_errors(scene: Scene, trajectory: Trajectory, turn: Array, jerk: Array) -> dict[str, Array]:
    """Variation of each quantity inside a step, (m,): its second derivative, in SI units."""
    found = {"attitude": turn}
    values = {"rate": trajectory.rate_rad_s, "reaction": trajectory.reaction_N, "torque": trajectory.torque_N_m}
    found |= {k: second_derivative(trajectory.t_s, v) for k, v in values.items() if v is not None and v.size}
    if "rate" in found:
        found["rate"] = found["rate"] + jerk
    if "reaction" in found:  # forces that cancel in the exact motion do not in the discrete one
        found["reaction"] = found["reaction"] + max(scene.chain.mass_kg) * max(scene.chain.length_m) * turn**2
    return found


def running_maximum(t_s: Array, values: Array, samples_s: Array) -> Array:
    """Largest of `values` up to each sample, (n,)."""
    largest = np.maximum.accumulate(values)
    until = np.searchsorted(t_s, samples_s * (1.0 + SAME_INSTANT), side="right") - 1
    found: Array = largest[until]
    return found


def resolving_s(engine: Declarations, setting: Setting, scene: Scene, rate_rad_s: float) -> float:
    """Largest distance of samples that show what the steps of a method meet, s; infinite where that does not matter.

    A step's error is a mean of a derivative over the step, which samples half a step apart resolve. Where steps are
    long, the motion itself has to be resolved: :data:`barchain.solutions.reference.FINE_PER_RADIAN` samples in a radian
    of the fastest bar.
    """
    if setting.parameter is AccuracyParameter.RTOL or (engine.order or 1.0) <= SECOND_ORDER:
        return math.inf
    return min(0.5 * step_s(scene, setting.value), 1.0 / max(FINE_PER_RADIAN * rate_rad_s, orbit_scale(scene)))


def varying_rate(scene: Scene, trajectory: Trajectory, *, resolved: bool) -> Array:
    """Ratio of successive high derivatives of the attitude, (m,) rad/s: at least the bars' and the orbit's own rate.

    Where bars fold through each other, their rates change within a tenth of a radian. As a function of complex time the
    motion then has poles that close to the real axis, and each further derivative is larger by the inverse of that time
    rather than by the rate: ten times as large, so that the seventh derivative is 1e4 times what the rate alone says.
    The ratio is the square root of the fifth over the third derivative.

    Samples that resolve such passages (:func:`resolving_s`) give the ratio of each instant. Over a sample interval, the
    error of Exudyn's sixth-order method was then a third of the bound without its slack at most, and 1/40 to 1/200 in
    the median: chaotic runs of four and six bars, 40 intervals of each, at 200 and 400 steps per orbit. Other samples
    pass over folds, and the largest derivatives of the whole run count at each instant. The fastest mode of the chain
    is no measure: unless excited, the mode is in no derivative.
    An end body's swing that samples pass over (:func:`unseen_swing`) has its own rate.
    """
    t, rate = trajectory.t_s, trajectory.rate_rad_s
    if rate is None:
        return np.full(len(t), orbit_scale(scene))
    third = second_derivative(t, rate)
    fifth = second_derivative(t, first_derivative(t, first_derivative(t, rate)))
    slowest = np.maximum(np.abs(rate).max(axis=1), math.sqrt(3.0) * orbit_rate_bound(scene, trajectory))
    if unseen_swing(scene, trajectory):
        slowest = np.maximum(slowest, scene.swing_rate_rad_s)
    if not resolved:
        third, fifth, slowest = (np.full(len(t), values.max()) for values in (third, fifth, slowest))
    found: Array = np.maximum(slowest, np.sqrt(fifth / np.maximum(third, slowest**3)))
    return found


def unseen_swing(scene: Scene, trajectory: Trajectory) -> float:
    """Largest rate of an end body against its neighbour, rad/s; 0 where samples show the swing, or there is none.

    The body swings far faster than the chain moves: samples between which it swings by a radian meet it in all its
    phases, so that they show how large its rate is, while their differences do not show how the rate varies.
    """
    rate, chain = trajectory.rate_rad_s, scene.chain
    if rate is None or not chain.bodies:
        return 0.0
    if np.diff(trajectory.t_s).max(initial=0.0) * scene.swing_rate_rad_s * FINE_PER_RADIAN <= 1.0:
        return 0.0
    against = np.abs(np.diff(rate, axis=1))
    return float(max(against[:, 0 if bar == 1 else -1].max() for bar in chain.bodies))


def end_derivatives(engine: Declarations, scene: Scene, trajectory: Trajectory) -> tuple[Array, Array]:
    """Second and third time derivatives of a bar's end about its centre, over half its length, bounds, (n,) each.

    With w the rate: |w'| + w² and |w''| + 3 |w w'| + |w|³. In a frame that turns with the orbit, rates
    count from its own; without gravity there is no orbit to turn with.
    """
    if trajectory.rate_rad_s is None:
        return np.zeros(len(trajectory.t_s)), np.zeros(len(trajectory.t_s))
    rate = trajectory.rate_rad_s
    if engine.coordinates is Coordinates.ROTATING_FRAME and scene.effects.gravity is not Gravity.NONE:
        rate = rate - orbit_rate(trajectory)[:, None]
    fastest = np.abs(rate).max(axis=1)
    swing = unseen_swing(scene, trajectory)
    turn = np.abs(first_derivative(trajectory.t_s, rate)).max(axis=1) + swing * scene.swing_rate_rad_s
    jerk = second_derivative(trajectory.t_s, rate) + swing * scene.swing_rate_rad_s**2
    return turn + fastest**2, jerk + 3.0 * fastest * turn + fastest**3


def first_derivative(t_s: Array, values: Array) -> Array:
    """First time derivative from samples, shaped as they are; zero where a run ended before its second one."""
    return np.gradient(values, t_s, axis=0) if len(t_s) > 1 else np.zeros_like(values)


def second_derivative(t_s: Array, values: Array) -> Array:
    """Largest second time derivative over all components, (n,), from samples."""
    if len(t_s) < 3:
        return np.zeros(len(t_s))
    twice = first_derivative(t_s, first_derivative(t_s, values))
    largest: Array = np.abs(twice).reshape(len(t_s), -1).max(axis=1)
    return largest
