"""Compared quantities: differences of two trajectories, drifts of one, and the fastest rates of a scene.

Beside the orbit's, the energy and the angular momentum about the centre of mass vanish: of 1e13 N m s a slowly turning
bar has 0.03. Their balance is of the order of the bars: their changes less the work and torque of gravity. It holds for
the paper's gravity gradient too, which conserves neither energy nor angular momentum as a whole:

    dL/dt = sum of m_j d_j x (g_j - g) + K_j,   dE/dt = sum of m_j d_j' . (g_j - g) + K_j theta_j',

with g_j the field at bar j, K_j the torque on it, and d_j from the centre of mass. Eqs. (13), (15).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.common.reference_model import chain_model
from barchain.metrics.joint_gaps import measured
from barchain.metrics.model_difference import FIELD_EFFECTS, every_nth
from reference_impl.model import invariants
from reference_impl.model.complex_vectors import as_complex, unit_along
from reference_impl.model.effect import EffectState
from reference_impl.model.gravity import complex_field_differences, gradient_angular_accelerations
from reference_impl.model.kinematics import bar_centres, consistent_state
from scenarios import Actuator, Gravity
from scenarios.channels import COMPARED, Of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene

FIELDS = {channel.name: channel.array for channel in COMPARED}
"""Compared quantities, and their arrays in a trajectory"""
QUANTITY_OF = {array: quantity for quantity, array in FIELDS.items()}
TRACK = tuple(channel.name for channel in COMPARED if channel.of is Of.TRACK)
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(3)
"""Nodes of an interval: of a higher degree than the splines between samples"""
LEAST_SAMPLES = 3
"""Samples of which every second can be left out"""
ROUNDED = 1e-6
"""Difference of even intervals by the digits of their instants"""
MOST_TURNED_RAD = 0.5
"""Largest turn of a bar, or of the centre of mass about the body, between samples: torques turn twice as far, and twice
that without every second sample"""
MODES_PER_BAR = 2.1  # fastest oscillation of a chain of N bars, over N times its rate (radial chain: 2.1 N n)


def arrays(trajectory: Trajectory) -> dict[str, Array]:
    """Compared arrays of a trajectory that are there, by their names."""
    return {name: v for name in QUANTITY_OF if (v := getattr(trajectory, name)) is not None}


def components(trajectory: Trajectory, quantities: Collection[str] = FIELDS) -> dict[str, Array]:
    """Values of each quantity by bar or joint, (n, k, 1) or (n, k, 2); quantities without components are left out."""
    found = {}
    for name in quantities:
        values = getattr(trajectory, FIELDS[name])
        if values is not None:
            by_part = values[:, None, :] if name in TRACK else values if values.ndim == 3 else values[:, :, None]
            if by_part.shape[1]:
                found[name] = by_part
    return found


def differences(a: Trajectory, b: Trajectory, quantities: Collection[str] = FIELDS) -> dict[str, Array]:
    """Largest difference over bars or joints at each common sample, for each of some quantities that both have.

    Returns
    -------
    dict
        ``com`` (m), ``com_velocity`` (m/s), ``attitude`` (rad), ``rate`` (rad/s), ``reaction`` (N), ``torque`` (N m),
        ``impulse`` (N s), each (n,).
        Quantities without components (reactions of a single bar) are left out.
    """
    n, other = min(len(a.t_s), len(b.t_s)), components(b, quantities)
    pairs = {name: (values, other[name]) for name, values in components(a, quantities).items() if name in other}
    return {name: np.linalg.norm(x[:n] - y[:n], axis=-1).max(axis=-1) for name, (x, y) in pairs.items()}


def completed(trajectory: Trajectory, absent: Mapping[str, NDArray[np.bool_]], other: Trajectory) -> Trajectory:
    """Trajectory with the parts of another one where it has none of its own, at the samples of both.

    Parameters
    ----------
    trajectory : Trajectory
    absent : mapping of str to ndarray
        Parts that an array lacks, of the shape of a sample.
    other : Trajectory
    """
    changes = {}
    for name, lacking in absent.items():
        values, theirs = getattr(trajectory, name), getattr(other, name)
        if values is not None and theirs is not None and values.shape[1:] == theirs.shape[1:]:
            n, found = min(len(values), len(theirs)), np.array(values)
            found[:n] = np.where(lacking, theirs[:n], values[:n])
            changes[name] = found
    return trajectory.replace(**changes) if changes else trajectory


def sizes(trajectory: Trajectory) -> dict[str, Array]:
    """Largest value of each quantity at each sample, over bars or joints, (n,)."""
    return {name: np.linalg.norm(x, axis=-1).max(axis=-1) for name, x in components(trajectory).items()}


def largest(trajectory: Trajectory) -> dict[str, Array]:
    """Largest value of each quantity so far, (n,), which scales its round-off."""
    return {name: np.maximum.accumulate(size) for name, size in sizes(trajectory).items()}


@dataclass(frozen=True)
class Conserved:
    """Invariants of a scene."""

    energy: bool
    angular_momentum: bool
    relative: bool
    """Whether the relative motion alone conserves them (no gravity)."""


def conserved(scene: Scene) -> Conserved:
    """Invariants under the scene's effects; each effect declares whether it has a potential and is isotropic.

    The paper's gravity gradient conserves neither: its torque has no counterpart in the force. A
    prescribed rotation does work. Its torque changes the angular momentum, except for a motor in a joint.
    """
    called = scene.effects
    laws, effects = called.prescribed_rotation, chain_model(scene).effects
    field = called.gravity.has_potential and not called.impulse
    inside = all(p.actuator is Actuator.JOINT for p in laws)
    return Conserved(
        field and not laws and all(e.potential for e in effects),
        field and inside and all(e.isotropic for e in effects),
        called.gravity is Gravity.NONE,
    )


def drifts(scene: Scene, trajectory: Trajectory) -> dict[str, Array]:
    """Drifts of constraints and invariants, (n,): ``gap``, ``com_residual`` (m), ``energy``, ``angular_momentum`` (1).

    Where gravity acts, ``energy_about_com`` and ``angular_momentum_about_com`` (1) are balances
    (:mod:`barchain.metrics.quantities`).
    Energy and angular momentum are computed from the centre of mass and the attitude, alike for every engine. Their
    changes are divided by the largest kinetic part of the run: a fall from rest has none at first.
    Gaps and the centre-of-mass residual follow from the bars' places; without places they are as reported.
    """
    found: dict[str, Array] = {}
    trajectory = measured(scene, trajectory)
    if trajectory.gap_m is not None and scene.bars > 1:
        found["gap"] = trajectory.gap_m.max(axis=1)
    if trajectory.com_residual_m is not None and scene.bars > 1:
        found["com_residual"] = trajectory.com_residual_m
    if trajectory.angle_rad is None or trajectory.rate_rad_s is None:
        return found
    keeps = conserved(scene)
    if keeps.energy:
        found["energy"] = energy_drift(scene, trajectory, keeps.relative)
    if keeps.angular_momentum:
        found["angular_momentum"] = angular_momentum_drift(scene, trajectory, keeps.relative)
    return found | (balance_drifts(scene, trajectory) if balanced(scene) else {})


def balance_drifts(scene: Scene, trajectory: Trajectory) -> dict[str, Array]:
    """Changes about the centre of mass that gravity does not explain, over the largest values of the run, (n,)."""
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    model, slowest = chain_model(scene), slowest_rate(scene)
    inertia = float(model.inertia_kg_m2.sum())
    sizes = {
        "energy_about_com": invariants.relative_kinetic_energy(model, trajectory.angle_rad, trajectory.rate_rad_s),
        "angular_momentum_about_com": spin_size(model, trajectory),
    }
    least = {"energy_about_com": 0.5 * inertia * slowest**2, "angular_momentum_about_com": inertia * slowest}
    left = imbalance(scene, trajectory)
    return {name: values / max(float(np.max(sizes[name])), least[name]) for name, values in left.items()}


def energy_drift(scene: Scene, trajectory: Trajectory, relative: bool) -> Array:
    """Change of energy relative to its largest kinetic part, (n,)."""
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    model = chain_model(scene)
    energy = kinetic = invariants.relative_kinetic_energy(model, trajectory.angle_rad, trajectory.rate_rad_s)
    if not relative:
        kinetic = energy + 0.5 * scene.mass_kg * np.sum(trajectory.com_velocity_m_s**2, axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):  # at the body's centre: NaN is within no bound
            energy = energy + invariants.com_energy(model, trajectory.com_m, trajectory.com_velocity_m_s)
            energy = energy + invariants.tidal_energy(model, trajectory.com_m, trajectory.angle_rad)
    for effect in model.effects:
        energy = energy + effect.energy(model, trajectory.com_m, trajectory.angle_rad)
    least = 0.5 * float(model.inertia_kg_m2.sum()) * slowest_rate(scene) ** 2
    return from_first(energy, kinetic, least)


def from_first(values: Array, size: Array, least: float) -> Array:
    """Change from the first value, (n,), over the largest `size`, or over `least` if that is larger."""
    drift: Array = np.abs(values - values[0]) / max(float(np.max(size)), least)
    return drift


def slowest_rate(scene: Scene) -> float:
    """Rate that scales the invariants of a chain at rest, rad/s: v0/r0, or the orbit's mean motion if v0 is zero."""
    return scene.speed_rate_rad_s or 2.0 * np.pi / scene.step_period_s


