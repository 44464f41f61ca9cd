"""Bound on the distance between a chain and a freely falling particle, due to drag, light, thrusts and impulses."""

from __future__ import annotations

import math
from operator import mul
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Scene


def drift_bound_m(scene: Scene) -> float:
    """Bound in m, to a factor of about two, by the largest force on a circular orbit of rate n (Hill's equations).

    A change of velocity leads to a distance of 3 t + 4/n times that change after a time t. A constant acceleration
    leads to (3/2) t² + 4 t/n times that acceleration.
    """
    t, n = scene.run.duration_s, 2.0 * math.pi / scene.step_period_s
    gained = math.fsum(abs(impulse.impulse_N_s) for impulse in scene.effects.impulse) / scene.mass_kg
    return gained * (3.0 * t + 4.0 / n) + largest_acceleration_m_s2(scene) * t * (1.5 * t + 4.0 / n)


def largest_acceleration_m_s2(scene: Scene) -> float:
    """Acceleration of the whole chain at the injection altitude, every bar normal to the flow and to the Sun."""
    called, length, force = scene.effects, scene.chain.length_m, 0.0
    if called.drag:
        drag = called.drag
        area = sum(map(mul, drag.width_m, length))
        density = drag.density_kg_m3 * math.exp((drag.altitude_m - scene.orbit.altitude_m) / drag.scale_height_m)
        coefficient = max(drag.normal_coefficient, drag.tangential_coefficient)
        force += 0.5 * density * area * coefficient * scene.speed0_m_s**2
    if called.solar_pressure:
        light = called.solar_pressure
        force += light.pressure_Pa * (1.0 + light.reflectivity) * sum(map(mul, light.width_m, length))
    force += math.fsum(max(abs(f) for f in thrust.force_N) for thrust in called.thrust)
    return force / scene.mass_kg
