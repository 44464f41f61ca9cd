"""The track of the centre of mass beyond the predictability limit of the attitude: bounded, and not chaotic."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.scales import kepler_growth, orbit_rate_bound
from barchain.metrics.model_difference import SECOND_MOMENT_ACCELERATION, displacement_bound
from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

EITHER_WAY = 2.0
"""Factor of two parted attitudes, which may accelerate the track in opposite directions"""
ACROSS = 8.0
"""Largest swing beside the secular part by Hill's equations: 8 dv/n of a velocity step, 8 dv of the velocity itself"""


def parted_track_bound(solution: ReferenceSolution, t_s: Array, limit_s: float) -> dict[str, Array]:
    """Largest effect on the track of attitudes that part at the limit, (n,): ``com`` (m), ``com_velocity`` (m/s).

    The pull on a chain differs from that on a particle by mu I/(M r⁴) at most. Forces that depend on the attitude
    differ by their whole strength along the orbit: drag and sunlight from the limit on, thrusts and impulses in the
    axes of bars while they act. Those of fixed direction move the track alike at any attitude.

    A difference of accelerations a(s) displaces by the integral of a(s) times :func:`reach_s` of t - s.
    """
    scene = solution.scene
    since = np.maximum(t_s - limit_s, 0.0)
    if not since.any():
        return {}
    n = len(t_s)
    found = {"com": np.zeros(n), "com_velocity": np.zeros(n)}
    if scene.effects.gravity is not Gravity.NONE and scene.bound:
        for name, moved in displacement_bound(scene, since, EITHER_WAY * SECOND_MOMENT_ACCELERATION).items():
            found[name] = np.where(since > 0.0, moved, 0.0)
    at_s, gained = velocity_steps(solution, limit_s)
    if not gained.any():
        return found
    rate = orbit_rate_bound(scene, solution.trajectory)
    for k in np.flatnonzero(since):
        earlier = at_s < t_s[k]
        elapsed = t_s[k] - at_s[earlier]
        moved_m = float(gained[earlier] @ reach_s(scene, elapsed))
        found["com"][k] += moved_m
        grown = kepler_growth(scene, elapsed)
        if closed(scene):
            grown = np.minimum(grown, ACROSS * ratio_of_speeds(scene))
        found["com_velocity"][k] += float(gained[earlier] @ grown) + rate * moved_m
    return found


def velocity_steps(solution: ReferenceSolution, limit_s: float) -> tuple[Array, Array]:
    """Instants from the limit on, (m,) s, and largest differences of velocity that attitudes make in each, (m,) m/s.

    The velocity gained in an interval counts from its beginning.
    """
    scene, fine = solution.scene, solution.fine
    pushes = [thrust for thrust in scene.effects.thrust if thrust.axes is Axes.BODY]
    knots = [t for thrust in pushes for t in thrust.times_s]
    at_s: Array = np.unique([limit_s, *fine.t_s[fine.t_s > limit_s], *(t for t in knots if t > limit_s)])
    interval_s, middle_s = np.diff(at_s), 0.5 * (at_s[:-1] + at_s[1:])
    strength = face_acceleration_m_s2(solution, middle_s)
    for thrust in pushes:  # linear inside an interval, so that its middle has its mean
        strength += EITHER_WAY * np.array([abs(thrust.size_N(t)) for t in middle_s]) / scene.mass_kg
    struck = [push for push in scene.effects.impulse if push.axes is Axes.BODY and push.at_s >= limit_s]
    steps = [EITHER_WAY * abs(push.impulse_N_s) / scene.mass_kg for push in struck]
    return np.append(at_s[:-1], [push.at_s for push in struck]), np.append(interval_s * strength, steps)


def face_acceleration_m_s2(solution: ReferenceSolution, t_s: Array) -> Array:
    """Largest difference of the accelerations by drag and sunlight at any two attitudes, (m,) m/s².

    A flat bar's force at all its attitudes lies on a closed curve through zero, whose diameter is the force on the bar
    face on: drag times the larger coefficient, light times 1 + reflectivity. Air counts at the chain's lowest end, and
    the ends' own speed adds to the wind.
    """
    scene, fine = solution.scene, solution.fine
    drag, light = scene.effects.drag, scene.effects.solar_pressure
    force = np.zeros(len(t_s))
    if light:
        area = float(np.dot(light.width_m, scene.chain.length_m))
        force += light.pressure_Pa * (1.0 + light.reflectivity) * area
    if drag:
        area = float(np.dot(drag.width_m, scene.chain.length_m))
        turned = drag.rotation_rad_s * np.stack([-fine.com_m[:, 1], fine.com_m[:, 0]], axis=1)
        spin = 0.0 if fine.rate_rad_s is None else float(np.abs(fine.rate_rad_s).max())
        reach_m = scene.size_m
        wind = np.linalg.norm(fine.com_velocity_m_s - turned, axis=1) + (spin + abs(drag.rotation_rad_s)) * reach_m
        height = np.linalg.norm(fine.com_m, axis=1) - reach_m - scene.central_body.radius_m - drag.altitude_m
        density = drag.density_kg_m3 * np.exp(-height / drag.scale_height_m)
        coefficient = max(drag.normal_coefficient, drag.tangential_coefficient)
        force += np.interp(t_s, fine.t_s, 0.5 * density * coefficient * area * wind**2)
    found: Array = force / scene.mass_kg
    return found


def reach_s(scene: Scene, since_s: Array) -> Array:
    """Largest displacement by a velocity step of 1 m/s after a time, (n,) m: 3 t along the orbit by Hill's equations.

    On an ellipse the secular part is (1 + e)/(1 - e) times as large where the speed is largest.
    """
    grown = since_s * kepler_growth(scene, since_s)
    if not closed(scene):
        return grown
    swing = np.where(since_s > 0.0, ACROSS / scene.mean_motion_rad_s, 0.0)
    return np.minimum(grown, ratio_of_speeds(scene) * (3.0 * since_s + swing))


def closed(scene: Scene) -> bool:
    """Whether the orbit is an ellipse with a finite ratio of speeds."""
    return scene.effects.gravity is not Gravity.NONE and scene.bound and scene.orbit.eccentricity < 1.0


def ratio_of_speeds(scene: Scene) -> float:
    """Speed at perigee over speed at apogee, (1 + e)/(1 - e)."""
    eccentricity = scene.orbit.eccentricity
    return (1.0 + eccentricity) / (1.0 - eccentricity)
