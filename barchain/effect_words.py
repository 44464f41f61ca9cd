"""A scene's effects and invariants in words and numbers, for the record of a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.quantities import angular_momentum_drift, conserved, energy_drift
from scenarios import Gravity

if TYPE_CHECKING:
    from adapters.engine import Trajectory
    from scenarios import Scene


def effect_words(scene: Scene) -> list[str]:
    """What acts besides gravity and prescribed rotations, one line each."""
    called = scene.effects
    found = []
    if called.oblateness:
        found.append(f"oblateness, J2 = {called.oblateness.j2:g}")
    found += [f"tide of the {b.name}, {b.distance_m / 1e3:g} km away" for b in called.third_body]
    if called.drag:
        d = called.drag
        found.append(f"drag in {d.density_kg_m3:g} kg/m³ at {d.altitude_m / 1e3:g} km")
    if called.solar_pressure:
        shadow = "with" if called.solar_pressure.shadow else "without"
        found.append(f"solar pressure of {called.solar_pressure.pressure_Pa:g} Pa, {shadow} shadow")
    if called.joint_spring_damper:
        springs = called.joint_spring_damper
        stiffest, strongest = max(springs.stiffness_N_m_rad), max(springs.damping_N_m_s_rad)
        found.append(f"joint springs up to {stiffest:g} N m/rad, dampers up to {strongest:g} N m s/rad")
    found += [f"thrust of up to {max(map(abs, t.force_N)):g} N on bar {t.bar}" for t in called.thrust]
    found += [f"blow of {p.impulse_N_s:g} N s on bar {p.bar} at {p.at_s:g} s" for p in called.impulse]
    return found


def invariant_words(scene: Scene) -> str:
    """Which invariants the scene has; why, where it is the gravity model that has none."""
    keeps = conserved(scene)
    kept = [name for name, stays in (("energy", keeps.energy), ("angular momentum", keeps.angular_momentum)) if stays]
    if kept:
        return " and ".join(kept)
    if scene.effects.gravity is Gravity.GRADIENT:
        return "neither energy nor angular momentum: the gradient's torque has no counterpart in its force"
    return "neither energy nor angular momentum: effects without a potential act"


def gradient_defect(scene: Scene, truth: Trajectory, horizon_s: float) -> dict[str, Any]:
    """How far the truth's energy and angular momentum go, relative, where only the gravity model lets them."""
    plain = scene.effects.gravity is Gravity.GRADIENT and not scene.effects.prescribed_rotation
    if not plain or scene.effects.more or truth.angle_rad is None:
        return {}
    inside = truth.t_s <= horizon_s
    size = max(scene.chain.length_m) / float(np.linalg.norm(truth.com_m, axis=1).min())
    return {
        "gradient_defect": {
            "energy": float(energy_drift(scene, truth, relative=False)[inside].max()),
            "angular_momentum": float(angular_momentum_drift(scene, truth, relative=False)[inside].max()),
            "size_squared": math.pow(size, 2),
        }
    }