def angular_momentum_drift(scene: Scene, trajectory: Trajectory, relative: bool) -> Array:
    """Change of angular momentum relative to its largest size, (n,)."""
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    model = chain_model(scene)
    momentum = invariants.relative_angular_momentum(model, trajectory.angle_rad, trajectory.rate_rad_s)
    size = spin_size(model, trajectory)
    if not relative:
        momentum = momentum + invariants.com_angular_momentum(model, trajectory.com_m, trajectory.com_velocity_m_s)
        speed, distance = (np.linalg.norm(v, axis=-1) for v in (trajectory.com_velocity_m_s, trajectory.com_m))
        size = size + scene.mass_kg * speed * distance
    return from_first(momentum, size, float(model.inertia_kg_m2.sum()) * slowest_rate(scene))


def spin_size(model: ChainModel, trajectory: Trajectory) -> Array:
    """Size of the angular momentum about the centre of mass, (n,), N m s; no less than the bars' own, of any sign."""
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    momentum = invariants.relative_angular_momentum(model, trajectory.angle_rad, trajectory.rate_rad_s)
    size: Array = np.abs(trajectory.rate_rad_s) @ model.inertia_kg_m2 + np.abs(momentum)
    return size


CONSERVATIVE = frozenset({"gravity", "oblateness", "third_body", "joint_spring_damper"})
"""Effects that have a potential, springs without dampers among them"""


