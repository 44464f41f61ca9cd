"""Compared quantities: differences of two trajectories, and drifts of one trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model
from barchain.metrics.balance import balanced, imbalance
from barchain.metrics.joint_gaps import measured
from reference_impl.model import invariants
from scenarios import Actuator, Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene


def differences(a: Trajectory, b: Trajectory) -> dict[str, Array]:
    """Largest difference over bars or joints at each common sample, for each quantity that both have.

    Returns
    -------
    dict
        ``com`` (m), ``com_velocity`` (m/s), ``attitude`` (rad), ``rate`` (rad/s), ``reaction`` (N), ``torque`` (N m),
        ``impulse`` (N s), each (n,).
        Quantities without components (reactions of a single bar) are left out.
    """
    n = min(len(a.t_s), len(b.t_s))
    pairs = {
        "com": (a.com_m[:, None, :], b.com_m[:, None, :]),
        "com_velocity": (a.com_velocity_m_s[:, None, :], b.com_velocity_m_s[:, None, :]),
        "attitude": (scalars(a.angle_rad), scalars(b.angle_rad)),
        "rate": (scalars(a.rate_rad_s), scalars(b.rate_rad_s)),
        "reaction": (a.reaction_N, b.reaction_N),
        "torque": (scalars(a.torque_N_m), scalars(b.torque_N_m)),
        "impulse": (a.impulse_N_s, b.impulse_N_s),
    }
    return {
        name: np.linalg.norm(x[:n] - y[:n], axis=-1).max(axis=-1)
        for name, (x, y) in pairs.items()
        if x is not None and y is not None and x.shape[1] and y.shape[1]
    }


def scalars(values: Array | None) -> Array | None:
    """(n, k) as (n, k, 1), so that a norm over the last axis is an absolute value."""
    return None if values is None else values[:, :, None]


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
    (:mod:`barchain.metrics.balance`).
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
    return scene.orbital_rate_rad_s or 2.0 * np.pi / scene.step_period_s


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


def largest(trajectory: Trajectory) -> dict[str, Array]:
    """Largest value of each quantity so far, (n,), which scales its round-off."""
    values = {
        "com": trajectory.com_m[:, None, :],
        "com_velocity": trajectory.com_velocity_m_s[:, None, :],
        "attitude": trajectory.angle_rad[:, :, None] if trajectory.angle_rad is not None else None,
        "rate": trajectory.rate_rad_s[:, :, None] if trajectory.rate_rad_s is not None else None,
        "reaction": trajectory.reaction_N,
        "torque": trajectory.torque_N_m[:, :, None] if trajectory.torque_N_m is not None else None,
        "impulse": trajectory.impulse_N_s,
    }
    return {
        name: np.maximum.accumulate(np.linalg.norm(x, axis=-1).max(axis=-1))
        for name, x in values.items()
        if x is not None and x.shape[1]
    }
