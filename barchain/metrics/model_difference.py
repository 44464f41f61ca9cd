"""Displacement of a chain's centre of mass from a particle's orbit: model difference of engines without attitude.

Gravity acts on each bar at its own place, so the mean acceleration differs from that at the centre of mass by
O((L/r)²). To first order the track is displaced by

    delta'' = G(Z0) delta + (g_mean - g(Z0)),   G = mu/r³ (3 r̂ r̂ᵀ - I),

with the attitude of the judging solution. The displacement is independent of the judged engine.

Oblateness and third bodies contribute to the mean acceleration and to G. The force on the bars' second moments is of
the same order (l/r)² of gravity as the effect of their places, and is in the mean acceleration. Its contribution to G,
(l/r)² of G, is neglected.
Drag, solar pressure, thrust and impulses are assumed to accelerate a particle as they accelerate the chain. They are
therefore not in the displacement. They are in the response of the track to the attitude. There the change of drag with
place and velocity is neglected in G: for a drag a it is a/H and a/v, in 1/s², a thousandth of the orbit's own terms
where the air is thin enough for an orbit.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.common.reference_model import chain_model
from reference_impl.model.complex_vectors import as_vectors, unit_along
from reference_impl.model.effect import EffectRows
from reference_impl.model.gravity import field_differences
from reference_impl.model.kinematics import relative_positions, relative_velocities
from reference_impl.model.state import State
from reports.results.comparison import PARTED_RAD
from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import ChainEffect
    from scenarios import Scene, ThirdBody

    AccelerationField = Callable[[Array, Array], Array]

FIELD_EFFECTS = frozenset({"quadrupole", "slender", "oblateness", "third_body"})
"""Effects whose force on a bar depends on its place; that of others, which don't act inside the chain, on its attitude,
or it has a fixed direction"""
RESPONSE_STEPS_PER_RADIAN = 60.0  # of the orbit: oscillations of the chain are up to ten times as fast
PUSHED_STEPS_PER_RADIAN = 20.0  # of the fastest bar, whose direction decides the force and its kinks
SPARSE_RAD = 1.0  # of the orbit between samples: beyond it nothing is interpolated, and the displacement is bounded
SECOND_MOMENT_ACCELERATION, SECOND_MOMENT_SENSITIVITY = 3.0, 9.0
"""Over mu I/(M r⁴), I about the centre of the stretched chain: the largest acceleration by a second moment, upright,
and its largest change per radian: 9/2 for a chain that turns as one body, twice that for joints that turn too"""
DISPLACEMENT_STEPS_PER_RADIAN = 200.0  # of the orbit; a twentieth of a radian of the chain's oscillations: (1/20)^4/120
BLOCK = 4096  # steps at a time: their matrices take 3 MB


@dataclass(frozen=True)
class Displacement:
    """Predicted departure of the chain's centre of mass from a particle's track; n samples."""

    vector_m: Array
    """(n, 2)"""
    uncertainty_m: Array
    """(n,), never falling: interpolation, and the second order left out"""
    vector_m_s: Array
    """(n, 2) its time derivative"""
    uncertainty_m_s: Array
    """(n,), never falling, alike"""


def com_displacement(scene: Scene, solution: Trajectory) -> Displacement:
    """Displacement of the chain's centre of mass from a particle's track, and its time derivative.

    The uncertainty has two parts. One is the change on halving the samples, a bound for cubic interpolation, whose
    error falls 16 times. The other is the second order of the field, which is neglected: the displacement times its
    size over r, amplified by Kepler motion, 1 + 3 n t; in velocities it is multiplied by the orbit's rate.
    With samples too sparse for interpolation the displacement is zero, and its uncertainty a bound.
    """
    n = len(solution.t_s)
    if not has_extended_gravity(scene, solution):
        return Displacement(np.zeros((n, 2)), np.zeros(n), np.zeros((n, 2)), np.zeros(n))
    if sparse(scene, solution):
        most = displacement_bound(scene, solution.t_s, SECOND_MOMENT_ACCELERATION)
        return Displacement(np.zeros((n, 2)), most["com"], np.zeros((n, 2)), most["com_velocity"])
    full = integrate(scene, solution, 1)
    coarse = integrate(scene, solution, 2) if n > 4 else np.zeros_like(full)
    interpolation = np.maximum.accumulate(np.linalg.norm((full - coarse).reshape(n, 2, 2), axis=2))
    size = np.maximum.accumulate(np.linalg.norm(full[:, :2], axis=1))
    distance = np.linalg.norm(solution.com_m, axis=1)
    rate = float((np.linalg.norm(solution.com_velocity_m_s, axis=1) / distance).max())
    amplification = 1.0 + 3.0 * scene.speed_rate_rad_s * solution.t_s
    second_order = size * size / distance.min() * amplification
    return Displacement(
        full[:, :2], interpolation[:, 0] + second_order, full[:, 2:], interpolation[:, 1] + rate * second_order
    )


def track_response(scene: Scene, solution: Trajectory, perturbed: Trajectory) -> dict[str, Array]:
    """Departure of a perturbed run's centre of mass: ``com`` (m), ``com_velocity`` (m/s), each (n,).

    The difference of the two displacements is integrated directly. The difference of the two tracks is smaller than
    their errors: the attitudes differ by 1e-10 rad only. Once the attitudes have parted, a response means nothing, and
    the last departure stands.
    """
    n = min(len(solution.t_s), len(perturbed.t_s))
    driven = any(map(is_push, chain_model(scene).effects)) or scene.effects.impulse
    if (
        solution.angle_rad is None
        or perturbed.angle_rad is None
        or not (has_extended_gravity(scene, solution) or driven)
    ):
        return {"com": np.zeros(n), "com_velocity": np.zeros(n)}
    t = solution.t_s[:n]
    parted = np.abs(solution.angle_rad[:n] - perturbed.angle_rad[:n]).max(axis=1) > PARTED_RAD
    last = max(int(parted.argmax()), 1) if parted.any() else n - 1
    if sparse(scene, solution) and not driven:
        perturbation_rad = np.maximum.accumulate(np.abs(solution.angle_rad[:n] - perturbed.angle_rad[:n]).max(axis=1))
        return {
            name: perturbation_rad * size
            for name, size in displacement_bound(scene, t, SECOND_MOMENT_SENSITIVITY).items()
        }
    span = t[last] - t[0]
    count = math.ceil(span * 2.0 * math.pi / scene.step_period_s * RESPONSE_STEPS_PER_RADIAN)
    if driven and solution.rate_rad_s is not None:
        count = max(count, math.ceil(span * float(np.abs(solution.rate_rad_s).max()) * PUSHED_STEPS_PER_RADIAN))
    solution, perturbed = (each.samples(slice(last + 1)) for each in (solution, perturbed))
    own, other = (excess_acceleration(scene, each, 1, include_non_fields=True) for each in (solution, perturbed))
    times = np.linspace(t[0], t[last], 2 * max(count, 1) + 1)
    com = CubicHermiteSpline(solution.t_s, solution.com_m, solution.com_velocity_m_s)
    seen = integrate_displacement(
        scene, com, lambda at, z: other(at, z) - own(at, z), times, impulse_differences(scene, solution, perturbed)
    )
    apart = {"com": seen[:, :2], "com_velocity": seen[:, 2:]}
    return {name: np.interp(t, times[::2], np.linalg.norm(d, axis=1)) for name, d in apart.items()}


def sparse(scene: Scene, solution: Trajectory) -> bool:
    """Whether the samples of a bound orbit are too far apart for interpolation."""
    spacing = (solution.t_s[-1] - solution.t_s[0]) / max(1, len(solution.t_s) - 1)
    return scene.bound and bool(spacing * 2.0 * math.pi / scene.step_period_s > SPARSE_RAD)


def stretched_inertia_kg_m2(scene: Scene) -> float:
    """Moment of inertia of the stretched chain about its centre of mass, kg m²."""
    model = chain_model(scene)
    place = relative_positions(model, np.zeros(model.bars))[:, 0]
    return float(model.mass_kg @ place**2 + model.inertia_kg_m2.sum())


def displacement_bound(scene: Scene, t_s: Array, factor: float) -> dict[str, Array]:
    """Bound of the displacement by an acceleration of at most `factor` mu I/(M r⁴), at `t_s`.

    ``com`` (m) and ``com_velocity`` (m/s) are (n,). A constant acceleration a along the track displaces by 3/2 a t²
    along it, and by up to 8 a/n² across; the displacement rotates with the rate n. The least radius is that of the
    perigee, or the surface, where a run ends.
    """
    lowest = max(scene.lowest_radius_m, scene.central_body.radius_m)
    acceleration = factor * scene.central_body.mu_m3_s2 * stretched_inertia_kg_m2(scene) / (scene.mass_kg * lowest**4)
    rate = math.sqrt(scene.central_body.mu_m3_s2 / lowest**3)
    moved_m = acceleration * (1.5 * t_s**2 + 8.0 / scene.mean_motion_rad_s**2)
    return {"com": moved_m, "com_velocity": rate * moved_m}


def impulse_differences(scene: Scene, solution: Trajectory, perturbed: Trajectory) -> list[tuple[float, Array]]:
    """Instants of impulses, s, and the additional velocity that they give to a perturbed run, (2,) m/s."""
    both = zip(impulse_velocities(scene, solution), impulse_velocities(scene, perturbed), strict=True)
    return [(at_s, other - velocity_step) for (at_s, velocity_step), (_, other) in both]


def integrate_displacement(
    scene: Scene,
    com: CubicHermiteSpline,
    acceleration: AccelerationField,
    times_s: Array,
    velocity_steps: Iterable[tuple[float, Array]] = (),
) -> Array:
    """Displacement by an acceleration along a track, and its velocity, by fourth-order Runge-Kutta.

    Step control would follow the round-off of a difference of two accelerations. The equation is linear: each step is a
    matrix, made for many steps at once.

    Parameters
    ----------
    scene : Scene
    com : CubicHermiteSpline
        Track, (2,) m.
    acceleration : callable
        Of instants and places, see :func:`barchain.metrics.model_difference.excess_acceleration`.
    times_s : ndarray, shape (2 k + 1,)
        Starts, middles and ends of k steps.
    velocity_steps : iterable of (float, ndarray of shape (2,))
        Instants, s, and changes of the velocity, m/s, which act at the start of the step that holds the instant.

    Returns
    -------
    ndarray, shape (k + 1, 4)
        m and m/s at the ends of the steps.
    """
    fields, one = tides(scene), np.eye(5)
    steps = len(times_s) // 2
    seen = np.zeros((steps + 1, 5))  # displacement, velocity, 1
    seen[0, 4] = 1.0
    jumps = [(int(np.searchsorted(times_s[::2], at_s, side="right")) - 1, change) for at_s, change in velocity_steps]
    for first in range(0, steps, BLOCK):
        times = times_s[2 * first : 2 * min(first + BLOCK, steps) + 1]
        places = com(times)
        rates = np.zeros((len(times), 5, 5))
        rates[:, :2, 2:4] = np.eye(2)
        rates[:, 2:4, :2] = sum((field(times, places) for field in fields), np.zeros((2, 2)))
        rates[:, 2:4, 4] = acceleration(times, places)
        h = (times[2::2] - times[:-1:2])[:, None, None]
        a, middle = rates[:-1:2], rates[1::2]
        b = middle @ (one + 0.5 * h * a)
        c = middle @ (one + 0.5 * h * b)
        d = rates[2::2] @ (one + h * c)
        for k, step in enumerate(one + h / 6.0 * (a + 2.0 * b + 2.0 * c + d), start=first):
            for at, change in jumps:
                if at == k:
                    seen[k, 2:4] += change
            seen[k + 1] = step @ seen[k]
    return seen[:, :4]


def is_push(effect: ChainEffect) -> bool:
    """Whether an effect is a force from outside that no field makes: drag, sunlight, thrust."""
    return not effect.internal and effect.name not in FIELD_EFFECTS


def has_extended_gravity(scene: Scene, solution: Trajectory) -> bool:
    """Whether the places of the bars change the acceleration of the centre of mass."""
    return scene.effects.gravity is not Gravity.NONE and solution.angle_rad is not None


def integrate(scene: Scene, solution: Trajectory, every: int) -> Array:
    """Displacement and its velocity along the judging solution, (n, 4), from every `every`-th sample."""
    t = solution.t_s
    knots = every_nth(len(t), every)
    com = CubicHermiteSpline(t[knots], solution.com_m[knots], solution.com_velocity_m_s[knots])
    widest_rad = float(np.diff(t).max()) * 2.0 * math.pi / scene.step_period_s
    each = 2 * max(1, math.ceil(widest_rad * DISPLACEMENT_STEPS_PER_RADIAN))
    times = np.interp(np.arange((len(t) - 1) * each + 1) / each, np.arange(len(t)), t)
    return integrate_displacement(scene, com, excess_acceleration(scene, solution, every), times)[:: each // 2]


def excess_acceleration(
    scene: Scene, trajectory: Trajectory, every: int, *, include_non_fields: bool = False
) -> AccelerationField:
    """Mean acceleration of the bars less that at the centre of mass, m/s², along a run's attitude.

    Parameters
    ----------
    scene : Scene
    trajectory : Trajectory
        With attitude and rates.
    every : int
        Interpolate the attitude through every `every`-th sample.
    include_non_fields : bool
        Add drag, solar pressure and thrust with their full acceleration of the centre of mass.

    Returns
    -------
    callable
        Function of instants (k,), s, and of places of the centre of mass, (k, 2) m; returns (k, 2) m/s².
    """
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    model, mu, t = chain_model(scene), scene.central_body.mu_m3_s2, trajectory.t_s
    knots = every_nth(len(t), every)
    angle = CubicHermiteSpline(t[knots], trajectory.angle_rad[knots], trajectory.rate_rad_s[knots])

    def acceleration(times_s: Array, z: Array) -> Array:
        found: Array = model.weight @ field_differences(mu, z[:, None, :], relative_positions(model, angle(times_s)))
        return found

    acting = [e for e in model.effects if e.name in FIELD_EFFECTS or (include_non_fields and is_push(e))]
    if not acting:
        return acceleration
    more = effect_acceleration(
        model, acting, CubicHermiteSpline(t, trajectory.com_m, trajectory.com_velocity_m_s), angle
    )
    return more if model.gravity == "none" else lambda time, z: acceleration(time, z) + more(time, z)


def every_nth(count: int, every: int) -> NDArray[np.intp]:
    """Indices of every `every`-th of `count` samples, and of the last sample."""
    return np.unique(np.append(np.arange(0, count, every), count - 1))


def effect_acceleration(
    model: ChainModel, acting: list[ChainEffect], com: CubicHermiteSpline, angle: CubicHermiteSpline
) -> AccelerationField:
    """Mean acceleration of the bars by some effects, less the part common to all bars, along a motion, m/s²."""
    velocity, rate = com.derivative(), angle.derivative()

    def mean_effect(times_s: Array, z: Array) -> Array:
        angles, rates = angle(times_s), rate(times_s)
        places, motions = relative_positions(model, angles), relative_velocities(model, angles, rates)
        state = State(z, velocity(times_s), angles, rates, places, motions)
        at = EffectRows(model, times_s, state, unit_along(angles))
        parts = [effect.accelerations(at, None).difference @ model.weight for effect in acting]
        return as_vectors(sum(parts, np.zeros(len(times_s), complex)))

    return mean_effect


@dataclass(frozen=True)
class TidalGradient:
    """Gradient of an attraction k Y/|Y|^(p+1) towards a mass."""

    strength: float
    """k, m^(p+1)/s²"""
    power: int
    """p + 1"""
    body: ThirdBody | None = None
    """Third body that attracts; None for the central body"""

    def __call__(self, t_s: Array, place_m: Array) -> Array:
        """Change of the acceleration per small displacement, (..., 2, 2) 1/s², at places (..., 2) and instants."""
        y = place_m
        if self.body is not None:
            longitude = self.body.longitude_rad + self.body.rate_rad_s * t_s
            y = place_m - self.body.distance_m * np.stack([np.cos(longitude), np.sin(longitude)], axis=-1)
        r = np.linalg.norm(y, axis=-1)[..., None, None]
        outer = y[..., :, None] * y[..., None, :]
        found: Array = self.strength / r**self.power * (self.power * outer / r**2 - np.eye(2))
        return found


def tides(scene: Scene) -> list[TidalGradient]:
    """Tidal gradients of all fields on a particle: central body, oblateness, third bodies."""
    mu, oblate = scene.central_body.mu_m3_s2, scene.effects.oblateness
    found = [] if scene.effects.gravity is Gravity.NONE else [TidalGradient(mu, 3)]
    if oblate is not None:
        found.append(TidalGradient(1.5 * mu * oblate.j2 * oblate.radius_m**2, 5))
    return found + [TidalGradient(body.mu_m3_s2, 3, body) for body in scene.effects.third_body]


def impulse_velocities(scene: Scene, trajectory: Trajectory) -> list[tuple[float, Array]]:
    """Instants of impulses in a bar's own axes, s, and the velocities that they add to the centre of mass, (2,) m/s."""
    turning = [impulse for impulse in scene.effects.impulse if impulse.axes is Axes.BODY]
    if not turning:
        return []
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    angle = CubicHermiteSpline(trajectory.t_s, trajectory.angle_rad, trajectory.rate_rad_s)
    found = []
    for impulse in turning:
        velocity_step = cmath.rect(
            impulse.impulse_N_s / scene.mass_kg, impulse.direction_rad + angle(impulse.at_s)[impulse.bar - 1]
        )
        found.append((impulse.at_s, np.array([velocity_step.real, velocity_step.imag])))
    return found
