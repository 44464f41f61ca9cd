"""Bounds on a chain's distance from its frame by the forces that act on the chain and not on the frame.

:func:`departure` is from a frame that stays on the first Kepler orbit, :func:`drift_bound_m` from one that falls freely
in all fields.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from operator import mul
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Drag, Scene


@dataclass(frozen=True)
class Departure:
    """Bounds over a run: an acceleration a leads to a distance of (3/2) a t² along the orbit, at a speed of 3 a t."""

    acceleration_m_s2: float
    """Acceleration relative to the frame"""
    distance_m: float
    speed_m_s: float

    def force_N(self, scene: Scene) -> float:
        """Largest resulting force on a bar: tide and Coriolis force of the frame, and the perturbing force itself."""
        rate = max(scene.orbital_rate_rad_s, scene.mean_motion_rad_s)
        own = 3.0 * rate**2 * self.distance_m + 2.0 * rate * self.speed_m_s + self.acceleration_m_s2
        return max(scene.chain.mass_kg) * own


def departure(scene: Scene) -> Departure:
    """Bounds of `scene`; zeros where no force acts relative to the frame."""
    push, t = sum(perturbing_accelerations_m_s2(scene)), scene.run.duration_s
    return Departure(
        push,
        min(1.5 * push * t**2, 2.0 * scene.radius0_m),
        min(3.0 * push * t, 2.0 * max(scene.speed0_m_s, scene.radius0_m * scene.mean_motion_rad_s)),
    )


def perturbing_accelerations_m_s2(scene: Scene) -> list[float]:
    """Acceleration of the lightest bars by each effect, at the initial altitude, m/s²."""
    effects, mu, r0 = scene.effects, scene.central_body.mu_m3_s2, scene.radius0_m
    found = [2.0 * body.mu_m3_s2 * r0 / body.distance_m**3 for body in effects.third_body]
    found += [max(map(abs, thrust.force_N)) / scene.mass_kg for thrust in effects.thrust]
    if effects.oblateness:
        found.append(1.5 * mu * effects.oblateness.j2 * effects.oblateness.radius_m**2 / r0**4)
    if effects.drag:
        found.append(drag_acceleration_m_s2(scene, effects.drag))
    if effects.solar_pressure:
        light = effects.solar_pressure
        found.append(light.pressure_Pa * (1.0 + light.reflectivity) * area_per_mass_m2_kg(scene, light.width_m))
    return found


def drag_acceleration_m_s2(scene: Scene, drag: Drag) -> float:
    """Drag acceleration normal to the wind, m/s²."""
    density = drag.density_kg_m3 * math.exp((drag.altitude_m - scene.orbit.altitude_m) / drag.scale_height_m)
    speed = scene.speed0_m_s + abs(drag.rotation_rad_s) * scene.radius0_m
    return 0.5 * density * drag.normal_coefficient * speed**2 * area_per_mass_m2_kg(scene, drag.width_m)


def area_per_mass_m2_kg(scene: Scene, width_m: tuple[float, ...]) -> float:
    """Largest area of a bar over its mass, m²/kg."""
    chain = scene.chain
    return max(b * length / m for b, length, m in zip(width_m, chain.length_m, chain.mass_kg, strict=True))


def drift_bound_m(scene: Scene) -> float:
    """Bound on the distance from a freely falling particle, m, to a factor of about two.

    It follows from the largest force on a circular orbit of rate n (Hill's equations).

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