def balanced(scene: Scene) -> bool:
    """Whether only fields, and springs between bars, act beside gravity, so that the balance can be computed."""
    springs = scene.effects.joint_spring_damper
    damped = springs is not None and any(springs.damping_N_m_s_rad)
    return scene.effects.gravity is not Gravity.NONE and scene.effects.kinds <= CONSERVATIVE and not damped


@np.errstate(divide="ignore", invalid="ignore")  # at the body's centre nothing is resolved
def imbalance(scene: Scene, trajectory: Trajectory) -> dict[str, Array]:
    """Changes of energy (J) and angular momentum (N m s) about the centre of mass that gravity does not explain, (n,).

    Between samples the motion is a cubic spline through angles and rates. Its error falls 16 times with twice the
    samples: the change on leaving out every second sample, in an interval and its neighbours without regard to sign,
    bounds it and is subtracted; of uneven samples it is enlarged where that hardly lengthens an interval. Nothing shows
    from the first interval on in which a bar, or the orbit, turns too far.
    """
    model, t = chain_model(scene), trajectory.t_s
    angle, rate = trajectory.angle_rad, trajectory.rate_rad_s
    assert angle is not None
    assert rate is not None
    energy = invariants.relative_kinetic_energy(model, angle, rate)
    for effect in model.effects:
        if effect.internal:
            energy = energy + effect.energy(model, trajectory.com_m, angle)
    held: dict[str, Array] = {
        "energy_about_com": energy,
        "angular_momentum_about_com": invariants.relative_angular_momentum(model, angle, rate),
    }
    if len(t) < LEAST_SAMPLES:
        return {name: np.zeros(len(t)) for name in held}
    fastest = np.maximum(np.abs(rate).max(axis=1), np.abs(orbit_rate(trajectory)))
    turning = np.diff(t) * np.maximum(fastest[1:], fastest[:-1])
    turned = np.maximum(np.abs(np.diff(angle, axis=0)).max(axis=1), turning)
    resolved = np.append(True, np.logical_and.accumulate(turned <= MOST_TURNED_RAD))
    own_s = np.diff(t)
    if len(t) % 2 == 0 and own_s[-1] > (1.0 + ROUNDED) * own_s[-2]:
        resolved[-1] = False  # a last interval without a pair, longer than the one that tells its error
    full, coarse = (gained(model, trajectory, t, every) for every in (1, 2))
    found = {}
    for name, values in held.items():
        left = np.abs(values - values[0] - np.append(0.0, np.cumsum(full[name])))
        apart = np.pad(
            np.abs(full[name] - coarse[name]) * lengthened(t), 1
        )  # zeros beside the first and the last interval
        unknown = np.append(0.0, np.cumsum(apart[:-2] + apart[1:-1] + apart[2:]))
        found[name] = np.where(resolved, np.maximum(left - unknown, 0.0), 0.0)
    return found


