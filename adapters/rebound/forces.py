"""Accelerations of REBOUND's particle besides REBOUND's own gravity, and their callback.

Each is a plain function of time and position: m, s and m/s², relative to the central body. They act on a particle as on
the chain's centre of mass with all its mass there; none of them depends on an attitude.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenarios import Axes

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenarios import Scene
    from scenarios.effect_types import Oblateness, ThirdBody, Thrust

    Force = Callable[[float, float, float], tuple[float, float]]

SAME_RATE = 1e-14  # of its square: a few roundings


def forces(scene: Scene, start_s: float, end_s: float) -> list[Force]:
    """Forces between two successive events, continued smoothly beyond them; a massive `companion` excluded."""
    effects = scene.effects
    found = [] if effects.oblateness is None else [oblateness_force(scene.central_body.mu_m3_s2, effects.oblateness)]
    if companion(scene) is None:
        found += [third_body_force(body) for body in effects.third_body]
    for thrust in effects.thrust:
        found += thrust_forces(thrust, scene.mass_kg, 0.5 * (start_s + end_s))
    return found


def companion(scene: Scene) -> ThirdBody | None:
    """Third body that can be a massive particle: the only one, at the rate that the gravity of both bodies gives.

    Several bodies can not. As particles they would attract each other, and the central body would respond to all of
    them, so that none would stay on the scene's circle.
    """
    bodies, mu = scene.effects.third_body, scene.central_body.mu_m3_s2
    if len(bodies) != 1:
        return None
    pull = (mu + bodies[0].mu_m3_s2) / bodies[0].distance_m ** 3
    return bodies[0] if math.isclose(bodies[0].rate_rad_s ** 2, pull, rel_tol=SAME_RATE) else None


def oblateness_force(mu_m3_s2: float, body: Oblateness) -> Force:
    """Acceleration -3 B Z/r⁵ by oblateness, B = mu J2 R²/2."""
    strength = 1.5 * mu_m3_s2 * body.j2 * body.radius_m**2

    def pull(_t: float, x: float, y: float) -> tuple[float, float]:
        r2 = x * x + y * y
        k = -strength / (r2 * r2 * math.sqrt(r2))
        return k * x, k * y

    return pull


def third_body_force(body: ThirdBody) -> Force:
    """Tidal acceleration -mu (Y/|Y|³ + X/D³) by a third body at X, with Y = Z - X and D = |X|.

    Evaluated as (mu/D³) (f X - (1 + f) Z) with f = (D/|Y|)³ - 1, free of cancellation.
    """
    d2 = body.distance_m**2
    strength = body.mu_m3_s2 / (d2 * body.distance_m)

    def pull(t: float, x: float, y: float) -> tuple[float, float]:
        angle = body.longitude_rad + body.rate_rad_s * t
        bx, by = body.distance_m * math.cos(angle), body.distance_m * math.sin(angle)
        f = math.expm1(-1.5 * math.log1p((x * x + y * y - 2.0 * (bx * x + by * y)) / d2))
        return strength * (f * bx - (1.0 + f) * x), strength * (f * by - (1.0 + f) * y)

    return pull


def thrust_forces(thrust: Thrust, mass_kg: float, within_s: float) -> list[Force]:
    """Thrust along a fixed direction: the straight segment of its table at an instant; none outside the table.

    Raises
    ------
    ValueError
        If the thrust turns with a bar.
    """
    if thrust.axes is not Axes.INERTIAL:
        raise ValueError("REBOUND's particle has no attitude: thrust must have a fixed direction")
    pieces = zip(thrust.times_s, thrust.times_s[1:], thrust.force_N, thrust.force_N[1:], strict=False)
    c, s = math.cos(thrust.direction_rad) / mass_kg, math.sin(thrust.direction_rad) / mass_kg

    def segment_force(t0: float, t1: float, f0: float, f1: float) -> Force:
        def push(t: float, _x: float, _y: float) -> tuple[float, float]:
            size = f0 + (f1 - f0) * ((t - t0) / (t1 - t0))
            return size * c, size * s

        return push

    return [segment_force(*p) for p in pieces if p[0] < within_s < p[1]]


def attach(sim: Any, acting: list[Force], failed: list[Exception]) -> None:
    """Install forces on the last particle of a simulation, at its position relative to the first.

    ctypes prints and drops an exception of a callback. The callback therefore appends the exception to `failed` and
    stops the simulation.
    """
    centre, particle = sim.particles[0], sim.particles[sim.N - 1]

    def callback(pointer: Any) -> None:
        try:
            t, x, y = pointer.contents.t, particle.x - centre.x, particle.y - centre.y
            for force in acting:
                ax, ay = force(t, x, y)
                particle.ax += ax
                particle.ay += ay
        except Exception as error:
            failed.append(error)
            pointer.contents.stop()

    sim.additional_forces = callback  # which REBOUND's wrapper keeps referenced
