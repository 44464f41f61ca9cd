"""Entry of a scene in a record: its values, its effects and invariants in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from barchain.metrics.quantities import angular_momentum_drift, conserved, energy_drift
from scenarios import Actuator, Axes, Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from scenarios import Impulse, Scene, Thrust


BODIES = {"moon": "the Moon", "sun": "the Sun"}


class Loss(NamedTuple):
    """Reason why energy or angular momentum is not conserved."""

    words: str
    energy: bool = True
    angular_momentum: bool = True


def effect_words(scene: Scene) -> list[str]:
    """Effects besides gravity and prescribed rotations, one line each."""
    called = scene.effects
    found = []
    if called.oblateness:
        found.append(f"oblateness, J2 = {called.oblateness.j2:g}")
    found += [
        f"tide of {BODIES.get(b.name, 'a third body')}, {b.distance_m / 1e3:g} km away" for b in called.third_body
    ]
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
    found += [
        f"torque of up to {max(map(abs, m.torque_N_m)):g} N m in joint {m.joint}, "
        f"from {m.times_s[0]:g} to {m.times_s[-1]:g} s"
        for m in called.joint_torque
    ]
    found += [
        f"thrust of up to {max(map(abs, t.force_N)):g} N on {push_words(t)}, "
        f"from {t.times_s[0]:g} to {t.times_s[-1]:g} s"
        for t in called.thrust
    ]
    found += [f"impulse of {p.impulse_N_s:g} N s on {push_words(p)}, at {p.at_s:g} s" for p in called.impulse]
    return found


def push_words(push: Thrust | Impulse) -> str:
    """Point and direction of a thrust or an impulse: ``the right end of bar 2, at 90° from the bar``."""
    origin = "the bar" if push.axes is Axes.BODY else "the z1 axis"
    return f"the {push.end} end of bar {push.bar}, at {math.degrees(push.direction_rad):.6g}° from {origin}"


def invariant_words(scene: Scene) -> str:
    """Invariants of the scene, and every reason why another is not conserved."""
    keeps, lost = conserved(scene), losses(scene)
    if keeps.energy and keeps.angular_momentum:
        return "energy and angular momentum"
    if keeps.energy:
        return f"energy; not angular momentum: {'; '.join(x.words for x in lost if x.angular_momentum)}"
    if keeps.angular_momentum:
        return f"angular momentum; not energy: {'; '.join(x.words for x in lost if x.energy)}"
    return f"neither energy nor angular momentum: {'; '.join(x.words for x in lost)}"


def losses(scene: Scene) -> list[Loss]:
    """Reasons why invariants are not conserved: effects without a potential first, then the gravity model."""
    called = scene.effects
    springs, laws = called.joint_spring_damper, called.prescribed_rotation
    outside = any(p.actuator is Actuator.EXTERNAL for p in laws)
    found = [
        (called.drag, Loss("drag has no potential")),
        (called.solar_pressure, Loss("solar pressure has no potential")),
        (called.thrust, Loss("a thrust has no potential")),
        (called.impulse, Loss("an impulse has no potential")),
        (springs and any(springs.damping_N_m_s_rad), Loss("dampers dissipate energy", angular_momentum=False)),
        (called.joint_torque, Loss("motors in joints do work", angular_momentum=False)),
        (laws, Loss("prescribed rotations do work", angular_momentum=False)),
        (outside, Loss("their torques are external", energy=False)),
        (called.third_body, Loss("a third body's potential rotates with it")),
        (called.gravity is Gravity.GRADIENT, Loss("the gravity-gradient torque has no counterpart in the force")),
    ]
    return [loss for acts, loss in found if acts]


def gradient_defect(scene: Scene, solution: Trajectory, limit_s: float) -> dict[str, Any]:
    """Relative drift of the judging solution's energy and angular momentum by the gravity model alone.

    Empty for a scene with another reason for a drift.
    """
    plain = scene.effects.gravity is Gravity.GRADIENT and not scene.effects.prescribed_rotation
    if not plain or scene.effects.beyond_basic or solution.angle_rad is None:
        return {}
    inside = solution.t_s <= limit_s
    size = max(scene.chain.length_m) / float(np.linalg.norm(solution.com_m, axis=1).min())
    return {
        "gradient_defect": {
            "energy": float(energy_drift(scene, solution, relative=False)[inside].max()),
            "angular_momentum": float(angular_momentum_drift(scene, solution, relative=False)[inside].max()),
            "size_squared": math.pow(size, 2),
        }
    }


def scene_facts(scene: Scene) -> dict[str, Any]:
    """Entry of a scene in the record; lengths in m, times in s."""
    return {
        "title": scene.title,
        "source": scene.source,
        "description": scene.description,
        "tags": list(scene.tags),
        "digest": scene.digest,
        "bars": scene.bars,
        "length_m": list(scene.chain.length_m),
        "mass_kg": list(scene.chain.mass_kg),
        "angle_deg": [math.degrees(angle) for angle in scene.chain.angle_rad],
        "angle_from": scene.chain.angle_from,
        "rate_factor": list(scene.chain.rate_factor),
        "period_s": scene.period_s,
        "duration_s": scene.run.duration_s,
        "samples": scene.run.samples,
        "gravity": str(scene.effects.gravity),
        "effects": effect_words(scene),
        "conserved": invariant_words(scene),
        "radius0_m": scene.radius0_m,
        "speed_factor": scene.orbit.speed_factor,
        "flight_path_deg": math.degrees(scene.orbit.flight_path_rad),
        "eccentricity": scene.orbit.eccentricity,
        "end_bodies": list(scene.chain.bodies),
        "com_share": list(scene.chain.com_share),
        "body_radius_m": scene.central_body.radius_m,
        "mean_motion_rad_s": scene.mean_motion_rad_s,
        "prescribed": [
            {
                "bar": p.bar,
                "amplitude_deg": math.degrees(turn.amplitude_rad),
                "start_s": turn.start_s,
                "duration_s": turn.duration_s,
                "frame": str(p.frame),
                "actuator": str(p.actuator),
            }
            for p in scene.effects.prescribed_rotation
            for turn in p.turns
        ],
    }


def scene_words(scene: Scene) -> dict[str, Any]:
    """Entry of a scene in a study's record."""
    return {
        "title": scene.title,
        "source": scene.source,
        "orbits": scene.run.duration_s / scene.period_s,
        "duration_s": scene.run.duration_s,
        "samples": scene.run.samples,
        "bars": scene.bars,
    }