def lengthened(t_s: Array) -> Array:
    """Error of a cubic spline in each interval over its change on leaving out every second sample, (n-1,), at least 1.

    The error goes with the fourth power of the distance of the knots, h without and H with samples left out: the change
    is (H/h)^4 - 1 of it, 15 times for even samples. The last interval may stay as it is, where its neighbour tells.
    """
    own, knots = np.diff(t_s), t_s[every_nth(len(t_s), 2)]
    longer = np.diff(knots)[np.searchsorted(knots, t_s[:-1], side="right") - 1]
    gain = (longer / own) ** 4 - 1.0
    found: Array = np.where(gain > 0.0, np.maximum(1.0 / np.maximum(gain, np.finfo(float).eps), 1.0), 1.0)
    return found


def gained(model: ChainModel, trajectory: Trajectory, t_s: Array, every: int) -> dict[str, Array]:
    """Work and angular impulse of gravity in each interval, (n-1,), along splines through every `every`-th sample."""
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    knots, half_s = every_nth(len(t_s), every), 0.5 * np.diff(t_s)
    nodes = (t_s[:-1] + half_s)[:, None] + half_s[:, None] * GAUSS
    times = nodes.ravel()
    angle = CubicHermiteSpline(t_s[knots], trajectory.angle_rad[knots], trajectory.rate_rad_s[knots])
    com = CubicHermiteSpline(t_s[knots], trajectory.com_m[knots], trajectory.com_velocity_m_s[knots])
    power, torque = power_and_torque(model, times, com(times), com(times, 1), angle(times), angle(times, 1))

    def summed(values: Array) -> Array:
        total: Array = half_s * (values.reshape(nodes.shape) @ WEIGHTS)
        return total

    return {"energy_about_com": summed(power), "angular_momentum_about_com": summed(torque)}


def power_and_torque(
    model: ChainModel, t_s: Array, com_m: Array, com_velocity_m_s: Array, angle_rad: Array, rate_rad_s: Array
) -> tuple[Array, Array]:
    """Power (W) and torque (N m) of all fields about the centre of mass at k instants, (k,) each."""
    along, com = unit_along(angle_rad), as_complex(com_m)[:, None]
    place = bar_centres(model, model.half_m * along)
    velocity = bar_centres(model, 1j * model.half_m * rate_rad_s * along)
    pull = complex_field_differences(model.mu_m3_s2, com, place)
    turn = np.zeros_like(angle_rad)
    if model.gravity == "gradient":
        turn = gradient_angular_accelerations(model, com + place, along)
    fields = [effect for effect in model.effects if effect.name in FIELD_EFFECTS]
    for k, instant in enumerate(t_s if fields else ()):
        state = consistent_state(model, com_m[k], com_velocity_m_s[k], angle_rad[k], rate_rad_s[k])
        at = EffectState(model, float(instant), state, along[k])
        for field in fields:
            added = field.accelerations(at, None)
            pull[k] += added.difference
            turn[k] += added.angular
    force = model.mass_kg * pull
    moment = turn * model.inertia_kg_m2
    power: Array = np.sum((velocity.conj() * force).real + rate_rad_s * moment, axis=1)
    torque: Array = np.sum((place.conj() * force).imag + moment, axis=1)
    return power, torque


def rate_scale(scene: Scene, solution: Trajectory) -> float:
    """Fastest rate in the scene, rad/s: the chain's stiffest oscillation in its field or under its own spin."""
    return max(free_rate_scale(scene, solution), scene.spring_rate_rad_s)


def free_rate_scale(scene: Scene, solution: Trajectory) -> float:
    """Fastest rate of the chain without its springs, rad/s."""
    spin = float(np.abs(solution.rate_rad_s).max()) if solution.rate_rad_s is not None else 0.0
    return MODES_PER_BAR * scene.bars * max(spin, scene.mean_motion_rad_s)


def own_rate(scene: Scene) -> float:
    """Fastest of the orbit's and the bars' own initial rates, rad/s."""
    orbit = 2.0 * math.pi / scene.step_period_s
    turning = scene.orbital_rate_rad_s * max(1.0, *(abs(a) for a in scene.chain.rate_factor))
    return max(orbit, turning, scene.spring_rate_rad_s / (MODES_PER_BAR * scene.bars))


def orbit_rate(trajectory: Trajectory) -> Array:
    """Rate of the longitude of the centre of mass, (n,), rad/s."""
    z, v = trajectory.com_m, trajectory.com_velocity_m_s
    rate: Array = (z[:, 0] * v[:, 1] - z[:, 1] * v[:, 0]) / np.sum(z * z, axis=1)
    return rate
